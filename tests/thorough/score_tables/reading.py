"""What a document of `motorlab diagnose` claims, whichever its shape: motorlab-diagnosis/1, /2 and /3."""

from dataclasses import dataclass, field

# Ties that one recording seldom separates, as the contract of motorlab-diagnosis/3 has them.
CLASSES = {
    "direction_offset": {"asymmetric_friction", "constant_load", "asymmetric_voltage_drop", "asymmetric_dead_zone"},
    "direction_gain": {"asymmetric_viscous", "asymmetric_gain"},
    "large_command": {"supply_sag", "current_limit", "winding_heating", "quadratic_drag"},
    "start": {"static_friction", "stribeck", "dead_zone"},
    "lag": {"transport_delay", "speed_filter", "inductance", "command_offset"},
    "driving": {"load_friction", "voltage_drop"},
}
QUIET = ("no_gap", "parameters", "no_change")
NO_EFFECT = ("none", "unknown", "parameters", "")


@dataclass(frozen=True)
class Claim:
    """One of these effects is present, with this probability."""

    members: frozenset
    probability: float

    def words(self):
        return "|".join(sorted(self.members))


@dataclass
class Reading:
    """A document's claims."""

    verdict: str
    probability: float
    claims: list
    inclusion: dict
    sets: list
    gap: dict = field(default_factory=dict)

    def is_quiet(self):
        return self.verdict in QUIET

    def of_set(self, ids):
        """Probability of exactly this set of effects."""
        return min(1.0, sum(p for effects, p in self.sets if effects == frozenset(ids)))

    def of_effect(self, effect):
        """Inclusion probability."""
        return min(1.0, self.inclusion.get(effect, 0.0))

    def of_class(self, effect):
        """Probability that the effect or another member of its classes is present."""
        family = family_of(effect)
        of_sets = min(1.0, sum(p for effects, p in self.sets if effects & family))
        claimed = [claim.probability for claim in self.claims if effect in claim.members]
        return max([of_sets, self.of_effect(effect), *claimed])

    def first(self):
        """The effect with the highest inclusion probability, or none."""
        return max(self.inclusion, key=self.inclusion.get, default=None)

    def words(self):
        """The claim on one line."""
        named = " + ".join(claim.words() for claim in self.claims)
        return f"{self.verdict} {self.probability:.2f}" + (f": {named}" if named else "")


def family_of(effect):
    """The effect with the other members of its classes."""
    return frozenset({effect}.union(*(members for members in CLASSES.values() if effect in members)))


def plain_id(effect):
    """`cogging#2` is cogging: a second order of what repeats with the angle."""
    return effect.split("#")[0]


def ids_of(text):
    return frozenset(plain_id(part.strip()) for part in text.split("+") if part.strip() not in NO_EFFECT)


def read(document):
    """The claims of a document; none of `bad_recording`."""
    verdict = document["verdict"]
    causes = document.get("causes") or []
    sets = [(ids_of("+".join(one["effects"])), one["probability"]) for one in document.get("sets") or []]
    inclusion = {}
    for effects, p in sets:
        for effect in effects:
            inclusion[effect] = inclusion.get(effect, 0.0) + p
    for cause in causes:
        ids = ids_of(cause["effect"])
        if len(ids) == 1:
            said = cause.get("inclusion")
            inclusion[next(iter(ids))] = cause["probability"] if said is None else said
    said = document.get("probability")
    reading = Reading(verdict, 0.0 if said is None else said, [], inclusion, sets, document.get("gap") or {})
    if verdict != "bad_recording":
        is_third = document["shape"].endswith("/3")
        reading.claims = claims_of_third(document, reading) if is_third else claims_of_second(document, reading, causes)
    return reading


def claims_of_third(document, reading):
    """Shape /3: each identified effect with its inclusion probability; a class stands for its most probable member, with its own."""
    listed = [one if isinstance(one, dict) else {"class": one} for one in document.get("classes") or []]
    listed += [{"class": effect} for effect in document["effects"] if effect in CLASSES]
    claims = {}
    for one in listed:
        name = one.get("class") or one.get("id") or one.get("name") or one.get("effect")
        if name in claims:
            continue
        members = frozenset(map(plain_id, one.get("members") or one.get("effects") or CLASSES.get(name, ())))
        said = next((one[key] for key in ("probability", "inclusion") if one.get(key) is not None), None)
        if said is None:
            said = min(1.0, sum(p for effects, p in reading.sets if effects & members))
        claims[name] = Claim(members, said)
    of_class = frozenset().union(*(claim.members for claim in claims.values()))
    alone = dict.fromkeys(plain_id(effect) for effect in document["effects"] if effect not in CLASSES)
    return [Claim(frozenset({effect}), reading.of_effect(effect)) for effect in alone if effect not in of_class] + list(claims.values())


def claims_of_second(document, reading, causes):
    """Shapes /1 and /2: the verdict's probability is that of what it names; `ambiguous` names a cause and what it is not told from."""
    named = [plain_id(effect) for effect in document["effects"]]
    if named and reading.verdict in ("effect", "partial"):
        return [Claim(frozenset({effect}), reading.probability) for effect in named]
    if reading.verdict not in ("ambiguous", "partial"):
        return []
    # `partial` without a name says in words that one of a tie is present, beside something unknown.
    leading = next((one for one in causes if reading.verdict == "ambiguous" or ids_of(one["effect"])), None)
    if leading is None or not ids_of(leading["effect"]):
        return []
    of_class = {ids_of(other["effect"]) for other in causes if leading.get("class") and other.get("class") == leading["class"]}
    tied = {ids_of(text) for text in leading.get("indistinguishable_from") or []} | of_class
    ids = ids_of(leading["effect"])
    if len(ids) == 1:
        return [Claim(ids.union(*(one for one in tied if len(one) == 1)), reading.probability)]
    claims = []
    for effect in sorted(ids):
        # One member exchanged for another is the same claim about the rest.
        others = {next(iter(one - (ids - {effect}))) for one in tied if len(one) == len(ids) and len(one - (ids - {effect})) == 1}
        claims.append(Claim(frozenset({effect} | others), reading.probability))
    return claims

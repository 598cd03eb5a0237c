"""Error budget and identified effects."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any, Callable, Iterable, Optional, Sequence, Union

from . import _motorlab
from ._frames import frame_of, table_of
from ._html import paragraph, table
from ._motor import Motor
from ._run import Run
from ._verbs import Findings, runs_of

# Keys of a parameter with its interval.
_INTERVAL = ("value", "lo95", "hi95", "unit", "reference")

# Ends of keys that name a unit which an assumed resistance stands behind.
_ASSUMED = re.compile("_(nm|nm_s_per_rad|nm_s2_per_rad2|kg_m2|a|ohm|h|per_w)$")


def _in_python(sentence: str) -> str:
    """The next step as a call, where the command to copy has no files to name."""
    before, _, command = sentence.rpartition(": `motorlab diagnose ")
    if not before or "RUN" not in command:
        return sentence
    written = re.search(r"--(model-out|html) ([^ `]+)", command)
    if written is None:
        motor = ", motor" if "MOTOR.toml" in command else ""
        call = f'motorlab.diagnose([motorlab.Run.read("next.csv"), *found.runs]{motor})'
    elif written[1] == "html":
        call = f'found.html("{written[2]}")'
    else:
        call = f'found.motor.save("{written[2]}")'
    rest = command.partition("`")[2]
    return f"{before}: `{call}`{rest}"


def _determined(name: str, interval: dict[str, Any]) -> dict[str, Any]:
    """A parameter as the runs determine it: in SI, or in units of the command."""
    if "in_command" in interval:
        return {"parameter": _ASSUMED.sub("", name), **interval["in_command"]}
    return {"parameter": name, **interval}


class Diagnosis:
    """A diagnosis. ``document`` is the document ``motorlab-diagnosis/3``; the rest are parts of it."""

    def __init__(self, found: _motorlab.Diagnosis, runs: Sequence[Run]) -> None:
        self._found = found
        self.runs = list(runs)
        self.document: dict[str, Any] = json.loads(found.document())
        self.document["sentence"] = _in_python(self.document["sentence"])

    @property
    def verdict(self) -> str:
        """bad_recording, no_gap, parameters, effect, partial, ambiguous, outside_catalogue or no_change."""
        return self.document["verdict"]

    @property
    def sentence(self) -> str:
        """The verdict in sentences."""
        return self.document["sentence"]

    @property
    def probability(self) -> float:
        """Probability that all identified effects, or members of their classes, are present; where none is identified, see ``verdict``."""
        return self.document["probability"]

    @property
    def effects(self) -> list[str]:
        """Ids of the identified effects."""
        return self.document["effects"]

    @property
    def note(self) -> str:
        """Reservations; empty where there are none."""
        return self.document.get("note", "")

    @property
    def findings(self) -> Findings:
        """Findings of ``check`` about the recordings."""
        return Findings(self.document["data"])

    @property
    def budget(self) -> Any:
        """The error budget: a row per step, with the share of the nominal squared error above the noise floor that it removes (of ``unexplained``: that remains)."""
        rows = [
            {**step, "alternatives": ", ".join(f"{one['effect']} {one['probability']:.2f}" for one in step["alternatives"])}
            for step in self.document["budget"]
        ]
        return table_of(rows, ["step", "rms_counts", "share", "lo95", "hi95", "alternatives"])

    @property
    def causes(self) -> Any:
        """A row per effect with its inclusion probability, most probable first."""
        return table_of(self.document["causes"], ["effect", "stage", "inclusion", "class", "class_probability", "at_bound"])

    @property
    def sets(self) -> Any:
        """A row per set of effects, joined by ``+``; ``none`` has no effect. The probabilities add to 1."""
        rows = [{**one, "effects": "+".join(one["effects"]) or "none"} for one in self.document["sets"]]
        return table_of(rows, ["effects", "probability", "score", "rms_counts"])

    @property
    def parameters(self) -> Any:
        """A row per parameter with its 95 % interval: those of the motor that the runs determine (no ``effect``), then those of effects.

        Where no torque is known, those of effects are in units of the command, as the runs determine them.
        """
        found = self.document["identifiable"] or {}
        rows = [{"effect": None, "parameter": name, **interval} for name, interval in found.items() if name != "si"]
        for cause in self.document["causes"]:
            for name, interval in cause["parameters"].items():
                rows.append({"effect": cause["effect"], **_determined(name, interval)})
        return table_of(rows, ["effect", "parameter", *_INTERVAL])

    @property
    def identifiable(self) -> Any:
        """A row per parameter of the motor that the runs determine, with its 95 % interval."""
        found = self.document["identifiable"] or {}
        rows = [{"parameter": name, **interval} for name, interval in found.items() if name != "si"]
        return table_of(rows, ["parameter", *_INTERVAL])

    @property
    def gap(self) -> Any:
        """A row per nested model with its position error in counts RMS: held out, and on the data that it was fitted to."""
        gap = self.document["gap"]
        models = [] if gap is None else ["before", "after_parameters", "after_effect"]
        return frame_of(
            {
                "model": models,
                "held_out_counts": [gap[model] for model in models],
                "fitted_counts": [gap["fitted"][model] for model in models],
                "floor_counts": [gap["floor"] for _ in models],
            }
        )

    @property
    def regions(self) -> Any:
        """A row per time interval of a run with its share of the squared error above the noise floor."""
        place = self.document["where"] or {"regions": []}
        return table_of(place["regions"], ["run", "from_s", "to_s", "regime", "share"])

    @property
    def next_experiment(self) -> Optional[dict[str, Any]]:
        """Next experiment, if a recording separates the remaining sets."""
        return self.document["next_experiment"]

    def _motor(self, at: int) -> Optional[Motor]:
        motors = self._found.motors()
        return None if motors is None else Motor._of(motors[at])

    @property
    def motor(self) -> Optional[Motor]:
        """The motor of the verdict; none of a bad recording."""
        return self._motor(2)

    @property
    def nominal(self) -> Optional[Motor]:
        """The nominal motor."""
        return self._motor(0)

    @property
    def refitted(self) -> Optional[Motor]:
        """The motor with re-identified parameters, without any effect."""
        return self._motor(1)

    def explain(self) -> str:
        """The search: the sets screened and fitted in each round."""
        return self._found.explained()

    def html(self, path: Union[str, os.PathLike[str]], *, overwrite: bool = False) -> Path:
        """Write everything as one page that needs no network. One that exists is replaced only with ``overwrite``."""
        page = self._found.page("Diagnosis of the sim-to-real gap")
        with open(path, "w" if overwrite else "x", encoding="utf-8") as file:
            file.write(page)
        return Path(path)

    def plot(self, axes: Any = None) -> Any:
        """The first run with nominal and diagnosed motor, the error budget and the causes, with matplotlib. Axes of shape (3,)."""
        from ._plot import plot_diagnosis

        return plot_diagnosis(self, axes)

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}, P = {self.probability:.2f}): {self.sentence}"

    def _repr_html_(self) -> str:
        document = self.document
        parts = [paragraph(self.sentence, strong=True)]
        if self.note:
            parts.append(paragraph(self.note))
        if document["budget"]:
            rows = [
                [
                    step["step"],
                    f"{step['rms_counts']:.3g}",
                    f"{step['share']:.1%}",
                    f"{step['lo95']:.1%} to {step['hi95']:.1%}",
                ]
                for step in document["budget"]
            ]
            parts.append(table(["step", "held-out RMS (counts)", "share of squared error", "95 % interval"], rows))
        if document["causes"]:
            rows = [
                [one["effect"], one["stage"], f"{one['inclusion']:.2f}", one.get("class", "")]
                for one in document["causes"]
            ]
            parts.append(table(["effect", "stage", "inclusion probability", "class"], rows))
        if self.findings:
            parts.append(self.findings._repr_html_())
        return "".join(parts)


def diagnose(
    runs: Union[Run, Iterable[Run]],
    motor: Optional[Motor] = None,
    *,
    hold_out: Union[Run, Iterable[Run]] = (),
    reference: Union[Run, Iterable[Run]] = (),
    repeats: Iterable[Iterable[Run]] = (),
    good_enough_counts: Optional[float] = None,
    good_enough_share: Optional[float] = None,
    despite_findings: bool = False,
    nominal: Optional[str] = None,
) -> Diagnosis:
    """Diagnose the error between runs and simulation: its budget, the effects that cause it, the unexplained rest.

    Ctrl-C interrupts it; the interpreter's lock is free while it runs.

    Parameters
    ----------
    runs
        A run or several of the same motor: other sample times and profiles tell more.
    motor
        The nominal motor. Without one it is fitted to runs that were imported, else the lab handout's.
    hold_out
        Held-out runs: nothing is fitted to them and nothing is chosen by them; the error budget is measured on them.
    reference
        Earlier runs of the same axis: the diagnosis is of what has changed since.
    repeats
        Groups of runs that repeat each other, beside those that have the same commands.
    good_enough_counts, good_enough_share
        A position error that is accepted, in counts or as a share of the travel (0.01 is 1 %): part of the noise floor.
    despite_findings
        Diagnose recordings with a fatal finding too; the note then says so.
    nominal
        ``file`` or ``fit``: whether the nominal motor is fitted to the runs first.

    Examples
    --------
    >>> import numpy as np
    >>> from motorlab import simulate
    >>> t = np.arange(0, 4, 0.01)
    >>> u = np.where(t % 1 < 0.5, 4.5, -2.0)
    >>> counts = simulate(Motor(), t_s=t, command=u, output="counts")
    >>> run = Run.from_frame({"t_s": t, "command_v": u, "counts": counts}, counts_per_rev=720, supply_v=4.5)
    >>> diagnose(run, Motor()).verdict
    'no_gap'
    """
    runs = runs_of(runs)
    plain: Callable[[Iterable[Run]], list[_motorlab.Run]] = lambda several: [run._run for run in several]
    asked = {
        "hold_out": plain(runs_of(hold_out)),
        "reference": plain(runs_of(reference)),
        "repeats": [[_place(run, runs) for run in group] for group in repeats],
        "good_enough_counts": good_enough_counts,
        "good_enough_share": good_enough_share,
        "despite_findings": despite_findings,
        "nominal": nominal,
    }
    found = _motorlab.diagnose(plain(runs), None if motor is None else motor._motor, asked)
    return Diagnosis(found, runs)


def _place(run: Run, runs: Sequence[Run]) -> int:
    for at, other in enumerate(runs):
        if other is run:
            return at
    raise ValueError("repeats names a run that is not among those that are diagnosed")

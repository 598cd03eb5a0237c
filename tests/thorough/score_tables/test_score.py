"""Claims of each shape of document, and how they are judged; tests/thorough/run starts them."""

import unittest

from .judge import judge, reliability
from .program import Answer
from .reading import read

SETS = [{"effects": ["stribeck"], "probability": 0.5}, {"effects": ["static_friction"], "probability": 0.42}, {"effects": [], "probability": 0.08}]


def second(verdict, effects=(), causes=(), probability=0.9):
    document = {"shape": "motorlab-diagnosis/2", "verdict": verdict, "probability": probability, "effects": list(effects)}
    return document | {"causes": list(causes), "sets": [], "gap": {}, "data": []}


def third(verdict, effects=(), classes=(), probability=0.9, causes=(), sets=SETS):
    document = second(verdict, effects, causes, probability)
    return document | {"shape": "motorlab-diagnosis/3", "classes": list(classes), "sets": sets}


def cause(effect, inclusion, tied=()):
    return {"effect": effect, "probability": inclusion, "inclusion": inclusion, "indistinguishable_from": list(tied), "class": None}


def word(document, truth, kind="single"):
    return judge("case", truth, kind, Answer(document, None, 1.0, 1.0, 1.0)).word


class Reading(unittest.TestCase):
    def test_a_class_of_the_third_shape_is_one_claim_with_its_own_probability(self):
        for classes in (["start"], [{"class": "start"}], [{"id": "start", "members": ["stribeck", "static_friction"]}]):
            reading = read(third("effect", classes=classes))
            self.assertEqual(len(reading.claims), 1)
            self.assertIn("stribeck", reading.claims[0].members)
            self.assertAlmostEqual(reading.claims[0].probability, 0.92)
        self.assertEqual(word(third("effect", classes=["start"]), ["stribeck"]), "in class")

    def test_a_class_stands_for_the_member_among_the_effects(self):
        classes = [{"class": "start", "probability": 0.92, "members": ["stribeck", "static_friction"]}]
        reading = read(third("effect", ["stribeck"], classes))
        self.assertEqual([claim.words() for claim in reading.claims], ["static_friction|stribeck"])
        self.assertEqual(word(third("effect", ["stribeck"], classes), ["static_friction"]), "in class")

    def test_inclusion_is_the_sum_over_sets_where_no_cause_says_it(self):
        reading = read(third("effect", ["stribeck"]))
        self.assertAlmostEqual(reading.claims[0].probability, 0.5)
        self.assertAlmostEqual(reading.of_class("stribeck"), 0.92)
        self.assertEqual(read(third("effect", ["stribeck"], causes=[cause("stribeck", 0.7)])).claims[0].probability, 0.7)

    def test_a_second_order_is_the_same_effect(self):
        reading = read(third("effect", ["cogging", "cogging#2"], sets=[{"effects": ["cogging", "cogging#2"], "probability": 1.0}]))
        self.assertEqual(reading.of_set(["cogging"]), 1.0)

    def test_a_tie_of_the_second_shape_is_one_claim(self):
        document = second("ambiguous", causes=[cause("stribeck", 0.5, ["dead_zone", "none"])])
        self.assertEqual(read(document).claims[0].members, {"stribeck", "dead_zone"})
        self.assertEqual(word(document, ["dead_zone"]), "in class")


class Judging(unittest.TestCase):
    def test_words(self):
        self.assertEqual(word(third("effect", ["stribeck"]), ["stribeck"]), "right")
        self.assertEqual(word(third("effect", ["stribeck"]), ["static_friction"]), "neighbour")
        self.assertEqual(word(third("effect", ["stribeck", "inertia"]), ["stribeck"]), "with a false one")
        self.assertEqual(word(third("partial", ["stribeck"]), ["stribeck", "gravity_load"], "pair"), "part")
        self.assertEqual(word(third("parameters"), ["coulomb_friction"]), "as parameters")
        self.assertEqual(word(third("parameters"), ["backlash"]), "missed")
        self.assertEqual(word(third("no_gap"), [], "none"), "right")
        self.assertEqual(word(third("ambiguous"), ["backlash"]), "unknown")
        self.assertEqual(word(third("bad_recording"), ["backlash"]), "no answer")

    def test_named_with_ninety_percent_and_false_is_wrong_and_sure(self):
        said = third("effect", ["gravity_load"], causes=[cause("gravity_load", 0.95)])
        case = judge("case", ["cogging"], "single", Answer(said, None, 1.0, 1.0, 1.0))
        self.assertEqual((case.word, case.sure_false), ("wrong", ["gravity_load"]))
        case = judge("case", ["cogging"], "single", Answer(said, None, 1.0, 1.0, 1.0), plausible=["gravity_load"])
        self.assertEqual(case.sure_false, [])

    def test_reliability_sorts_by_tenths(self):
        self.assertEqual(reliability([[0.05, False], [1.0, True]]), {"0.0 to 0.1": [1, 0.05, 0.0], "0.9 to 1.0": [1, 1.0, 1.0]})


if __name__ == "__main__":
    unittest.main()

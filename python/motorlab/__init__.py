"""Record a DC motor, simulate it, compare the two, and diagnose the sim-to-real gap.

Everything is in SI and says its unit in its name.

>>> import motorlab as ml
>>> motor = ml.Motor()
>>> motor.resistance_ohm
10.0
"""

from ._bench import Design, capture, design, effects, export
from ._diagnosis import Diagnosis, diagnose
from ._motor import Motor
from ._motorlab import MotorlabError, __version__
from ._run import Run
from ._verbs import Comparison, Finding, Findings, check, compare, simulate

__all__ = [
    "Comparison",
    "Design",
    "Diagnosis",
    "Finding",
    "Findings",
    "Motor",
    "MotorlabError",
    "Run",
    "__version__",
    "capture",
    "check",
    "compare",
    "design",
    "diagnose",
    "effects",
    "export",
    "simulate",
]

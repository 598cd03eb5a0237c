"""Where the gap lies, which effect causes it, how far it shrinks."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Callable, Iterable, Optional, Sequence, Union

from . import _motorlab
from ._frames import frame_of, table_of
from ._html import paragraph, table
from ._motor import Motor
from ._run import Run
from ._verbs import Findings, runs_of

# Causes below this probability are left out of the table in a notebook, as on the program's page.
_LISTED_FROM = 0.001


class Diagnosis:
    """What a diagnosis says. ``document`` is the document ``motorlab-diagnosis/2``; the rest are parts of it."""

    def __init__(self, found: _motorlab.Diagnosis, runs: Sequence[Run]) -> None:
        self._found = found
        self.runs = list(runs)
        self.document: dict[str, Any] = json.loads(found.document())

    @property
    def verdict(self) -> str:
        """bad_recording, no_gap, parameters, effect, partial, ambiguous, outside_catalogue or no_change."""
        return self.document["verdict"]

    @property
    def sentence(self) -> str:
        """The verdict in plain sentences."""
        return self.document["sentence"]

    @property
    def probability(self) -> float:
        """Probability of what the verdict says."""
        return self.document["probability"]

    @property
    def effects(self) -> list[str]:
        """Ids of the effects that the verdict names."""
        return self.document["effects"]

    @property
    def note(self) -> str:
        """What else is to be known."""
        return self.document.get("note", "")

    @property
    def findings(self) -> Findings:
        """What is found in the recordings themselves."""
        return Findings(self.document["data"])

    @property
    def causes(self) -> Any:
        """A row a cause, likeliest first; the probabilities add to 1."""
        rows = []
        for cause in self.document["causes"]:
            evidence = cause.get("evidence") or {}
            rows.append(
                {
                    **cause,
                    "indistinguishable_from": ", ".join(cause["indistinguishable_from"]),
                    "gain_nats": evidence.get("gain_nats"),
                    "error_nats": evidence.get("error_nats"),
                }
            )
        names = ["effect", "stage", "probability", "inclusion", "indistinguishable_from", "gain_nats", "error_nats"]
        return table_of(rows, names)

    @property
    def parameters(self) -> Any:
        """A row a number of a cause, where it fits best, with its 95 % interval."""
        rows = [
            {"effect": cause["effect"], "parameter": name, **interval}
            for cause in self.document["causes"]
            for name, interval in cause["parameters"].items()
        ]
        return table_of(rows, ["effect", "parameter", "value", "lo95", "hi95", "unit", "reference"])

    @property
    def gap(self) -> Any:
        """A row a rung in counts RMS over pieces: predicted by fits on other pieces, and on what was fitted."""
        gap = self.document["gap"]
        rungs = [] if gap is None else ["before", "after_parameters", "after_effect"]
        return frame_of(
            {
                "rung": rungs,
                "predicted_counts": [gap[rung] for rung in rungs],
                "fitted_counts": [gap["fitted"][rung] for rung in rungs],
                "floor_counts": [gap["floor"] for _ in rungs],
            }
        )

    @property
    def regions(self) -> Any:
        """A row a stretch of a run with its share of the gap."""
        place = self.document["where"] or {"regions": []}
        return table_of(place["regions"], ["run", "from_s", "to_s", "regime", "share"])

    @property
    def next_experiment(self) -> Optional[dict[str, Any]]:
        """What to record next, where something is still in play."""
        return self.document["next_experiment"]

    def _motor(self, at: int) -> Optional[Motor]:
        motors = self._found.motors()
        return None if motors is None else Motor._of(motors[at])

    @property
    def motor(self) -> Optional[Motor]:
        """The motor with what was found in it; none of a bad recording."""
        return self._motor(2)

    @property
    def nominal(self) -> Optional[Motor]:
        """The motor that the runs are held against."""
        return self._motor(0)

    @property
    def refitted(self) -> Optional[Motor]:
        """The nominal motor refitted, without any effect."""
        return self._motor(1)

    def explain(self) -> str:
        """How the verdict came about: what was tried, kept and dropped at each step of the search."""
        return self._found.explained()

    def html(self, path: Union[str, os.PathLike[str]], *, overwrite: bool = False) -> Path:
        """Write everything as one page that needs no network. One that exists is replaced only with ``overwrite``."""
        page = self._found.page("What makes the gap")
        with open(path, "w" if overwrite else "x", encoding="utf-8") as file:
            file.write(page)
        return Path(path)

    def plot(self, axes: Any = None) -> Any:
        """The first run with nominal and diagnosed motor, the rungs, and the causes, with matplotlib. Axes of shape (3,)."""
        from ._plot import plot_diagnosis

        return plot_diagnosis(self, axes)

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}, {self.probability:.1%}): {self.sentence}"

    def _repr_html_(self) -> str:
        document = self.document
        parts = [paragraph(self.sentence, strong=True)]
        if self.note:
            parts.append(paragraph(self.note))
        causes = [one for one in document["causes"] if one["probability"] >= _LISTED_FROM]
        if causes:
            rows = [
                [one["effect"], one["stage"] or "", f"{one['probability']:.1%}", f"{one['inclusion']:.1%}"]
                for one in causes
            ]
            parts.append(table(["cause", "stage", "probability", "there at all"], rows))
        if document["gap"] is not None:
            gap = document["gap"]
            names = ["before", "after_parameters", "after_effect", "floor"]
            rows = [[name.replace("_", " "), f"{gap[name]:.3g}"] for name in names]
            parts.append(table(["position error", "counts RMS"], rows))
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
    """Say where the gap between runs and motor lies, which effect causes it and how far it shrinks.

    Ctrl-C interrupts it; the interpreter's lock is free while it runs.

    Parameters
    ----------
    runs
        A run or several of the same motor: other sample times and profiles tell more.
    motor
        The nominal motor. Without one it is fitted to runs that were imported, else the lab handout's.
    hold_out
        Runs that nothing is fitted to and nothing is chosen by: the gap is measured on them.
    reference
        Earlier runs of the same axis: what is asked is what has changed since.
    repeats
        Groups of runs that repeat each other, beside those that have the same commands.
    good_enough_counts, good_enough_share
        A position error, in counts or as a share of the travel (0.01 is 1 %), below which there is no gap.
    despite_findings
        Diagnose recordings in which something fatal is found too; nothing is then said with more than 90 %.
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

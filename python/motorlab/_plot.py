"""Pictures with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._verbs import Comparison, compare

if TYPE_CHECKING:
    from ._bench import Design
    from ._diagnosis import Diagnosis
    from ._run import Run

_RPM = 60 / (2 * np.pi)
_UNITS = {"command_v": "command (V)", "command_a": "command (A)", "command_nm": "command (N m)"}
# Most causes that are drawn.
_MOST_CAUSES = 8


def _axes_of(axes: Any, heights: tuple[float, ...], *, shared: bool = True) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt

    figure, made = plt.subplots(
        len(heights),
        1,
        sharex=shared,
        figsize=(9, 2.4 * sum(heights)),
        gridspec_kw={"height_ratios": heights},
        layout="constrained",
    )
    return made


def plot_run(run: Run, axes: Any) -> Any:
    axes = _axes_of(axes, (1.4, 1.0, 0.7))
    speed, position, command = axes
    speed.step(run.t_s, run.velocity_rad_s * _RPM, where="pre", linewidth=1)
    speed.set_ylabel("speed (RPM)")
    position.step(run.t_s, run.counts, where="post", linewidth=1)
    position.set_ylabel("position (counts)")
    command.step(run.t_s, run.command, where="post", linewidth=1, color="C2")
    command.set_ylabel(_UNITS[run.command_column])
    command.set_xlabel("time (s)")
    return axes


def plot_comparison(comparison: Comparison, axes: Any) -> Any:
    axes = _axes_of(axes, (1.4, 1.0, 0.8))
    speed, position, left = axes
    run = comparison.run
    speed.step(run.t_s, comparison["recorded_speed_rad_s"] * _RPM, where="pre", linewidth=2.5, alpha=0.5, label="recorded")
    speed.step(run.t_s, comparison["simulated_speed_rad_s"] * _RPM, where="pre", linewidth=1, label="simulated")
    speed.set_ylabel("speed (RPM)")
    _legend_above(speed)
    position.plot(run.t_s, run.counts, linewidth=2.5, alpha=0.5, label="recorded")
    position.plot(run.t_s, comparison["simulated_position_counts"], linewidth=1, label="simulated")
    position.set_ylabel("position (counts)")
    left.plot(run.t_s, comparison["residual_counts"], linewidth=1, color="C3")
    left.axhline(0, color="0.6", linewidth=0.8)
    left.set_ylabel("error (counts)")
    left.set_xlabel("time (s)")
    return axes


def _left(diagnosis: Diagnosis, motor: Any) -> Optional[np.ndarray]:
    return None if motor is None else compare(diagnosis.runs[0], motor)["residual_counts"]


def _legend_above(axes: Any) -> None:
    """A legend above the curves, where it covers none of them."""
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, frameon=False, borderaxespad=0.1, fontsize="small")


def plot_design(design: Design, axes: Any) -> Any:
    names, matrix = design.document["effects"], design._matrix()
    if axes is None:
        import matplotlib.pyplot as plt

        _, axes = plt.subplots(figsize=(0.24 * len(names) + 3, 0.22 * len(names) + 2.5), layout="constrained")
    from matplotlib.colors import LogNorm

    lowest = design.document["tie_below"]
    shades = axes.imshow(matrix, cmap="magma", norm=LogNorm(lowest, 100 * lowest))
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize="x-small")
    axes.set_yticks(range(len(names)), names, fontsize="x-small")
    axes.figure.colorbar(shades, ax=axes, label="separation D (standard deviations)", shrink=0.7)
    return axes


def plot_diagnosis(diagnosis: Diagnosis, axes: Any) -> Any:
    axes = _axes_of(axes, (1.3, 0.8, 1.0), shared=False)
    over_time, budget, causes = axes
    run = diagnosis.runs[0]
    for label, motor, style in (
        ("nominal motor", diagnosis.nominal, {"color": "C3", "alpha": 0.8}),
        ("diagnosed motor", diagnosis.motor, {"color": "C0"}),
    ):
        left = _left(diagnosis, motor)
        if left is not None:
            over_time.plot(run.t_s, left, linewidth=1, label=label, **style)
    over_time.axhline(0, color="0.6", linewidth=0.8)
    over_time.set_xlabel("time (s)")
    over_time.set_ylabel("measured minus\nsimulated (counts)")
    over_time.set_title(f"{diagnosis.verdict.replace('_', ' ')}, P = {diagnosis.probability:.2f}", loc="right", fontsize="medium")
    document = diagnosis.document
    if document["gap"] is None:
        for empty in axes:
            empty.set_axis_off()
        over_time.text(0, 0.5, diagnosis.sentence, wrap=True, va="center", transform=over_time.transAxes)
        return axes
    _legend_above(over_time)
    steps = document["budget"]
    colours = {"nominal": "C3", "parameters": "C1", "unexplained": "0.6"}
    bars = budget.barh(
        [step["step"] for step in steps],
        [step["rms_counts"] for step in steps],
        color=[colours.get(step["step"], "C0") for step in steps],
    )
    budget.axvline(document["gap"]["floor"], color="0.3", linestyle=":", label="noise floor")
    # The figures stand beside the bars, over no line.
    budget.bar_label(bars, fmt=" %.3g", bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.5})
    budget.set_xlim(0, 1.15 * max([step["rms_counts"] for step in steps] + [document["gap"]["floor"]]))
    _legend_above(budget)
    budget.invert_yaxis()
    budget.set_xlabel("held-out position error after the step (counts RMS)")
    shown = document["causes"][:_MOST_CAUSES]
    if not shown:
        causes.set_axis_off()
        causes.text(0, 0.5, "no effect has an inclusion probability of 0.01 or more", va="center", transform=causes.transAxes)
        return axes
    bars = causes.barh([one["effect"] for one in shown], [one["inclusion"] for one in shown], color="C0")
    causes.bar_label(bars, fmt=" %.2f")
    causes.set_xlim(0, 1.15)
    causes.invert_yaxis()
    causes.set_xlabel("inclusion probability")
    return axes

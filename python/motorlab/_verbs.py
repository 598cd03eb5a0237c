"""Simulate, compare, check."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np

from . import _motorlab
from ._frames import columns_of, floats_of, frame_of, table_of
from ._html import paragraph, table
from ._motor import Motor
from ._run import Run


def runs_of(runs: Union[Run, Iterable[Run]]) -> list[Run]:
    """One run or several, as a list."""
    is_one = isinstance(runs, (Run, str, bytes, Mapping)) or hasattr(runs, "__arrow_c_stream__")
    several = list(runs) if isinstance(runs, Iterable) and not is_one else [runs]
    return [run_of(one) for one in several]


def run_of(run: Any) -> Run:
    """A run, and nothing else."""
    if not isinstance(run, Run):
        raise TypeError(f"a Run is wanted, not {type(run).__name__}: Run.read(path) or Run.from_frame(frame) makes one")
    return run


def _motors_of(motors: Any) -> tuple[Motor, list[str], np.ndarray]:
    """A motor to start from, the keys that vary, and a row of values a motor."""
    if isinstance(motors, Motor):
        return motors, [], np.empty((1, 0))
    if isinstance(motors, (list, tuple)) and all(isinstance(one, Motor) for one in motors):
        rows = [
            {**one.parameters, **{f"{name}.{key}": value for name, of in one.effects.items() for key, value in of.items()}}
            for one in motors
        ]
        keys = list(rows[0]) if rows else []
        if any(list(row) != keys for row in rows):
            raise ValueError("the motors have different effects; simulate those of one kind at a time")
        return Motor(), keys, np.array([list(row.values()) for row in rows], dtype=np.float64)
    if isinstance(motors, Mapping):
        columns = {str(name): np.atleast_1d(np.asarray(values, dtype=np.float64)) for name, values in motors.items()}
    elif hasattr(motors, "columns"):
        columns = {str(name): np.asarray(motors[name], dtype=np.float64) for name in motors.columns}
    else:
        frame = frame_of_arrow(motors)
        columns = {str(name): np.asarray(frame[name], dtype=np.float64) for name in frame}
    arrays = np.broadcast_arrays(*columns.values()) if columns else [np.empty(1)]
    values = np.ascontiguousarray(np.column_stack(arrays)) if columns else np.empty((1, 0))
    return Motor(), list(columns), values


def frame_of_arrow(table_like: Any) -> Mapping[str, Any]:
    """Columns by name of what is neither a mapping nor a frame."""
    columns = columns_of(table_like)
    if isinstance(columns, list):
        return {name: values for name, values, _ in columns}
    raise TypeError("a table of motors is a mapping of names to arrays, a pandas or polars frame, or a list of motors")


def simulate(
    motors: Any,
    run: Optional[Run] = None,
    *,
    t_s: Any = None,
    command: Any = None,
    command_column: str = "command_v",
    base: Optional[Motor] = None,
    output: str = "measured_angle_rad",
    model: str = "second-order",
    seed: int = 1,
) -> np.ndarray:
    """Simulate many motors on one drive, on all cores, from rest.

    Parameters
    ----------
    motors
        A motor, a list of motors, or a table: a column a parameter (``resistance_ohm``, ``backlash.gap_rad``), a row a
        motor. Parameters that the table lacks are ``base``'s.
    run
        A run whose times and commands drive the motors; or ``t_s`` in s and ``command``, both of shape (samples,).
    command_column
        ``command_v`` in V, ``command_a`` in A, ``command_nm`` in N m.
    output
        ``measured_angle_rad`` (what the encoder would say before it rounds; the fastest), ``angle_rad``,
        ``speed_rad_s``, ``current_a``, ``counts`` (int64) or ``velocity_rad_s`` (by the difference of counts).
    model
        ``second-order``, or ``first-order`` without the inductance.
    seed
        Of what is random: lost edges, late samples. ``measured_angle_rad`` is the mean.

    Returns
    -------
    numpy.ndarray
        Shape (samples,) for one motor, else (motors, samples).

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0, 1, 0.003)
    >>> speeds = simulate({"resistance_ohm": [8.0, 10.0, 12.0]}, t_s=t, command=np.full(t.size, 4.5), output="speed_rad_s")
    >>> speeds.shape
    (3, 334)
    >>> bool(speeds[0, -1] > speeds[2, -1])
    True
    """
    one = isinstance(motors, Motor)
    start, keys, values = _motors_of(motors)
    if base is not None:
        start = base
    if run is not None:
        if t_s is not None or command is not None:
            raise ValueError("either a run, or t_s and command")
        t_s, command, command_column = run.t_s, run.command, run.command_column
    elif t_s is None or command is None:
        raise ValueError("what drives the motors is missing: a run, or t_s and command")
    driven = {
        "t_s": floats_of(t_s),
        "command": floats_of(command),
        "command_column": command_column,
        "model": model,
        "seed": seed,
    }
    rows = _motorlab.simulate(start._motor, keys, values, driven, output)
    return rows[0] if one else rows


@dataclass(frozen=True, eq=False)
class Comparison:
    """A run laid over its simulation in open loop from rest.

    ``figures`` are those of ``motorlab compare --json``: position_rmse_counts, position_largest_counts,
    velocity_rmse_rpm, velocity_nrmse, floor_counts, samples, lost.
    """

    run: Run
    motor: Motor
    figures: dict[str, Any]
    _columns: dict[str, np.ndarray]

    @property
    def position_rmse_counts(self) -> float:
        """Recorded against simulated position, RMS in counts."""
        return self.figures["position_rmse_counts"]

    @property
    def velocity_rmse_rpm(self) -> float:
        """Recorded against simulated speed by the same difference rule, RMS in RPM."""
        return self.figures["velocity_rmse_rpm"]

    def to_frame(self) -> Any:
        """Recorded and simulated columns beside each other, shape (samples, columns)."""
        recorded = {"t_s": self.run.t_s, self.run.command_column: self.run.command, "counts": self.run.counts}
        return frame_of({**recorded, **self._columns})

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]

    def __repr__(self) -> str:
        figures = self.figures
        return (
            f"Comparison({figures['position_rmse_counts']:.4g} counts RMS of position, "
            f"{figures['velocity_rmse_rpm']:.4g} RPM RMS of speed)"
        )

    def _repr_html_(self) -> str:
        rows = [[name, f"{value:.6g}"] for name, value in self.figures.items() if isinstance(value, (int, float))]
        return table(["figure", "value"], rows)

    def plot(self, axes: Any = None) -> Any:
        """Speed, position and what is left, with matplotlib. Returns the axes, shape (3,)."""
        from ._plot import plot_comparison

        return plot_comparison(self, axes)


def compare(run: Run, motor: Optional[Motor] = None, *, model: str = "second-order") -> Comparison:
    """Lay a run over its simulation; without a motor, the lab handout's.

    >>> import numpy as np
    >>> t = np.arange(0, 2, 0.003)
    >>> counts = simulate(Motor(), t_s=t, command=np.full(t.size, 4.5), output="counts")
    >>> run = Run.from_frame({"t_s": t, "command_v": np.full(t.size, 4.5), "counts": counts}, counts_per_rev=720, supply_v=4.5)
    >>> compare(run, Motor()).position_rmse_counts < 0.4
    True
    """
    motor = Motor() if motor is None else motor
    figures, columns = _motorlab.compare(run_of(run)._run, motor._motor, model)
    return Comparison(run, motor, json.loads(figures), columns)


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a recording: an entry of ``motorlab check --json``."""

    id: str
    severity: str
    run: str
    from_s: float
    to_s: float
    message: str
    evidence: dict[str, float]
    remedy: str


class Findings(Sequence[Finding]):
    """Findings about recordings, fatal ones first."""

    def __init__(self, findings: list[dict[str, Any]]) -> None:
        self._findings = [Finding(**finding) for finding in findings]

    def __len__(self) -> int:
        return len(self._findings)

    def __getitem__(self, at: Any) -> Any:
        return self._findings[at]

    @property
    def is_fatal(self) -> bool:
        """Whether a finding is fatal, so that no diagnosis is valid."""
        return any(finding.severity == "fatal" for finding in self)

    def to_frame(self) -> Any:
        """A row a finding."""
        names = ["id", "severity", "run", "from_s", "to_s", "message", "remedy"]
        return table_of([vars(finding) for finding in self], names)

    def __repr__(self) -> str:
        if not self:
            return "no findings"
        return "\n".join(f"{one.severity}: {one.message}; {one.remedy}" for one in self)

    def _repr_html_(self) -> str:
        if not self:
            return paragraph("no findings")
        rows = [[one.severity, one.id, one.message, one.remedy] for one in self]
        return table(["severity", "finding", "what", "what to do"], rows)


def check(runs: Union[Run, Iterable[Run]], motor: Optional[Motor] = None) -> Findings:
    """Say what is wrong with recordings themselves; several are of one motor.

    >>> import numpy as np
    >>> t = np.arange(0, 2, 0.003)
    >>> u = np.where(t < 1, 4.5, 0)
    >>> counts = -simulate(Motor(), t_s=t, command=u, output="counts")
    >>> run = Run.from_frame({"t_s": t, "command_v": u, "counts": counts}, counts_per_rev=720, supply_v=4.5)
    >>> [finding.id for finding in check(run) if finding.severity == "fatal"]
    ['encoder_reversed']
    """
    plain = [run._run for run in runs_of(runs)]
    return Findings(json.loads(_motorlab.check(plain, None if motor is None else motor._motor)))

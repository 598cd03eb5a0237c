"""A run: what was commanded and what the encoder counted."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Literal, Mapping, Optional, Union

import numpy as np

from . import _motorlab
from ._frames import columns_of, frame_of


class Run:
    """One recorded run in SI. Its columns are arrays that cannot be written.

    Made by :meth:`read` or :meth:`from_frame`. It speaks Arrow's PyCapsule interface: ``polars.from_arrow(run)``,
    ``pandas.DataFrame.from_arrow(run)``, ``pyarrow.table(run)`` and DuckDB read its memory without a copy.

    >>> run = Run.from_frame(
    ...     {"t_ms": range(0, 3000, 3), "u_v": [4.5] * 1000, "counts": range(1000)},
    ...     counts_per_rev=720, supply_v=4.5)
    >>> len(run), run.sample_time_s, run.counts_per_rev
    (1000, 0.003, 720.0)
    >>> run.t_s[:3].tolist(), run.command.dtype.name
    ([0.0, 0.003, 0.006], 'float64')
    """

    __slots__ = ("_run",)

    def __init__(self, run: _motorlab.Run) -> None:
        if not isinstance(run, _motorlab.Run):
            raise TypeError("a run is made by Run.read(path) or Run.from_frame(frame)")
        self._run = run

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]]) -> Run:
        """Read a run file. Remarks of the reader are in :attr:`notes`.

        >>> Run.read("nowhere.csv")  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        motorlab.MotorlabError: nowhere.csv: cannot be read: No such file or directory (os error 2)...
        """
        return cls(_motorlab.Run.read(path))

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        time: Optional[str] = None,
        command: Optional[str] = None,
        position: Optional[str] = None,
        speed: Optional[str] = None,
        integrate: Optional[Literal["backward", "trapezoid", "forward"]] = None,
        current: Optional[str] = None,
        counts_per_rev: Optional[float] = None,
        supply_v: Union[float, str, None] = None,
        units: Optional[Mapping[str, str]] = None,
        pwm_full: Optional[float] = None,
        m_per_rev: Optional[float] = None,
        wrap: Optional[float] = None,
        increments: bool = False,
        reverse: bool = False,
        unsigned: Optional[bool] = None,
        every: Optional[int] = None,
        command_limit: Optional[float] = None,
        direction: Optional[str] = None,
    ) -> Run:
        """Make a run of columns, by the rules of ``motorlab import``: names and units are recognised, or said.

        Parameters
        ----------
        frame
            An object with ``__arrow_c_stream__`` (pandas, polars, DuckDB, pyarrow), or names with arrays, all of
            shape (samples,).
        time, command, position, speed, current
            Names of columns; ``"name:unit"`` says the unit too. ``command="7V@0.95s"`` is 7 V from 0.95 s on.
            Either position or speed; a speed is summed up.
        integrate
            How a speed is summed up. ``"backward"``: a row's speed held since the row before, as in one made of
            differences of position; their sum gives the counts back. ``"trapezoid"``: the mean of two rows holds
            between them, as in a speed of the instant. ``"forward"``: a row's speed holds until the row after. The wrong
            one of backward and trapezoid puts each position off by half the way of one sample time. Without it steps of
            counts mean backward, and else a first-order motor is fitted both ways and the one that leaves less is taken;
            where neither does, it is a speed of the instant. The notes say which.
        counts_per_rev
            Counts of the encoder in one turn, all four edges counted.
        supply_v
            Driver supply in V, or the name of a measured column.
        units
            Unit by column: time s, ms, us, ns; command V, mV, pwm, percent, share, A, N m; position counts, rev,
            rad, deg; speed rpm, rad/s, deg/s, counts/s.
        pwm_full
            The PWM that is full drive, such as 255.
        m_per_rev, wrap, increments, reverse, unsigned, every, command_limit, direction
            As the flags of ``motorlab import``.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.arange(0, 2, 0.01)
        >>> run = Run.from_frame({"clock": t, "drive": np.full(200, 255), "w": 20 * t}, time="clock",
        ...     command="drive", speed="w", units={"clock": "s", "drive": "pwm", "w": "rad/s"},
        ...     pwm_full=255, supply_v=12, counts_per_rev=720)
        >>> float(run.command[0])
        12.0
        """
        units = dict(units or {})
        columns = columns_of(frame)
        said = {
            "time": time,
            "command": command,
            "command_limit": command_limit,
            "direction": direction,
            "position": position,
            "speed": speed,
            "integrate": integrate,
            "current": current,
            "supply_v": None if supply_v is None else str(supply_v),
            "counts_per_rev": counts_per_rev,
            "m_per_rev": m_per_rev,
            "pwm_full": pwm_full,
            "wrap": wrap,
            "increments": increments,
            "reverse": reverse,
            "unsigned": unsigned,
            "every": every,
            "units": units,
        }
        return cls(_motorlab.Run.from_columns(columns, said))

    def write(self, path: Union[str, os.PathLike[str]]) -> Path:
        """Write the run file; where the path exists the next free name is taken. Returns the path."""
        return Path(self._run.write(path))

    def to_frame(self) -> Any:
        """Its columns as a pandas frame; without pandas as a polars one, else as arrays by name. Shape (samples, columns)."""
        return frame_of({name: self._run.column(name) for name in self.columns})

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self._run.__arrow_c_stream__(requested_schema)

    def __len__(self) -> int:
        return len(self._run)

    def __getitem__(self, name: str) -> Any:
        return self._run.column(name)

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in the order of a run file."""
        return self._run.columns

    @property
    def t_s(self) -> np.ndarray:
        """Device time of each sample in s, shape (samples,)."""
        return self._run.column("t_s")

    @property
    def command(self) -> np.ndarray:
        """Command from each sample until the next, shape (samples,): in V, A or N m by :attr:`command_column`."""
        return self._run.column(self._run.command_column)

    @property
    def command_column(self) -> str:
        """command_v, command_a or command_nm."""
        return self._run.command_column

    @property
    def counts(self) -> np.ndarray:
        """Encoder counts, unwrapped, int64, shape (samples,)."""
        return self._run.column("counts")

    @property
    def velocity_rad_s(self) -> np.ndarray:
        """Speed by the difference of counts in rad/s, shape (samples,); NaN in row 0."""
        return self._run.column("velocity_rad_s")

    @property
    def sample_time_s(self) -> float:
        """Nominal sample time in s."""
        return self._run.sample_time_s

    @property
    def counts_per_rev(self) -> float:
        """Counts of the encoder in one turn."""
        return self._run.counts_per_rev

    @property
    def supply_v(self) -> Optional[float]:
        """Nominal driver supply in V, where it is known."""
        return self._run.supply_v

    @property
    def complete(self) -> bool:
        """Whether the recording was ended properly."""
        return self._run.complete

    @property
    def path(self) -> Optional[Path]:
        """The file that it was read from."""
        return None if self._run.path is None else Path(self._run.path)

    @property
    def header(self) -> dict[str, Any]:
        """The keys above the columns of the file."""
        return json.loads(self._run.header())

    @property
    def notes(self) -> list[str]:
        """Remarks of the reader, or of the recognition of a frame."""
        return self._run.notes

    def __repr__(self) -> str:
        of = f"'{self.path}', " if self.path else ""
        return f"Run({of}{len(self)} samples of {self.sample_time_s} s, {', '.join(self.columns)})"

    def plot(self, axes: Any = None) -> Any:
        """Speed, position and command over time, with matplotlib. Returns the axes, shape (3,)."""
        from ._plot import plot_run

        return plot_run(self, axes)

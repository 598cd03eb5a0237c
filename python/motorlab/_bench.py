"""Plan, record, look an effect up, take a motor elsewhere: the program's own commands."""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Union

import numpy as np

from ._frames import frame_of, table_of
from ._html import paragraph, table
from ._motor import Motor
from ._program import document, flags
from ._run import Run


@contextmanager
def _file_of(motor: Optional[Motor]) -> Iterator[list[str]]:
    """The flag that names a motor's file while the program runs."""
    if motor is None:
        yield []
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motor.toml"
        motor.save(path)
        yield [f"--motor={path}"]


class Design:
    """Which effects a planned recording shows and which it separates. ``document`` is ``motorlab-isolability/1``."""

    def __init__(self, found: Mapping[str, Any]) -> None:
        self.document = dict(found)

    @property
    def separation(self) -> Any:
        """A row and a column an effect, ``none`` first: separation D in standard deviations, the smaller of both ways round."""
        names = self.document["effects"]
        return frame_of({"effect": names, **dict(zip(names, self._matrix().T))})

    def _matrix(self) -> np.ndarray:
        matrix = np.array([[np.nan if cell is None else cell for cell in row] for row in self.document["separation"]])
        # That of an effect from none is the truth's, not the rival's.
        matrix[0, :] = matrix[:, 0]
        both = np.fmin(matrix, matrix.T)
        np.fill_diagonal(both, np.nan)
        return both

    @property
    def cannot_see(self) -> Any:
        """A row an effect that the recording does not show."""
        return table_of(self.document["cannot_see"], ["a", "b", "separation"])

    @property
    def cannot_tell_apart(self) -> Any:
        """A row a pair of effects that the recording shows and does not separate."""
        return table_of(self.document["cannot_tell_apart"], ["a", "b", "separation"])

    def plot(self, axes: Any = None) -> Any:
        """The separations as a heatmap, with matplotlib. Returns the axes."""
        from ._plot import plot_design

        return plot_design(self, axes)

    def __repr__(self) -> str:
        found = self.document
        return (
            f"Design({found['profile']}, {found['samples']} samples of {found['sample_time_s']} s: "
            f"{len(found['cannot_see'])} effects not visible, {len(found['cannot_tell_apart'])} pairs not separable)"
        )

    def _repr_html_(self) -> str:
        rows = [[pair["a"], pair["b"], f"{pair['separation']:.3g}"] for pair in self.document["cannot_tell_apart"]]
        hidden = ", ".join(pair["a"] for pair in self.document["cannot_see"]) or "none"
        parts = [paragraph(repr(self), strong=True), paragraph(f"Not visible: {hidden}.")]
        if rows:
            parts.append(table(["effect", "not separable from", "separation D"], rows))
        return "".join(parts)


def design(
    profile: str = "step",
    motor: Optional[Motor] = None,
    *,
    ts: float = 0.003,
    duration: Optional[float] = None,
    supply_v: Optional[float] = None,
) -> Design:
    """Say before a recording which effects its profile shows and which it separates.

    Parameters
    ----------
    profile
        A built-in profile (``"crawl@0.25,8s"``: a quarter of the supply, 8 s), or a file of rows ``t_s,command_v``.
    ts, duration
        Sample time and duration in s.

    >>> found = design("step", ts=0.03, duration=2)
    >>> found.document["samples"]
    67
    """
    with _file_of(motor) as named:
        asked = flags(profile=profile, ts=ts, duration=duration, supply=supply_v)
        return Design(document("design", *named, *asked))


def capture(
    port: str,
    *,
    profile: Optional[str] = None,
    ts: Optional[float] = None,
    duration: Optional[float] = None,
    output: Union[str, os.PathLike[str]] = "run.csv",
    motor: Optional[Motor] = None,
    **more: Any,
) -> Run:
    """Record from a board, and read the run. Ctrl-C ends the recording, which is whole then.

    Parameters
    ----------
    port
        The board's port as ``motorlab ports`` lists it, or ``virtual:`` for the simulated one.
    profile, ts, duration
        The command, the sample time in s and the duration in s; without them the program's own.
    output
        Where the run goes; where it exists, the next free name is taken. ``Run.path`` has it.
    **more
        Further flags of ``motorlab capture``, such as ``counts_per_rev=720`` or ``reconnect=True``.

    >>> import tempfile
    >>> run = capture("virtual:?speed=max", duration=0.5, output=tempfile.mkdtemp() + "/run.csv")
    >>> run.complete, run.sample_time_s
    (True, 0.003)
    """
    with _file_of(motor) as named:
        asked = flags(profile=profile, ts=ts, duration=duration, output=os.fspath(output), **more)
        return Run.read(document("capture", port, *named, *asked)["path"])


def effects(effect: Optional[str] = None) -> Any:
    """The catalogue, a row an effect; of one effect its entry as a dictionary.

    >>> effects("backlash")["stage"]
    'transmission'
    """
    known = document("effects")["effects"]
    if effect is None:
        rows = [{**one, "parameters": ", ".join(parameter["key"] for parameter in one["parameters"])} for one in known]
        return table_of(rows, ["effect", "stage", "summary", "equation", "parameters", "excited_by"])
    for one in known:
        if one["effect"] == effect:
            return one
    # The program's own message names the nearest effect.
    return document("effects", effect)


def export(
    what: Union[Motor, Run],
    form: str,
    output: Union[str, os.PathLike[str], None] = None,
    **more: Any,
) -> list[Path]:
    """Write a motor or a run for another program, and return the files.

    Parameters
    ----------
    what
        A motor, with its effects; or a run.
    form
        Of a motor ``matlab``, ``mujoco``, ``urdf``, ``json``, ``c``, ``python``, ``octave``, ``isaac-lab``; of a run
        ``parquet``, ``mcap``, ``matlab``.
    output
        A file, or a folder for ``matlab``.
    **more
        Further flags of ``motorlab export``, such as ``resistance=3.1``, ``leave_out=True`` or ``force=True``.

    >>> import tempfile
    >>> [path] = export(Motor(), "c", tempfile.mkdtemp() + "/motor.c")
    >>> "motor_step" in path.read_text()
    True
    """
    asked = flags(output=None if output is None else os.fspath(output), **more)
    if isinstance(what, Motor):
        with _file_of(what) as named:
            return _written(document("export", form, *named, *asked))
    if not isinstance(what, Run):
        raise TypeError(f"a Motor or a Run is exported, not {type(what).__name__}")
    with tempfile.TemporaryDirectory() as folder:
        name = what.path.name if what.path is not None else "run.csv"
        path = what.write(Path(folder) / name)
        if output is None:
            asked = [*asked, f"--output={Path.cwd() if form == 'matlab' else Path.cwd() / path.with_suffix('.' + form).name}"]
        named = [f"--run={path}"] if form == "matlab" else [str(path)]
        return _written(document("export", form, *named, *asked))


def _written(found: Mapping[str, Any]) -> list[Path]:
    return [Path(file) for file in found["files"]]

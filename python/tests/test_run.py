"""Runs: files and frames, in and out."""

import csv
import datetime

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from conftest import program

import motorlab as ml


def test_a_run_file_is_read_as_it_stands(recorded):
    run = ml.Run.read(recorded)
    lines = [line for line in recorded.read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    assert len(run) == len(rows) > 600
    assert run.counts.tolist() == [int(row["counts"]) for row in rows]
    assert run.t_s.tolist() == [float(row["t_s"]) for row in rows]
    assert run.command.tolist() == [float(row["command_v"]) for row in rows]
    speeds = [float(row["velocity_rad_s"] or "nan") for row in rows]
    assert np.array_equal(run.velocity_rad_s, speeds, equal_nan=True)
    assert run["flags"] == [row["flags"] for row in rows]
    assert (run.sample_time_s, run.counts_per_rev, run.supply_v) == (0.003, 720.0, 4.5)
    assert run.header["profile"] == "reversing"
    assert run.path == recorded


def test_arrays_and_arrow_show_the_memory_of_the_run(recorded):
    run = ml.Run.read(recorded)
    table = pa.table(run)
    for name in ["seq", "t_s", "command_v", "counts"]:
        buffer = table[name].chunk(0).buffers()[1]
        assert buffer.address == run[name].ctypes.data, name
    t_s, counts = run.t_s, table["counts"]
    expected = run.counts.tolist()
    del run, table
    assert t_s[0] == 0 and counts.to_pylist() == expected
    with pytest.raises(ValueError, match="read-only"):
        t_s[0] = 1


def test_every_reader_of_frames_reads_a_run(recorded):
    run = ml.Run.read(recorded)
    pandas = run.to_frame()
    assert isinstance(pandas, pd.DataFrame) and list(pandas) == run.columns
    assert np.shares_memory(pandas["counts"].to_numpy(), run.counts)
    polars = pl.from_arrow(pa.table(run))
    assert pl.DataFrame(run)["counts"].to_list() == polars["counts"].to_list() == run.counts.tolist()
    [(found,)] = duckdb.sql("select sum(counts)::bigint from run").fetchall()
    assert found == int(run.counts.sum())
    assert polars["velocity_rad_s"][0] is None


FRAMES = {
    "mapping": lambda columns: columns,
    "lists": lambda columns: {name: list(values) for name, values in columns.items()},
    "pandas": pd.DataFrame,
    "polars": pl.DataFrame,
    "pyarrow": pa.table,
    "duckdb": lambda columns: duckdb.from_arrow(pa.table(columns)),
}


@pytest.mark.parametrize("kind", FRAMES)
def test_frames_of_every_kind_become_the_same_run(kind):
    k = np.arange(500)
    columns = {"millis": 5 * k, "pwm": np.where(k < 250, 255, 0), "enc": 3 * k}
    run = ml.Run.from_frame(FRAMES[kind](columns), counts_per_rev=720, supply_v=12)
    assert run.sample_time_s == 0.005
    assert np.allclose(run.t_s, 0.005 * k, rtol=0, atol=1e-12)
    assert run.counts.tolist() == (3 * k).tolist()
    assert run.command.tolist() == np.where(k < 250, 12.0, 0.0).tolist()


def test_a_written_run_reads_back(tmp_path):
    t = np.arange(0, 1, 0.01)
    counts = np.rint(100 * (1 - np.cos(t))).astype(int)
    run = ml.Run.from_frame({"t_s": t, "u_v": np.sin(t), "counts": counts}, counts_per_rev=100, supply_v=2)
    path = run.write(tmp_path / "run.csv")
    again = ml.Run.read(path)
    for name in again.columns:
        assert np.array_equal(again[name], run[name], equal_nan=True), name
    assert run.write(tmp_path / "run.csv") != path


def test_units_are_said_by_column_or_with_the_name():
    t = np.arange(0, 2, 0.004)
    angle = 90 * t
    frame = {"clock": t / 60, "drive": np.full(t.size, 50.0), "where": angle}
    units = {"clock": "min", "drive": "percent", "where": "deg"}
    said = {"time": "clock", "command": "drive", "position": "where", "counts_per_rev": 3600, "supply_v": 24}
    run = ml.Run.from_frame(frame, units=units, **said)
    assert np.allclose(run.t_s, t, atol=1e-9)
    assert run.command.tolist() == [12.0] * t.size
    assert np.array_equal(run.counts, np.rint(10 * angle))
    named = {name: f"{value}:{units[value]}" if value in units else value for name, value in said.items()}
    assert ml.Run.from_frame(frame, **named).counts.tolist() == run.counts.tolist()
    # A unit beside a name that is recognised by itself.
    other = ml.Run.from_frame(
        {"time": t, "u_v": np.full(t.size, 1.0), "angle": angle}, units={"angle": "deg", "time": "s"}, counts_per_rev=3600, supply_v=24
    )
    assert other.counts.tolist() == run.counts.tolist()


@pytest.mark.parametrize("said, rule", [
    # No motor with a constant command moves like this, so that the motion does not show which speed it is: that of the instant.
    ({}, "trapezoid"),
    ({"integrate": "backward"}, "backward"),
    ({"integrate": "trapezoid"}, "trapezoid"),
    ({"integrate": "forward"}, "forward"),
])
def test_a_speed_is_summed_up_by_the_rule_that_is_said(said, rule):
    t = np.arange(0, 3, 0.01)
    speed = 5 * np.cos(2 * t)
    run = ml.Run.from_frame(
        {"t": t, "u": np.full(t.size, 3.0), "omega": speed},
        time="t:s", command="u:V", speed="omega:rad/s", counts_per_rev=100_000, supply_v=3, **said,
    )
    means = {"backward": speed[1:], "trapezoid": (speed[1:] + speed[:-1]) / 2, "forward": speed[:-1]}
    sums = np.concatenate([[0], np.cumsum(means[rule] * np.diff(t))])
    expected = sums * 100_000 / (2 * np.pi)
    assert np.abs(run.counts - expected).max() <= 0.5 + 1e-6
    assert run.header["imported"]["position"] == f"integrated from speed, {rule}"


def test_a_rule_that_sums_up_nothing_is_refused():
    columns = {"t_s": [0.0, 0.01, 0.02], "u_v": [1.0] * 3, "rpm": [0.0, 60.0, 60.0]}
    with pytest.raises(ml.MotorlabError, match="backward, trapezoid or forward"):
        ml.Run.from_frame(columns, counts_per_rev=720, supply_v=3, integrate="simpson")
    columns["counts"] = [0, 7, 14]
    with pytest.raises(ml.MotorlabError, match="no speed is read"):
        ml.Run.from_frame(columns, counts_per_rev=720, supply_v=3, integrate="trapezoid")


def test_time_stamps_are_a_clock():
    begin = datetime.datetime(2026, 1, 2, 3, 4, 5)
    stamps = [begin + datetime.timedelta(milliseconds=4 * k) for k in range(300)]
    columns = {"u_v": [1.0] * 300, "counts": list(range(300))}
    for frame in (pd.DataFrame({"time": stamps, **columns}), pl.DataFrame({"time": stamps, **columns})):
        run = ml.Run.from_frame(frame, counts_per_rev=720, supply_v=4.5)
        assert np.allclose(run.t_s, 0.004 * np.arange(300), atol=1e-9), type(frame)


def test_columns_without_names_go_by_their_numbers():
    k = np.arange(200)
    frame = pd.DataFrame(np.column_stack([0.01 * k, np.full(200, 2.0), 4.0 * k]))
    run = ml.Run.from_frame(frame, time="0:s", command="1:V", position="2:counts", counts_per_rev=720, supply_v=4.5)
    assert run.counts.tolist() == (4 * k).tolist()


def test_what_is_missing_is_asked_for_in_one_message_that_can_be_followed():
    k = np.arange(300)
    frame = {"t_ms": 10 * k, "pwm": np.full(300, 255), "counts": k}
    with pytest.raises(ml.MotorlabError) as error:
        ml.Run.from_frame(frame)
    said = str(error.value)
    call = said.splitlines()[-1].strip()
    assert "counts_per_rev" in said and "supply_v" in said
    for word, value in (("VOLTS", "12"), ("COUNTS", "720")):
        call = call.replace(f"={word},", f"={value},").replace(f"={word})", f"={value})")
    run = eval(call, {"Run": ml.Run, "frame": frame})
    assert run.command[0] == 12.0 and run.counts_per_rev == 720


def test_wrong_frames_are_refused_in_plain_words():
    with pytest.raises(TypeError, match="__arrow_c_stream__"):
        ml.Run.from_frame(3)
    with pytest.raises(TypeError, match="no column of numbers"):
        ml.Run.from_frame({"name": ["a", "b"]})
    with pytest.raises(ml.MotorlabError, match="one length"):
        ml.Run.from_frame({"t_s": [0.0, 1.0], "u_v": [1.0], "counts": [0, 1]})
    with pytest.raises(ml.MotorlabError, match="there is no such column"):
        ml.Run.from_frame({"t_s": [0.0, 0.1, 0.2], "u_v": [1.0] * 3, "counts": [0, 1, 2]}, speed="omega")
    with pytest.raises(TypeError, match="Run.read"):
        ml.Run("run.csv")


def test_units_are_of_columns_that_are_there_and_fit_them():
    frame = {"t_ms": 10 * np.arange(300), "u_v": np.full(300, 4.5), "counts": 3 * np.arange(300)}
    said = {"counts_per_rev": 720, "supply_v": 4.5}
    assert len(ml.Run.from_frame(frame, units={"counts": "counts"}, **said)) == 300
    with pytest.raises(ml.MotorlabError, match="`furlong` for `counts`"):
        ml.Run.from_frame(frame, units={"counts": "furlong"}, **said)
    with pytest.raises(ml.MotorlabError, match="units has `omega`, and there is no such column"):
        ml.Run.from_frame(frame, units={"omega": "rad/s"}, **said)


def test_rows_out_of_order_and_several_runs_in_one_frame_are_refused():
    frame = pd.DataFrame({"t_ms": 10 * np.arange(300), "u_v": np.full(300, 4.5), "counts": 3 * np.arange(300)})
    said = {"counts_per_rev": 720, "supply_v": 4.5}
    with pytest.raises(ml.MotorlabError, match="`t_ms` does not rise from row to row, so it is no clock"):
        ml.Run.from_frame(frame[::-1], time="t_ms:ms", **said)
    with pytest.raises(ml.MotorlabError, match="it holds 2 runs"):
        ml.Run.from_frame(pd.concat([frame[:100], frame]), time="t_ms:ms", **said)


def test_a_frame_most_of_whose_rows_cannot_be_used_is_refused():
    counts = np.where(np.arange(300) < 100, 3.0 * np.arange(300), 1e30)
    frame = {"t_ms": 10 * np.arange(300), "u_v": np.full(300, 4.5), "counts": counts}
    with pytest.raises(ml.MotorlabError, match="200 of 300 rows cannot be used"):
        ml.Run.from_frame(frame, counts_per_rev=720, supply_v=4.5)


def test_the_motion_of_swapped_wires_is_turned_round():
    frame = {"t_ms": 10 * np.arange(300), "u_v": np.full(300, 4.5), "counts": -3 * np.arange(300)}
    run = ml.Run.from_frame(frame, reverse=True, counts_per_rev=720, supply_v=4.5)
    assert run.counts.tolist() == (3 * np.arange(300)).tolist()


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "time_ms,pwm,rpm\n0,255,10\n10,255,20\n20,255,30\n", "# format = 'x'\nt_s\n"])
def test_wrong_files_are_said_in_the_words_of_the_program(tmp_path, text):
    path = tmp_path / "run.csv"
    path.write_text(text)
    with pytest.raises(ml.MotorlabError) as error:
        ml.Run.read(path)
    # A command that takes run files alone: compare, check and diagnose import a log on the way.
    said = program("export", "matlab", "--run", path, "-o", tmp_path / "matlab").stderr
    assert f"error: {error.value}" in said

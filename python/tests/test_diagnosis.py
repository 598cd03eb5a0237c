"""A diagnosis is the program's, as frames, pictures and HTML."""

import os
import signal
import threading
import time

import numpy as np
import pandas as pd
import pytest
from conftest import document, program

import motorlab as ml


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A motor whose driver takes 0.7 V, which the nominal motor lacks."""
    folder = tmp_path_factory.mktemp("voltage_drop")
    motor = ml.Motor(effects={"voltage_drop": {"drop_v": 0.7}})
    motor.save(folder / "motor.toml")
    paths = []
    for profile, duration in (("reversing", 6), ("step", 2)):
        path = folder / f"{profile}.csv"
        made = program("simulate", "--motor", folder / "motor.toml", "--ts", "0.005", "--profile", profile, "--duration", duration, "-o", path)
        assert made.returncode == 0, made.stderr
        paths.append(path)
    return paths


def test_a_diagnosis_is_the_programs(runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # A motor in memory is a motor that is given; its file stands in the next command under this name.
    ml.Motor().save("MOTOR.toml")
    found = ml.diagnose([ml.Run.read(path) for path in runs], ml.Motor())
    expected = document("diagnose", *runs, "--motor", "MOTOR.toml")
    for changes in (found.document, expected):
        changes.pop("elapsed_s")
    assert found.document == expected
    assert found.sentence == expected["sentence"]
    causes = found.causes
    assert isinstance(causes, pd.DataFrame) and causes["inclusion"].is_monotonic_decreasing
    assert causes["effect"][0] == "voltage_drop"
    assert abs(found.sets["probability"].sum() - 1) < 1e-9
    budget = found.budget.set_index("step")
    assert list(budget.index) == ["nominal", "parameters", *found.effects, "unexplained"]
    assert abs(budget["share"].drop("nominal").sum() - 1) < 1e-6
    assert {"speed_per_volt", "time_constant_s", "friction_v"} <= set(found.identifiable["parameter"])
    numbers = found.parameters
    drop = numbers[(numbers["effect"] == "voltage_drop") & (numbers["parameter"] == "drop_v")].iloc[0]
    assert drop["lo95"] <= 0.7 <= drop["hi95"] and drop["unit"] == "V"
    gap = found.gap.set_index("model")
    assert gap["fitted_counts"].is_monotonic_decreasing
    assert ml.compare(found.runs[0], found.motor).position_rmse_counts < 2
    assert ml.compare(found.runs[0], found.nominal).position_rmse_counts > 5
    assert found.motor.effects.keys() == {"voltage_drop"}
    page = found.html(tmp_path / "why.html").read_text()
    assert found.sentence.split("'")[0][:40] in page
    with pytest.raises(FileExistsError):
        found.html(tmp_path / "why.html")
    assert len(found.plot()) == 3
    assert "voltage_drop" in found._repr_html_() and "voltage_drop" in found.explain()
    assert found.regions["share"].sum() <= 1 + 1e-9


def test_runs_are_held_out_and_referred_to_as_by_the_program(runs):
    one, other = (ml.Run.read(path) for path in runs)
    found = ml.diagnose(one, ml.Motor(), hold_out=other, good_enough_share=0.5)
    expected = document("diagnose", runs[0], "--hold-out", runs[1], "--good-enough", "50%")
    assert found.verdict == expected["verdict"] == "no_gap"
    assert found.document["gap"]["before"] == expected["gap"]["before"]
    # The budget and the causes are frames without an identified effect too; within the floor nothing is reducible.
    steps = list(found.budget["step"])
    assert found.effects == [] and steps[:2] == ["nominal", "parameters"] and steps[-1] == "unexplained"
    assert (found.budget["share"] == 0).all()
    assert list(found.causes.columns) == ["effect", "stage", "inclusion", "class", "class_probability", "at_bound"]
    assert found.verdict in repr(found) and "unexplained" in found._repr_html_()
    since = ml.diagnose(one, ml.Motor(), reference=one)
    assert since.verdict == "no_change" and since.document["reference"]


def test_a_bad_recording_is_no_diagnosis(runs):
    good = ml.Run.read(runs[0])
    bad = ml.Run.from_frame({"t_s": good.t_s, "command_v": good.command, "counts": -good.counts}, counts_per_rev=720, supply_v=4.5)
    found = ml.diagnose([bad], ml.Motor())
    assert found.verdict == "bad_recording" and found.findings.is_fatal
    assert found.motor is None and len(found.causes) == 0 and len(found.gap) == 0
    assert len(found.budget) == 0 and len(found.sets) == 0 and len(found.identifiable) == 0
    assert "Swap" in found._repr_html_() or found.sentence in found._repr_html_()
    assert len(found.plot()) == 3


def test_texts_of_files_are_shown_and_not_run_in_a_notebook(tmp_path):
    path = tmp_path / "<script>alert(1)<" / "run.csv"
    path.parent.mkdir()
    good = ml.simulate(ml.Motor(), t_s=np.arange(0, 2, 0.01), command=np.full(200, 4.5), output="counts")
    run = ml.Run.from_frame({"t_s": np.arange(0, 2, 0.01), "u_v": [4.5] * 200, "counts": -good}, counts_per_rev=720, supply_v=4.5)
    written = ml.Run.read(run.write(path))
    assert "<script" not in ml.check(written)._repr_html_()
    assert "<script" not in ml.diagnose(written)._repr_html_()


def test_what_to_do_next_asks_the_program_the_same(runs, monkeypatch):
    monkeypatch.chdir(runs[0].parent)
    names = [path.name for path in runs]
    ml.Motor(resistance_ohm=8).save("MOTOR.toml", overwrite=True)
    one, other = (ml.Run.read(name) for name in names)
    asked = {"good_enough_share": 0.07, "despite_findings": True, "nominal": "file", "repeats": [[one, other]]}
    found = ml.diagnose([one, other], ml.Motor(resistance_ohm=8), reference=one, **asked)
    words = ["--motor", "MOTOR.toml", "--reference", names[0], "--repeats", ",".join(names), "--nominal", "file"]
    words += ["--good-enough", "7%", "--despite-findings"]
    assert found.sentence == document("diagnose", *names, *words)["sentence"]
    assert " ".join(["motorlab diagnose", *names, *words]) in found.sentence


def test_a_frame_without_a_motor_is_held_against_the_best_fit(runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    read = ml.Run.read(runs[0])
    run = ml.Run.from_frame({"t_s": read.t_s, "u_v": read.command, "counts": read.counts}, counts_per_rev=720, supply_v=4.5)
    found = ml.diagnose(run)
    expected = document("diagnose", run.write("imported.csv"))
    # A frame has no name to ask again by: the next step is a call.
    before, command = expected["sentence"].rsplit(": `motorlab diagnose ", 1)
    assert "imported.csv" in command
    assert found.sentence.startswith(before) and "RUN" not in found.sentence
    assert "`found." in found.sentence or "`motorlab.diagnose([" in found.sentence
    assert found.document["gap"] == expected["gap"]
    assert found.nominal != ml.Motor()


def test_wrong_questions_are_said_in_the_words_of_the_program(tmp_path):
    t = np.arange(0, 0.05, 0.01)
    run = ml.Run.from_frame({"t_s": t, "u_v": [1.0] * 5, "counts": range(5)}, counts_per_rev=720, supply_v=4.5)
    path = run.write(tmp_path / "short.csv")
    with pytest.raises(ml.MotorlabError) as error:
        ml.diagnose([ml.Run.read(path)], ml.Motor(), despite_findings=True)
    assert f"error: {error.value}" in program("diagnose", path, "--nominal", "file", "--despite-findings").stderr
    with pytest.raises(ml.MotorlabError, match="name at least one run"):
        ml.diagnose([], ml.Motor())
    with pytest.raises(ml.MotorlabError, match="nominal is"):
        ml.diagnose([run], nominal="best")


def test_ctrl_c_interrupts_a_diagnosis(runs):
    run = ml.Run.read(runs[0])
    timer = threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        while time.monotonic() - began < 60:
            ml.diagnose([run] * 4, ml.Motor())
    assert time.monotonic() - began < 5
    # What was given up does not hold up the next one for ever.
    assert ml.diagnose(run, ml.Motor(), good_enough_share=0.5).verdict == "no_gap"

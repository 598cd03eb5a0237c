"""Plan, record, effects, export: the program's commands as calls."""

import numpy as np
import pytest
from conftest import document

import motorlab as ml


def test_a_design_is_the_programs_and_draws_a_heatmap():
    found = ml.design("reversing", ts=0.01, duration=3)
    assert found.document == document("design", "--profile", "reversing", "--ts", "0.01", "--duration", "3")
    names = found.document["effects"]
    frame = found.separation
    assert list(frame.columns) == ["effect", *names] and len(frame) == len(names)
    pair = found.document["cannot_tell_apart"][0]
    row = frame.set_index("effect")
    assert row.loc[pair["a"], pair["b"]] == pytest.approx(pair["separation"])
    assert np.allclose(row.to_numpy(), row.to_numpy().T, equal_nan=True)
    axes = found.plot()
    assert [label.get_text() for label in axes.get_yticklabels()] == names
    assert "not separable" in found._repr_html_()


def test_a_capture_is_a_run_and_a_board_that_is_missing_is_an_error(tmp_path):
    run = ml.capture("virtual:?speed=max", profile="reversing", ts=0.01, duration=1, output=tmp_path / "run.csv")
    assert run.path == tmp_path / "run.csv" and run.complete and run.sample_time_s == 0.01
    again = ml.capture("virtual:?speed=max", duration=0.5, output=tmp_path / "run.csv")
    assert again.path != run.path and run.path.exists()
    with pytest.raises(ml.MotorlabError) as refused:
        ml.capture(str(tmp_path / "no-board"), output=tmp_path / "none.csv")
    assert refused.value.kind and not (tmp_path / "none.csv").exists()


def test_effects_are_the_catalogue():
    frame = ml.effects()
    assert "backlash" in list(frame["effect"])
    assert ml.effects("cogging")["stage"] == "mechanical"
    with pytest.raises(ml.MotorlabError):
        ml.effects("backlsh")


def test_a_motor_and_a_run_are_exported(tmp_path):
    motor = ml.Motor(effects={"backlash": {"gap_rad": 0.02}})
    [source] = ml.export(motor, "python", tmp_path / "motor.py")
    space: dict = {}
    exec(source.read_text(), space)
    assert "step" in space
    run = ml.capture("virtual:?speed=max", duration=0.5, output=tmp_path / "run.csv")
    [table] = ml.export(run, "parquet", tmp_path / "run.parquet")
    assert table.stat().st_size > 0
    with pytest.raises(TypeError):
        ml.export("motor.toml", "c")


def test_a_diagnosis_without_a_gap_has_its_frames_and_no_command_without_files():
    t = np.arange(0, 4, 0.01)
    u = np.where(t % 1 < 0.5, 4.5, -2.0)
    counts = ml.simulate(ml.Motor(), t_s=t, command=u, output="counts")
    run = ml.Run.from_frame({"t_s": t, "command_v": u, "counts": counts}, counts_per_rev=720, supply_v=4.5)
    found = ml.diagnose(run, ml.Motor())
    assert found.verdict == "no_gap"
    assert list(found.budget["step"])[0] == "nominal" and len(found.budget) >= 2
    assert {"speed_per_volt", "time_constant_s", "friction_v"} <= set(found.parameters["parameter"])
    found.plot()
    assert "RUN" not in found.sentence, found.sentence
    assert "found.html(" in found.sentence


def test_the_next_step_is_a_call_where_a_command_has_no_files_to_name():
    from motorlab._diagnosis import _in_python

    command = "`motorlab diagnose RUN... --motor MOTOR.toml{}`."
    assert _in_python("A. Next, write it: " + command.format(" --model-out fitted.toml")) == (
        'A. Next, write it: `found.motor.save("fitted.toml")`.'
    )
    record = "Next, record it: `motorlab capture PORT -o next.csv`. Then diagnose all runs together: "
    assert _in_python(record + "`motorlab diagnose next.csv RUN... --motor MOTOR.toml`.") == (
        record + '`motorlab.diagnose([motorlab.Run.read("next.csv"), *found.runs], motor)`.'
    )
    named = "Next, see it: `motorlab diagnose a.csv --html diagnosis.html`."
    assert _in_python(named) == named

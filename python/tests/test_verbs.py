"""Simulate, compare and check: closed forms, and the program's own answers."""

import os
import signal
import threading
import time

import numpy as np
import pandas as pd
import polars as pl
import pytest
from conftest import document

import motorlab as ml

T_S = np.arange(0, 2, 0.003)
STEP_V = np.full(T_S.size, 4.5)
FRICTIONLESS = {"coulomb_friction_nm": 0.0, "inductance_h": 0.0}


def test_a_step_without_coulomb_friction_is_its_closed_form():
    table = {"inertia_kg_m2": [0.001, 0.002, 0.004], **{key: [value] * 3 for key, value in FRICTIONLESS.items()}}
    speeds = ml.simulate(table, t_s=T_S, command=STEP_V, output="speed_rad_s", model="first-order")
    assert speeds.shape == (3, T_S.size) and speeds.dtype == np.float64
    p = ml.Motor().parameters
    damping = p["viscous_friction_nm_s_per_rad"] + p["torque_constant_nm_per_a"] * p["back_emf_v_s_per_rad"] / p["resistance_ohm"]
    torque = p["torque_constant_nm_per_a"] / p["resistance_ohm"] * 4.5
    for speed, inertia in zip(speeds, table["inertia_kg_m2"]):
        expected = torque / damping * -np.expm1(-T_S * damping / inertia)
        assert np.allclose(speed, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("kind", [dict, pd.DataFrame, pl.DataFrame, list])
def test_a_table_of_motors_is_each_motor_by_itself(kind):
    columns = {"resistance_ohm": [8.0, 10.0, 12.0], "backlash.gap_rad": [0.01, 0.02, 0.03]}
    motors = [
        ml.Motor(resistance_ohm=r, effects={"backlash": {"gap_rad": gap}})
        for r, gap in zip(columns["resistance_ohm"], columns["backlash.gap_rad"])
    ]
    table = motors if kind is list else kind(columns)
    reversing = np.where(T_S % 0.6 < 0.3, 4.5, -4.5)
    for output in ("measured_angle_rad", "angle_rad", "speed_rad_s", "current_a", "counts", "velocity_rad_s"):
        together = ml.simulate(table, t_s=T_S, command=reversing, output=output)
        assert together.shape == (3, T_S.size)
        for row, motor in zip(together, motors):
            alone = ml.simulate(motor, t_s=T_S, command=reversing, output=output)
            assert alone.shape == (T_S.size,)
            assert np.array_equal(row, alone, equal_nan=True), output


def test_counts_are_those_of_the_program(tmp_path):
    found = document("simulate", "--ts", "0.003", "--duration", "2", "--profile", "reversing")
    counts = ml.simulate(ml.Motor(), t_s=found["t_s"], command=found["command"], output="counts")
    assert counts.dtype == np.int64 and counts.tolist() == found["counts"]


def test_what_cannot_be_simulated_is_said():
    with pytest.raises(ml.MotorlabError, match="row 1 of the motors: inertia_kg_m2"):
        ml.simulate({"inertia_kg_m2": [0.002, -1]}, t_s=T_S, command=STEP_V)
    with pytest.raises(ml.MotorlabError, match="667 sample times but 3 commands"):
        ml.simulate(ml.Motor(), t_s=T_S, command=[1, 2, 3])
    with pytest.raises(ml.MotorlabError, match="does not come after"):
        ml.simulate(ml.Motor(), t_s=T_S[::-1], command=STEP_V)
    with pytest.raises(ml.MotorlabError, match="output is 'speed'"):
        ml.simulate(ml.Motor(), t_s=T_S, command=STEP_V, output="speed")
    with pytest.raises(ml.MotorlabError, match="model is"):
        ml.simulate(ml.Motor(), t_s=T_S, command=STEP_V, model="third")
    with pytest.raises(ValueError, match="missing"):
        ml.simulate(ml.Motor())


def test_a_comparison_is_the_programs(recorded):
    run = ml.Run.read(recorded)
    found = ml.compare(run)
    (expected,) = document("compare", recorded)["runs"]
    assert found.figures == expected
    assert found.position_rmse_counts < 1
    frame = found.to_frame()
    assert np.isclose(np.sqrt(np.mean(frame["residual_counts"] ** 2)), expected["position_rmse_counts"])
    assert "position_rmse_counts" in found._repr_html_()
    assert len(found.plot()) == 3 and len(run.plot()) == 3


def test_findings_are_the_programs(recorded):
    assert ml.check(ml.Run.read(recorded)).to_frame().to_dict("records") == [
        {key: value for key, value in one.items() if key != "evidence"} for one in document("check", recorded)["findings"]
    ]


def test_other_threads_run_meanwhile():
    ticks = 0
    done = threading.Event()

    def tick():
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    began = time.monotonic()
    ml.simulate({"resistance_ohm": np.linspace(8, 12, 400)}, t_s=np.arange(0, 20, 0.003), command=np.full(6667, 4.5))
    took_s = time.monotonic() - began
    done.set()
    ticker.join()
    # A lock that is held would leave none but the first ones; half a millisecond in four is much on a busy machine.
    assert ticks > 20 * took_s, (ticks, took_s)


def test_ctrl_c_interrupts_a_simulation():
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        while time.monotonic() - began < 30:
            ml.simulate({"resistance_ohm": np.linspace(8, 12, 200)}, t_s=T_S, command=STEP_V, output="counts")
    assert time.monotonic() - began < 5


def test_what_is_no_run_is_refused_with_what_is_wanted():
    for wrong in ("run.csv", pd.DataFrame({"t_s": [0.0]}), 3, [ml.Motor()]):
        for verb in (ml.check, ml.diagnose, ml.compare):
            with pytest.raises(TypeError, match="a Run is wanted, not .*Run.read"):
                verb(wrong)

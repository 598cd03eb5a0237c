"""The program that the package brings."""

import json
import signal
import subprocess
import sys
import time

from conftest import PROGRAM, program

import motorlab as ml


def test_the_program_is_there_and_has_its_exit_statuses(tmp_path):
    assert program("--version").stdout.strip() == f"motorlab {ml.__version__}"
    assert program("diagnose", "nowhere.csv").returncode == 2
    wrong = program("simulate", "--tss", "1", "--json")
    assert wrong.returncode == 2 and json.loads(wrong.stdout)["error"]["kind"] == "wrong_use"
    assert "Usage" in program("--help").stdout


def test_python_runs_it_as_a_module():
    done = subprocess.run([sys.executable, "-m", "motorlab", "effects", "--json"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "backlash" in done.stdout


def test_ctrl_c_ends_it(tmp_path):
    path = tmp_path / "virtual.csv"
    words = [str(PROGRAM), "capture", "virtual:", "--ts", "0.003", "--duration", "60", "-o", str(path)]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    began = time.monotonic()
    while not (path.exists() and path.stat().st_size > 2000) and time.monotonic() - began < 30:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=20)
    assert len(ml.Run.read(path)) > 10

"""Starts a program, gives it Ctrl-C after two seconds of recording to FILE, and ends as it ends: LIMIT_S FILE PROGRAM ARGUMENT..."""

import pathlib
import signal
import subprocess
import sys
import time

RECORDING_S = 2

limit_s, file = float(sys.argv[1]), pathlib.Path(sys.argv[2])
program = subprocess.Popen(sys.argv[3:])
# On a busy machine wine takes long to start, and the board to say who it is.
until = time.monotonic() + limit_s
while not file.exists() and program.poll() is None and time.monotonic() < until:
    time.sleep(0.05)
time.sleep(RECORDING_S)
# wine hands SIGINT to the program as the console's Ctrl-C.
program.send_signal(signal.SIGINT)
try:
    sys.exit(program.wait(limit_s))
except subprocess.TimeoutExpired:
    program.kill()
    sys.exit("Ctrl-C does not end it")

"""Starts a program, gives it Ctrl-C after two seconds of recording, and ends as it ends: LIMIT_S PROGRAM ARGUMENT..."""

import signal
import subprocess
import sys
import time

# Longer than a board takes to say who it is, in s.
RECORDING_S = 2

limit_s = float(sys.argv[1])
program = subprocess.Popen(sys.argv[2:])
time.sleep(RECORDING_S)
# wine hands SIGINT to the program as the console's Ctrl-C.
program.send_signal(signal.SIGINT)
try:
    sys.exit(program.wait(limit_s))
except subprocess.TimeoutExpired:
    program.kill()
    sys.exit("Ctrl-C does not end it")

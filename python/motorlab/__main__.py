"""The program `motorlab`: the same as the one of the release, inside this interpreter."""

import signal
import sys
from typing import NoReturn

from . import _motorlab


def main() -> NoReturn:
    """Run the program with the arguments of this process."""
    # Ctrl-C is the program's own, not the interpreter's.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    status = _motorlab.main(["motorlab", *sys.argv[1:]])
    sys.exit(status)


if __name__ == "__main__":
    main()

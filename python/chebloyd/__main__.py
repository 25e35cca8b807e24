"""``python -m chebloyd``: the program, as its own command."""

from __future__ import annotations

import signal
import sys

from ._native import native


def main() -> None:
    """Runs the program with this process's arguments."""
    # The program has handlers of its own; until it sets them Ctrl-C ends it at once.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(native.program(["chebloyd", *sys.argv[1:]]))


if __name__ == "__main__":
    main()

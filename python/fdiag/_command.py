"""The command `fdiag`, which comes with the package."""

from __future__ import annotations

import signal
import sys

from . import _fdiag


def main() -> None:
    """Run the command line of this process, and end with its exit code."""
    # As of a program of its own: Ctrl-C is for the command, which says what is finished by then.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_fdiag.command(["fdiag", *sys.argv[1:]]))


if __name__ == "__main__":
    main()

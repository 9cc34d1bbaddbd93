"""`contbed`, also as `python -m contbed`: starts the command line, which can be interrupted from the first moment."""

import os
import signal
import sys
import warnings
from types import FrameType

from contbed import quick_start

INTERRUPTED = 130


def _end(number: int, frame: FrameType | None) -> None:
    """End at once: while modules are imported nothing has been begun, and no module need survive half an import."""
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


def main() -> int:
    """Run the command line and return its exit code."""
    quick_start.begin()
    try:
        return _command()
    finally:
        quick_start.end()


def _command() -> int:
    default = signal.getsignal(signal.SIGINT)
    if default is not signal.default_int_handler:  # a shell lets what it starts in the background ignore interrupts
        from contbed.cli import main as command

        return command()
    signal.signal(signal.SIGINT, _end)
    if not sys.warnoptions:  # of numpy, for numbers that are told where they are no result
        warnings.simplefilter("ignore", RuntimeWarning)
    from contbed.cli import main as command
    from contbed.interrupts import no_interrupt_lost

    signal.signal(signal.SIGINT, default)
    try:
        with no_interrupt_lost():
            return command()
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done, only Python ends


if __name__ == "__main__":
    sys.exit(main())

"""`contbed`, also as `python -m contbed`: starts the command line, which can be
interrupted from the first moment.
"""

import gc
import os
import signal
import sys
import warnings
from types import FrameType

INTERRUPTED = 130


def _end(number: int, frame: FrameType | None) -> None:
    """End at once: while modules are imported nothing has begun, and no module need
    survive half an import.
    """
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


def main() -> int:
    """Run the command line and return its exit code.

    Reference cycles are not collected while modules are imported, nor when Python ends:
    0.3 s of 1.4 s of a small run. Runs collect them, see `contbed.runner`. OpenBLAS
    starts with the one thread that runs allow it, 0.1 s.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.disable()
    try:
        return _command()
    finally:
        # cycles keep states of CoolProp, which complains of them when Python ends
        if "CoolProp" in sys.modules:
            gc.collect()
        gc.freeze()


def _command() -> int:
    default = signal.getsignal(signal.SIGINT)
    # a shell lets what it starts in the background ignore interrupts
    if default is not signal.default_int_handler:
        from contbed.cli import main as command

        return command()
    signal.signal(signal.SIGINT, _end)
    # of numpy, about numbers that contbed checks and reports itself
    if not sys.warnoptions:
        warnings.simplefilter("ignore", RuntimeWarning)
    from contbed.cli import main as command

    signal.signal(signal.SIGINT, default)
    try:
        return command()
    finally:
        # only Python itself still has to end
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())

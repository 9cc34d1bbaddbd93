"""Ctrl-C while compiled code runs.

A signal that arrives while arrays go in and out of a compiled function would surface there as a SystemError. So the
handler of Python only notes it, and KeyboardInterrupt is raised when the block is left, with all arrays complete.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def deferred_interrupt() -> Iterator[None]:
    """Hold an interrupt back until the block ends; the block should take well below a second.

    Blocks may be nested: the outermost one raises. Handlers that are not Python's own are left as they are.

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived in the block
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    seen = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal seen
        seen = True

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if seen:
        raise KeyboardInterrupt

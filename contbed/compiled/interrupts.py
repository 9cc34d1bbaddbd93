"""Ctrl-C while code runs that cannot pass it on.

A signal that arrives while arrays go in and out of a compiled function would surface
there as a SystemError. So the handler of Python only notes it, and KeyboardInterrupt is
raised when the block is left, with all arrays complete.
"""

from __future__ import annotations

import signal
import threading
from contextlib import ContextDecorator
from types import FrameType


class deferred_interrupt(ContextDecorator):
    """Hold an interrupt back until the block or function ends; it should take well
    below a second.

    Blocks may be nested: the outermost one raises. Other threads than the main one, and
    handlers that are not Python's own, are left as they are.

    Raises
    ------
    KeyboardInterrupt : SIGINT arrived in the block
    """

    _held = False  # by a block of the main thread
    _seen = False

    def __enter__(self) -> None:
        cls = deferred_interrupt
        self._outermost = (
            not cls._held
            and threading.current_thread() is threading.main_thread()
            and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        )
        if self._outermost:
            # in this order, as an interrupt may come between any two lines: `_held` is
            # set only while it is noted
            cls._seen = False
            signal.signal(signal.SIGINT, _note)
            cls._held = True

    def __exit__(self, *failure: object) -> None:
        if not self._outermost:
            return
        cls = deferred_interrupt
        cls._held = False
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if cls._seen and failure[0] is None:
            raise KeyboardInterrupt

    def _recreate_cm(self) -> deferred_interrupt:
        """Return a block of its own for each call: a decorated function may be
        entered again before it is left.
        """
        return deferred_interrupt()


def _note(number: int, frame: FrameType | None) -> None:
    deferred_interrupt._seen = True

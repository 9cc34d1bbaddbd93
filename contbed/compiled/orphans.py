"""Processes that end with the process that started them, however that ends."""

from __future__ import annotations

import os
import time
from functools import cache
from threading import Thread

WAIT = 1.0  # s between looks at the parent


@cache
def end_with(parent: int) -> None:
    """End this process soon after its parent of that number, also where that is killed.

    Nothing happens in the parent itself.
    """
    if os.getpid() != parent:
        Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(WAIT)
    os._exit(1)

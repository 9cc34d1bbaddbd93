"""Progress of a run on stderr: a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, ClassVar

INTERVAL = 0.1  # s between redraws
WAITING = 0.5  # s between redraws of the elapsed time
SHORTEST = 2.0  # s of a run that has a bar
PAUSE = 10.0  # s between lines where stderr is no terminal, at least
GROWTH = 0.1  # of the time so far between such lines, so that long runs write few


class Progress:
    """Bar from 0 to `total` on stderr, or a line every `PAUSE` seconds where stderr is
    no terminal; silent when `quiet`.

    >>> with Progress(10.0, "s", quiet=True) as progress:
    ...     progress.advance_to(2.5, "step 0.1 s")
    """

    # whether a run shows its progress, beside which the clock has no place
    shown: ClassVar[bool] = False

    def __init__(self, total: float, unit: str = "s", quiet: bool = False):
        self.total, self.unit = total, unit
        self._visible = not quiet and sys.stderr is not None
        self._bar: Any = None
        self._start = time.monotonic()
        self._next = self._start + PAUSE

    def __enter__(self) -> Progress:
        if self._visible and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(
                BarColumn(),
                TextColumn("{task.percentage:3.0f} %"),
                TextColumn("{task.description}", markup=False),
                TimeRemainingColumn(),
                console=Console(stderr=True),
                auto_refresh=False,
                transient=True,
            )
            self._bar.start()
            self._bar.add_task("", total=self.total)
            self._next = self._start
        Progress.shown = self._visible
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None
        Progress.shown = False

    def advance_to(self, value: float, note: str = "") -> None:
        """Show that `value` of the total is reached."""
        if not self._visible:
            return
        now = time.monotonic()
        ended = self._bar is not None and value >= self.total
        if now < self._next and not ended:
            return
        text = f"{value:.4g} of {self.total:.4g} {self.unit}" + (
            f", {note}" if note else ""
        )
        if self._bar is not None:
            self._next = now + INTERVAL
            self._bar.update(0, completed=value, description=text, refresh=True)
            return
        elapsed = now - self._start
        self._next = now + max(PAUSE, GROWTH * elapsed)
        say(f"{text}, {elapsed:.0f} s elapsed")


def say(text: str) -> None:
    """Write a line on stderr at once."""
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)


@contextmanager
def waiting() -> Iterator[None]:
    """Show the elapsed time of a block, on a terminal after `SHORTEST` and elsewhere
    every `PAUSE` seconds, until the block shows its progress.
    """
    if sys.stderr is None:
        yield
        return
    ended = threading.Event()
    shown = _draw if sys.stderr.isatty() else _say_elapsed
    drawing = threading.Thread(target=shown, args=(ended,), daemon=True)
    drawing.start()
    try:
        yield
    finally:
        ended.set()
        drawing.join()


def _say_elapsed(ended: threading.Event) -> None:
    start = time.monotonic()
    pause = PAUSE
    while not ended.wait(pause) and not Progress.shown:
        elapsed = time.monotonic() - start
        say(f"still computing, {elapsed:.0f} s elapsed")
        pause = max(PAUSE, GROWTH * elapsed)


def _draw(ended: threading.Event) -> None:
    start = time.monotonic()
    if ended.wait(SHORTEST) or Progress.shown:
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), TextColumn("{task.description}", markup=False))
    console = Console(stderr=True)
    with Bar(*columns, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task("", total=None)
        while True:
            elapsed = time.monotonic() - start
            bar.update(task, description=f"{elapsed:.0f} s", refresh=True)
            if ended.wait(WAITING) or Progress.shown:
                return

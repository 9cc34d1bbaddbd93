"""A progress bar on a terminal, and nothing anywhere else."""

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


class Progress:
    """Bar from 0 to `total` on stderr; silent when `quiet` or when stderr is no
    terminal.

    >>> with Progress(10.0, "s", quiet=True) as progress:
    ...     progress.advance_to(2.5, "step 0.1 s")
    """

    # whether a bar is on the terminal, beside which the clock has no place
    shown: ClassVar[bool] = False

    def __init__(self, total: float, unit: str = "s", quiet: bool = False):
        self.total, self.unit = total, unit
        self._visible = not quiet and sys.stderr is not None and sys.stderr.isatty()
        self._bar: Any = None
        self._drawn = 0.0

    def __enter__(self) -> Progress:
        if self._visible:
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
            Progress.shown = True
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
        if self._bar is None:
            return
        now = time.monotonic()
        if now - self._drawn < INTERVAL and value < self.total:
            return
        self._drawn = now
        text = f"{value:.4g} of {self.total:.4g} {self.unit}" + (
            f", {note}" if note else ""
        )
        self._bar.update(0, completed=value, description=text, refresh=True)


@contextmanager
def waiting() -> Iterator[None]:
    """Show the elapsed time of a block on a terminal after `SHORTEST`, until the
    block shows a bar of its own.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    ended = threading.Event()
    drawing = threading.Thread(target=_draw, args=(ended,), daemon=True)
    drawing.start()
    try:
        yield
    finally:
        ended.set()
        drawing.join()


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

"""A progress bar on a terminal, and nothing anywhere else."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, ClassVar

INTERVAL = 0.1  # s between redraws


class Progress:
    """Bar from 0 to `total` on stderr; silent when `quiet` or when stderr is no terminal.

    >>> with Progress(10.0, "s", quiet=True) as progress:
    ...     progress.advance_to(2.5, "step 0.1 s")
    """

    _watcher: ClassVar[Callable[[Progress, float], None] | None] = None

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
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    @classmethod
    @contextmanager
    def watched(cls, watcher: Callable[[Progress, float], None]) -> Iterator[None]:
        """Call `watcher` with each bar and what it reaches, for the duration of the block; it may raise."""
        before, Progress._watcher = Progress._watcher, watcher
        try:
            yield
        finally:
            Progress._watcher = before

    def advance_to(self, value: float, note: str = "") -> None:
        """Show that `value` of the total is reached."""
        if Progress._watcher is not None:
            Progress._watcher(self, value)
        if self._bar is None:
            return
        now = time.monotonic()
        if now - self._drawn < INTERVAL and value < self.total:
            return
        self._drawn = now
        text = f"{value:.4g} of {self.total:.4g} {self.unit}" + (f", {note}" if note else "")
        self._bar.update(0, completed=value, description=text, refresh=True)

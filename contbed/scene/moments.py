"""What is possible in the times of a run but seldom meant."""

from __future__ import annotations

from typing import Protocol

from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath

ROUNDING = 1e-9  # share by which times that are the same may differ


class Times(Protocol):
    """The `[time]` table of a run that writes fields at some of its rows."""

    @property
    def end(self) -> float:
        """End of the run [s]."""

    @property
    def sample(self) -> float | None:
        """Interval of rows [s]."""

    @property
    def fields(self) -> float | None:
        """Interval of fields [s]."""


def of_output(time: Times, interval: float) -> Mistakes:
    """Look for what is first written after the end of the run, and for fields more
    often than rows, which are `interval` [s] apart.
    """
    for key in ("sample", "fields"):
        value = getattr(time, key)
        if value is not None and value > time.end * (1.0 + ROUNDING):
            text = f"longer than the run of {time.end:g} s: written at its end"
            yield ("time", key), text
    if time.fields is not None and time.fields < interval * (1.0 - ROUNDING):
        kept = "" if time.sample else " unless a restart keeps those of its run"
        text = (
            f"fields are written at rows, {interval:g} s apart{kept}; see time.sample"
        )
        yield ("time", "fields"), text


def of_inlet(key: KeyPath, until: float | None, end: float) -> Mistakes:
    """Look for an inlet that ends after the run [s]."""
    if until is not None and until >= end:
        text = f"is not before the end of the run, {end:g} s, so that it has no effect"
        yield (*key, "until"), text

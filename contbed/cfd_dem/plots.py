"""Picture of particles in a gas: pressure drop, height and temperatures over time."""

from __future__ import annotations

from pathlib import Path

from contbed.dem.plots import history_plot
from contbed.result import Result


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png."""
    history_plot(folder / "profiles.png", result.profiles, result.plan.scene.title)

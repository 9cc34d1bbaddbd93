"""Plot of one particle: mass that is left, and temperatures of centre and surface,
over the time.
"""

from __future__ import annotations

from pathlib import Path

from contbed.fields import header
from contbed.output.plots import styled_figure
from contbed.result import Result


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png into a folder."""
    columns = result.profiles
    t = columns[header("t")]
    with styled_figure(folder / "profiles.png", 3.2, result.plan.scene.title) as figure:
        mass, heat = figure.subplots(1, 2)
        mass.plot(t, columns[header("mass_fraction")], color="#0072B2")
        mass.set(xlabel="time [s]", ylabel="mass over that of the fresh particle")
        for name, text, colour in (
            ("T_surface", "surface", "#D55E00"),
            ("T_centre", "centre", "#0072B2"),
        ):
            heat.plot(t, columns[header(name)], label=text, color=colour)
        heat.set(xlabel="time [s]", ylabel="temperature [K]")
        heat.legend()

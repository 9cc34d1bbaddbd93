"""Plot of a fully developed flow: velocities, solids volume fraction and granular
temperature over the radius.
"""

from __future__ import annotations

from pathlib import Path

from contbed.output.colours import COLOURS
from contbed.output.curves import Curve, curves_plot
from contbed.result import Result

PANELS = {
    "u [m/s]": {"u_gas [m/s]": "gas", "u_solid [m/s]": "particles"},
    "eps_s [1]": {"eps_s [1]": "particles"},
    "theta [m2/s2]": {"theta [m2/s2]": "particles"},
}
COLOUR = {"gas": COLOURS[0], "particles": COLOURS[1]}


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png: the profiles across the section."""
    columns = result.profiles
    r = 1e3 * columns["r [m]"]
    panels = {}
    for label, headers in PANELS.items():
        panels[label] = [
            Curve(phase, r, columns[header], {"color": COLOUR[phase]})
            for header, phase in headers.items()
            if header in columns
        ]
    panels = {label: curves for label, curves in panels.items() if curves}
    title = result.plan.scene.title
    curves_plot(folder / "profiles.png", panels, "r [mm]", title, len(panels))

"""Plot of one particle: mass that is left, and temperatures of centre and surface,
over the time.
"""

from __future__ import annotations

from pathlib import Path

from contbed.fields import header
from contbed.output.curves import Curve, curves_plot
from contbed.result import Result

PANELS = {
    "mass over that of the fresh particle": {"mass": "mass_fraction"},
    "temperature [K]": {"centre": "T_centre", "surface": "T_surface"},
}


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png into a folder."""
    columns = result.profiles
    t = columns[header("t")]
    panels = {
        label: [Curve(text, t, columns[header(name)]) for text, name in names.items()]
        for label, names in PANELS.items()
    }
    title = result.plan.scene.title
    curves_plot(folder / "profiles.png", panels, "time [s]", title, across=2)

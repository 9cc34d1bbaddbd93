"""Plot of a fully developed flow: velocities, solids volume fraction and granular
temperature over the radius.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contbed.output.plots import styled_figure
from contbed.result import Result


def plot(result: Result, folder: Path) -> None:
    """Write profiles.png."""
    developed_plot(folder / "profiles.png", result.profiles, result.plan.scene.title)


def developed_plot(
    path: Path | str, columns: Mapping[str, Any], title: str = ""
) -> None:
    """Write the profiles of a fully developed flow across its section, under the
    headers of profiles.csv.
    """
    panels = [("u_gas [m/s]", "u_solid [m/s]"), ("eps_s [1]",), ("theta [m2/s2]",)]
    panels = [tuple(name for name in names if name in columns) for names in panels]
    panels = [names for names in panels if names]
    r = 1e3 * columns["r [m]"]
    with styled_figure(path, 3.2, title, width=1.5 + 2.5 * len(panels)) as figure:
        for axes, names in zip(
            figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True
        ):
            for name in names:
                solid = name != "u_gas [m/s]"
                axes.plot(
                    r,
                    columns[name],
                    color="#D55E00" if solid else "#0072B2",
                    linewidth=1.2,
                    label="particles" if solid else "gas",
                )
            if len(names) > 1:
                axes.legend()
            label = (
                "u [m/s]" if names[0].startswith("u_") else names[0].replace("_", " ")
            )
            axes.set(xlabel="r [mm]", ylabel=label)
            axes.margins(x=0)

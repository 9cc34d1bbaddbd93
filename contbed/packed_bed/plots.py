"""Plots of a packed bed: profiles along it, the outlet over time, and fields of a
plane or of a box.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contbed.output.curves import history_plot
from contbed.output.maps import plot_profiles_and_fields, slice_maps


def plot(result: Any, folder: Path) -> None:
    """Write profiles.png, fields.png (of a box temperatures or pressure in its
    middle plane) and outlet.png.
    """
    plot_profiles_and_fields(result, folder)
    if "outlet" in result.tables:
        history_plot(
            folder / "outlet.png", result.tables["outlet"], result.plan.scene.title
        )
    if not result.nodal or result.plan.mesh.skfem.dim() < 3:
        return
    temperatures = [name for name in ("T_fluid", "T_solid") if name in result.nodal]
    names = temperatures or [name for name in ("p", "G") if name in result.nodal]
    if names:
        space, _ = result.nodal[names[0]]
        values = {
            name: result.nodal[name][1]
            for name in names
            if result.nodal[name][0].size == space.size
        }
        slice_maps(folder / "fields.png", space.points, values, result.plan.scene.title)

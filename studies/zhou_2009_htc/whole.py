"""The bed with the paper's 16,000 beads beside that with 2,500: does the size change
the coefficients?
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.zhou_2009_htc import study

HERE = Path(__file__).parent
COUNT = 16_000
# m/s: packed, packed and nearly carried, bubbling, vigorously bubbling
VELOCITIES = ("0.42", "1", "1.4", "2")
SHOWN = ("h_convection", *(f"total {k}" for k in study.COLOURS))


def reference() -> Table:
    """Coefficients of the small bed."""
    return Table.read(HERE / "results.csv")


def compute(cases: Sequence[str] = VELOCITIES) -> Tables:
    """Coefficients by mechanism at some velocities; committed rows of others are
    kept.
    """
    packing = study.settled(COUNT)
    found = study.table([study.one_velocity(packing, float(U)) for U in cases])
    return {"whole": Table.read(HERE / "whole.csv").updated(found, ["U [m/s]"])}


def plot(tables: Tables) -> dict[str, Any]:
    """Coefficients of both beds over the velocity."""
    figure, axes = gallery.figure(size=(6.4, 4.4))
    small = reference()
    for name, colour in zip(
        SHOWN, (gallery.BLACK, *study.COLOURS.values()), strict=True
    ):
        text = (
            "convection"
            if name == "h_convection"
            else f"$k_p$ = {name.split()[-1]} W/m/K"
        )
        axes.plot(small["U [m/s]"], small[name], "-", color=colour, label=text)
        axes.plot(tables["whole"]["U [m/s]"], tables["whole"][name], "o", color=colour)
    axes.plot([], [], "o", color=gallery.GREY, label="16,000 beads")
    axes.set(xlabel="$U$ [m/s]", ylabel="$h$ [W/m$^2$/K]", ylim=(0, None))
    axes.legend()
    return {"whole": figure}

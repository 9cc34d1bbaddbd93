"""How long must a moving bed of hot silica be to heat steam to within 10 K, and what
does the solid velocity do to it?

Steam at 160 degC and 2 bar rises through silica that enters at 700 degC and sinks. For
each solid velocity the length of an adiabatic shaft is found at which the steam leaves
10 K below the silica's inlet temperature (a root search; each trial is a run of
`shaft/plug.toml`). The heater on the gmsh mesh, with wall friction and heat loss, is
run beside it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
SILICA_IN = 973.15
WITHIN = 10.0
LENGTHS = (0.03, 20.0)
DIAMETERS = {0.006: gallery.BLUE, 0.012: gallery.VERMILION, 0.024: gallery.GREEN}
VELOCITIES = (
    np.array([0.50, 0.55, 0.56, 0.58, 0.60, 0.65, 0.7, 0.8, 1.0, 1.3, 1.7, 2.2, 3.0])
    * 1e-3
)


def approach(length: float, velocity_solid: float, diameter: float) -> float:
    """Difference between the silica entering and the steam leaving [K]."""
    overrides = {
        "mesh.length": length,
        "boundary.top.solids.silica.velocity": velocity_solid,
        "solids.silica.diameter": diameter,
    }
    result = cb.run(cb.load(HERE / "shaft" / "plug.toml", overrides))
    return SILICA_IN - result.qoi["T_fluid_out_K"]


def length_needed(velocity_solid: float, diameter: float) -> float:
    """Length [m] at which the steam comes within 10 K; nan where no length is
    enough.
    """

    def excess(log_length: float) -> float:
        difference = approach(np.exp(log_length), velocity_solid, diameter)
        return np.log(max(difference, 1e-6) / WITHIN)

    low, high = np.log(LENGTHS)
    if excess(high) > 0:
        return np.nan
    return float(np.exp(brentq(excess, low, high, xtol=1e-3)))


def column(diameter: float) -> str:
    """Header of the lengths for a pebble size."""
    return f"length for {1e3 * diameter:g} mm pebbles [m]"


def reference() -> float:
    """Solid velocity [m/s] at which the enthalpies of the streams balance: no length
    is enough for slower silica.
    """
    return 0.57e-3


def compute() -> Tables:
    """Length over solid velocity and pebble size; prints the heater on the gmsh
    mesh.
    """
    rows = [(v, *(length_needed(v, d) for d in DIAMETERS)) for v in VELOCITIES]
    heater = cb.run(cb.load(HERE / "heater.toml")).qoi
    print(
        f"heater, 1 m, with wall loss: steam leaves at {heater['T_fluid_out_K']:.2f} K"
    )
    print(f"wall loss {-heater['heat_wall_W']:.0f} W of {heater['heat_top_W']:.0f} W")
    return {
        "sweep": Table(
            dict.fromkeys(["solid velocity [m/s]", *map(column, DIAMETERS)], ".5g"),
            rows,
        )
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Length against solid velocity, one line for each pebble size."""
    figure, axes = gallery.figure(size=(8, 5))
    table = tables["sweep"]
    velocity = 1e3 * table["solid velocity [m/s]"]
    lengths = {d: table[column(d)] for d in DIAMETERS}
    for d, colour in DIAMETERS.items():
        axes.plot(velocity, lengths[d], "o-", color=colour)
        last = np.flatnonzero(np.isfinite(lengths[d]))[-1]
        gallery.label_line(
            axes, f"{1e3 * d:g} mm", velocity[last], lengths[d][last], colour
        )
    short = velocity[~np.isfinite(list(lengths.values())).any(axis=0)]
    axes.axvspan(velocity[0], short.max(), color="0.9")
    how = {"rotation": 90, "ha": "center", "va": "center", "color": "0.35"}
    axes.text(velocity[1], 0.3, "too little silica: no length is enough", **how)
    axes.set(
        yscale="log",
        xscale="log",
        xlabel="solid velocity [mm/s]",
        ylabel="bed length [m]",
    )
    axes.set_xlim(velocity[0])
    gallery.ticks(axes, x=(0.5, 0.7, 1, 2, 3), y=(0.05, 0.1, 0.2, 0.5, 1, 2, 3))
    axes.set_title(
        "Bed length that heats 160 degC steam to within 10 K of 700 degC silica"
    )
    return {"sweep": figure}

"""Draw the picture of the README: four results of studies.

    python docs/_ext/front_picture.py

The heater and the packing are computed anew, which takes some seconds; the bubbling
bed and the curves come from the committed tables of their studies.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

import contbed as cb  # noqa: E402
from contbed.dem import heat, network  # noqa: E402
from contbed.dem.heat_pair import IMPACT, correction  # noqa: E402
from contbed.dem.particle_tables import read_table  # noqa: E402
from studies import _gallery as gallery  # noqa: E402
from studies._gallery import Table  # noqa: E402
from studies._gallery.figures import STYLE  # noqa: E402

STUDIES = ROOT / "studies"
TARGET = ROOT / "docs" / "_static" / "contbed.png"
SIZE = (10.4, 8.0)  # inches
DPI = 130
SECONDS = (2, 4, 6)  # of the bubbling bed
RADIUS = 1.0  # of the spheres of the packing [mm]
OFFSET = {"textcoords": "offset points"}
COLOURS = {6: gallery.BLUE, 12: gallery.VERMILION, 24: gallery.GREEN}


def heater(axes: Any) -> Any:
    """Draw the temperature of the steam in the moving-bed heater."""
    result = cb.run(cb.load(STUDIES / "moving_bed_heater" / "heater.toml"))
    space, values = result.nodal["T_fluid"]
    r, z = space.points
    shown = axes.tripcolor(z, r, values, cmap="inferno", shading="gouraud")
    axes.tripcolor(z, -r, values, cmap="inferno", shading="gouraud")
    axes.axhline(0.0, color="white", linewidth=0.8, linestyle=(0, (6, 4)))
    axes.set(
        title="Packed bed: hot silica sinks, steam rises",
        xlabel="height [m]",
        ylabel="radius [m]",
    )
    gallery.ticks(axes, x=(0, 0.2, 0.4, 0.6, 0.8, 1))
    axes.set_yticks([-0.1, 0.0, 0.1], ["0.1", "0", "0.1"])
    return shown


def bubbling_bed(axes: Any) -> Any:
    """Draw the solids in the bed of Taghipour et al. at three times, side by side."""
    table = Table.read(STUDIES / "taghipour_bed" / "frames.csv")
    x, z = np.unique(table["x [m]"]), np.unique(table["z [m]"])
    gap, width = 0.06, x[-1] + x[0]
    for place, second in enumerate(SECONDS):
        values = table[f"eps_s at {second} s [1]"].reshape(z.size, x.size)
        left = place * (width + gap)
        shown = axes.imshow(
            values,
            origin="lower",
            extent=(left, left + width, 0.0, z[-1] + z[0]),
            cmap="cividis",
            vmin=0.0,
            vmax=0.6,
        )
        axes.text(left + width / 2, 0.76, f"{second} s", color="white", ha="center")
    axes.set(xlim=(0.0, len(SECONDS) * (width + gap) - gap), ylim=(0.0, 0.86))
    axes.set(
        title="Two fluids: a bubbling bed, 28 cm wide", ylabel="height [m]", xticks=[]
    )
    return shown


def packing(axes: Any) -> Any:
    """Draw a slice of a packing of glass beads through which heat flows."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Circle

    x = read_table(STUDIES / "zhou_2010_etc" / "packing.csv.gz").x
    pairs = heat.near_pairs(x, 3e-3 * RADIUS)
    glass = correction(1e7, 5e10, IMPACT)  # settled softer than glass is
    conduction = heat.Conduction(2.6, 0.026, 0.391, glass)
    found = network.between_layers(
        x,
        pairs,
        heat.conductances(pairs, 1e-3 * RADIUS, conduction),
        x[:, 2] < 2e-3,
        x[:, 2] > 24.7e-3,
        0.026**2,
    )
    # beads whose centre is less than a radius behind the middle plane, the front last
    depth = 1e3 * (x[:, 1] - 0.013)
    cut = np.flatnonzero((depth > -RADIUS) & (depth < 2.0 * RADIUS))
    cut = cut[np.argsort(-depth[cut])]
    circles = [Circle(1e3 * centre, RADIUS) for centre in x[cut][:, [0, 2]]]
    shown = axes.add_collection(
        PatchCollection(circles, cmap="inferno", edgecolor="0.25", linewidth=0.4)
    )
    shown.set_array(found.T[cut] - 273.15)
    axes.set(
        title="Particles: conduction through glass beads",
        xlabel="x [mm]",
        ylabel="height [mm]",
        xlim=(-0.5, 26.5),
        ylim=(-0.5, 1e3 * x[:, 2].max() + 1.5),
        aspect="equal",
    )
    return shown


def design(axes: Any) -> None:
    """Draw how long the heater must be."""
    table = Table.read(STUDIES / "moving_bed_heater" / "sweep.csv")
    velocity = 1e3 * table["solid velocity [m/s]"]
    for size, colour in COLOURS.items():
        length = table[f"length for {size} mm pebbles [m]"]
        axes.plot(velocity, length, "o-", color=colour)
        known = np.isfinite(length)
        last = (velocity[known][-1], length[known][-1])
        axes.annotate(
            f" {size} mm", last, color=colour, va="center", xytext=(4, 0), **OFFSET
        )
    axes.axvspan(velocity[0], 0.57, color="0.9")
    how: dict[str, Any] = {"rotation": 90, "ha": "center", "va": "center"}
    axes.text(0.533, 0.35, "too little silica", color="0.3", **how)
    axes.set(
        title="Design: heater length for three pebble sizes",
        xscale="log",
        yscale="log",
        xlabel="silica velocity [mm/s]",
        ylabel="length [m]",
        xlim=(velocity[0], 4.6),
    )
    gallery.ticks(axes, x=(0.5, 0.7, 1, 2, 3), y=(0.05, 0.1, 0.2, 0.5, 1, 2, 3))


def draw() -> None:
    """Write the picture."""
    import matplotlib

    sizes = {"font.size": 12, "axes.titlesize": 13, "axes.labelsize": 12}
    with matplotlib.rc_context(STYLE | sizes):
        figure, ((first, second), (third, fourth)) = gallery.figure(2, 2, size=SIZE)
        beside = {"shrink": 0.9, "aspect": 22, "pad": 0.02}
        shown = heater(first)
        figure.colorbar(shown, ax=first, label="temperature of the steam [K]", **beside)
        shown = bubbling_bed(second)
        figure.colorbar(shown, ax=second, label="volume fraction of solids", **beside)
        shown = packing(third)
        figure.colorbar(
            shown, ax=third, label="temperature of the beads [°C]", **beside
        )
        design(fourth)
        figure.savefig(TARGET, dpi=DPI)


if __name__ == "__main__":
    draw()

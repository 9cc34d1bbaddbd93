"""How long must a moving bed of hot silica be to heat steam to within 10 K, and what does the solid velocity do to it?

Steam at 160 degC and 2 bar rises through silica that enters at 700 degC and sinks. For each solid velocity the length
of an adiabatic shaft is found at which the steam leaves 10 K below the silica's inlet temperature (a root search; each
trial is a run of `shaft/plug.toml`). The heater on the gmsh mesh, with wall friction and heat loss, is run beside it.

    python studies/moving_bed_heater/study.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.optimize import brentq

import contbed as cb

HERE = Path(__file__).parent
SILICA_IN = 973.15
WITHIN = 10.0
LENGTHS = (0.03, 20.0)
DIAMETERS = (0.006, 0.012, 0.024)
VELOCITIES = np.array([0.50, 0.55, 0.56, 0.58, 0.60, 0.65, 0.7, 0.8, 1.0, 1.3, 1.7, 2.2, 3.0]) * 1e-3


def approach(length: float, velocity_solid: float, diameter: float) -> float:
    """Difference between the silica entering and the steam leaving [K]."""
    overrides = {
        "mesh.length": length,
        "flow.velocity_solid": -velocity_solid,
        "bed.particle_diameter": diameter,
    }
    result = cb.run(cb.load(HERE / "shaft" / "plug.toml", overrides))
    return SILICA_IN - result.qoi["T_fluid_out_K"]


def length_needed(velocity_solid: float, diameter: float) -> float:
    """Length [m] at which the steam comes within 10 K; nan where no length is enough."""

    def excess(log_length: float) -> float:
        difference = approach(np.exp(log_length), velocity_solid, diameter)
        return np.log(max(difference, 1e-6) / WITHIN)

    low, high = np.log(LENGTHS)
    if excess(high) > 0:
        return np.nan
    return float(np.exp(brentq(excess, low, high, xtol=1e-3)))


def main() -> None:
    """Run the sweep, write sweep.csv and sweep.png."""
    table = np.array([[length_needed(v, d) for d in DIAMETERS] for v in VELOCITIES])
    names = [f"length for {1e3 * d:g} mm pebbles [m]" for d in DIAMETERS]
    header = ",".join(["solid velocity [m/s]", *names])
    np.savetxt(HERE / "sweep.csv", np.column_stack([VELOCITIES, table]), "%.5g", ",", header=header, comments="")

    plot(table)
    heater = cb.run(cb.load(HERE / "heater.toml"))
    print(f"heater, 1 m, with wall loss: steam leaves at {heater.qoi['T_fluid_out_K']:.2f} K")
    print(f"wall loss {-heater.qoi['heat_wall_W']:.0f} W of {heater.qoi['heat_top_W']:.0f} W")


def plot(table: np.ndarray) -> None:
    """Length against solid velocity, one line for each pebble size."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for column, d, colour in zip(table.T, DIAMETERS, ("#0072b2", "#d55e00", "#009e73"), strict=True):
        axes.plot(1e3 * VELOCITIES, column, "o-", color=colour, markersize=4)
        last = np.flatnonzero(np.isfinite(column))[-1]
        axes.annotate(
            f"{1e3 * d:g} mm",
            (1e3 * VELOCITIES[last], column[last]),
            (6, 0),
            textcoords="offset points",
            va="center",
            color=colour,
        )
    short = VELOCITIES[~np.isfinite(table).any(axis=1)]
    axes.axvspan(1e3 * VELOCITIES[0], 1e3 * short.max(), color="0.9")
    axes.text(
        1e3 * VELOCITIES[1],
        0.3,
        "too little silica: no length is enough",
        rotation=90,
        ha="center",
        va="center",
        color="0.35",
    )
    axes.set(yscale="log", xscale="log", xlabel="solid velocity [mm/s]", ylabel="bed length [m]")
    axes.set_xlim(1e3 * VELOCITIES[0])
    axes.set_yticks([0.05, 0.1, 0.2, 0.5, 1, 2, 3], ["0.05", "0.1", "0.2", "0.5", "1", "2", "3"])
    axes.set_xticks([0.5, 0.7, 1.0, 2.0, 3.0], ["0.5", "0.7", "1", "2", "3"])
    axes.minorticks_off()
    axes.set_title("Bed length that heats 160 degC steam to within 10 K of 700 degC silica", fontsize=11)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(HERE / "sweep.png", dpi=150)


if __name__ == "__main__":
    main()

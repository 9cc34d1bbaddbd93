"""Radiation among the solids of a bubbling bed by three algebraic closures, over the temperature of the char.

Two species (char, inert) and three (char, limestone, inert) of a hot bed: the closure of Rabi and de Souza-Santos,
eq. 34, the older network of pairs, eqs. 2-11, and the enclosure of gray surfaces, here by its radiosities.

    python studies/rabi_two_flux/closures.py        # writes closures.csv and closures.png
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contbed.closures.enclosure import exchange_equilibrium, exchange_pairwise
from contbed.closures.optics import SIGMA, Species, optics

HERE = Path(__file__).parent
SOLIDS = 0.5  # share of the emulsion's volume
CHAR = Species("char", 0.02 * SOLIDS, 3e-3, 0.85)
LIMESTONE = Species("limestone", 0.18 * SOLIDS, 1e-3, 0.40)
INERT = Species("inert", 0.80 * SOLIDS, 7e-4, 0.60)
COLOURS = {"char": "#d55e00", "limestone": "#009e73", "inert": "#0072b2"}
T_CHAR = np.linspace(1160.0, 2000.0, 85)
T_OTHERS = {"limestone": 1100.0, "inert": 1150.0}
NAMES = ("equilibrium, eq. 34", "pairwise, eqs. 2-11", "enclosure")


def by_radiosities(extinction, emissivity, T):
    """Net heat of gray surfaces 4 kappa_m whose view factors are their shares of the area [W/m3]."""
    share = extinction / extinction.sum()
    J = np.linalg.solve(np.eye(len(share)) - (1 - emissivity)[:, None] * share, emissivity[:, None] * SIGMA * T**4)
    return 4 * extinction[:, None] * (J - share @ J)


def exchange(species):
    """Heat lost by each species [W/m3]: one array (species, temperature of the char) for each closure."""
    bed = optics(species, "independent")
    extinction, emissivity = bed.absorption + bed.scattering, np.array([each.emissivity for each in species])
    T = np.array([T_CHAR if each is CHAR else np.full_like(T_CHAR, T_OTHERS[each.name]) for each in species])
    return (
        exchange_equilibrium(bed.absorption, T),
        exchange_pairwise(extinction, emissivity, T),
        by_radiosities(extinction, emissivity, T),
    )


def difference(equilibrium, other):
    """Relative to the same species."""
    return np.abs(other / equilibrium - 1)


def main() -> None:
    """Run both mixtures, write the table and the picture, print the differences."""
    mixtures = {"two": (CHAR, INERT), "three": (CHAR, LIMESTONE, INERT)}
    results = {name: exchange(species) for name, species in mixtures.items()}
    header, columns = ["T_char [K]"], [T_CHAR]
    for name, species in mixtures.items():
        equilibrium, pairs, surfaces = results[name]
        for m, each in enumerate(species):
            header += [f"{name} species: {each.name} by {closure} [W/m3]".replace(",", "") for closure in NAMES]
            columns += [equilibrium[m], pairs[m], surfaces[m]]
            ratio = pairs[m] / equilibrium[m]
            print(
                f"{name} species, {each.name}: enclosure differs by {difference(equilibrium, surfaces)[m].max():.1e}, "
                f"pairs / equilibrium {ratio.min():.4g} to {ratio.max():.4g}"
            )
    np.savetxt(HERE / "closures.csv", np.column_stack(columns), "%.10g", ",", header=",".join(header), comments="")
    plot(results, mixtures)


def plot(results, mixtures) -> None:
    """Heat lost by each of three species, and how far the pairs are from the exact exchange."""
    figure = Figure(figsize=(11, 4.8), layout="constrained")
    FigureCanvasAgg(figure)
    heat, error = figure.subplots(1, 2)
    equilibrium, pairs, _ = results["three"]
    for m, each in enumerate(mixtures["three"]):
        heat.plot(T_CHAR, equilibrium[m] / 1e6, color=COLOURS[each.name])
        heat.plot(T_CHAR, pairs[m] / 1e6, "--", color=COLOURS[each.name])
        heat.annotate(
            each.name,
            (T_CHAR[-1], equilibrium[m, -1] / 1e6),
            (5, 0),
            textcoords="offset points",
            va="center",
            color=COLOURS[each.name],
        )
        error.semilogy(T_CHAR, difference(equilibrium, pairs)[m], color=COLOURS[each.name])
    heat.plot([], [], "k", label="exact: eq. 34 and enclosure")
    heat.plot([], [], "k--", label="pairs, eqs. 2-11")
    heat.axhline(0, color="0.7", linewidth=0.6)
    heat.legend(frameon=False, loc="upper left")
    heat.set(title="Three species", ylabel="heat lost by radiation [MW/m$^3$]")
    for m, each in enumerate(mixtures["two"]):
        both = difference(*results["two"][:2])[m]
        error.semilogy(T_CHAR, np.where(both > 0, both, np.nan), ".", markersize=4, color=COLOURS[each.name])
    error.text(1580, 3e-13, "two species: round-off", ha="center")
    error.text(1580, 4e-4, "three species", ha="center")
    error.set(title="Pairs against the exact exchange", ylabel="relative difference", ylim=(1e-17, 10))
    for axes in (heat, error):
        axes.set_xlabel("temperature of the char [K]")
        axes.spines[["top", "right"]].set_visible(False)
    heat.set_xlim(T_CHAR[0], T_CHAR[-1] + 130)
    figure.savefig(HERE / "closures.png", dpi=130)


if __name__ == "__main__":
    main()

"""Radiation among the solids of a bubbling bed by three algebraic closures, over the
temperature of the char.

Two species (char, inert) and three (char, limestone, inert) of a hot bed: the closure
of Rabi and de Souza-Santos, eq. 34, the older network of pairs, eqs. 2-11, and the
enclosure of gray surfaces, here by its radiosities.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.closures.enclosure import exchange_equilibrium, exchange_pairwise
from contbed.closures.optics import SIGMA, Species, optics
from studies import _gallery as gallery
from studies._gallery import Table, Tables

SOLIDS = 0.5  # share of the emulsion's volume
CHAR = Species("char", 0.02 * SOLIDS, 3e-3, 0.85)
LIMESTONE = Species("limestone", 0.18 * SOLIDS, 1e-3, 0.40)
INERT = Species("inert", 0.80 * SOLIDS, 7e-4, 0.60)
COLOURS = {"char": gallery.VERMILION, "limestone": gallery.GREEN, "inert": gallery.BLUE}
T_CHAR = np.linspace(1160.0, 2000.0, 85)
T_OTHERS = {"limestone": 1100.0, "inert": 1150.0}
MIXTURES = {"two": (CHAR, INERT), "three": (CHAR, LIMESTONE, INERT)}
NAMES = ("equilibrium, eq. 34", "pairwise, eqs. 2-11", "enclosure")


def reference(extinction: Any, emissivity: Any, T: Any) -> Any:
    """By radiosities: net heat of gray surfaces 4 kappa_m whose view factors are
    their shares of the area [W/m3].
    """
    share = extinction / extinction.sum()
    J = np.linalg.solve(
        np.eye(len(share)) - (1 - emissivity)[:, None] * share,
        emissivity[:, None] * SIGMA * T**4,
    )
    return 4 * extinction[:, None] * (J - share @ J)


def exchange(species: tuple[Species, ...]) -> tuple[Any, Any, Any]:
    """Heat lost by each species [W/m3]: one array (species, temperature of the char)
    for each closure.
    """
    bed = optics(species, "independent")
    extinction, emissivity = (
        bed.absorption + bed.scattering,
        np.array([each.emissivity for each in species]),
    )
    T = np.array(
        [
            T_CHAR if each is CHAR else np.full_like(T_CHAR, T_OTHERS[each.name])
            for each in species
        ]
    )
    return (
        exchange_equilibrium(bed.absorption, T),
        exchange_pairwise(extinction, emissivity, T),
        reference(extinction, emissivity, T),
    )


def header(mixture: str, species: Species, closure: str) -> str:
    """Column of a mixture, species and closure."""
    return f"{mixture} species: {species.name} by {closure} [W/m3]".replace(",", "")


def compute() -> Tables:
    """Heat lost by each species of both mixtures."""
    columns = {"T_char [K]": T_CHAR}
    for mixture, species in MIXTURES.items():
        for closure, values in zip(NAMES, exchange(species), strict=True):
            columns |= {
                header(mixture, each, closure): values[m]
                for m, each in enumerate(species)
            }
    order = [
        "T_char [K]",
        *(
            header(x, each, name)
            for x, kinds in MIXTURES.items()
            for each in kinds
            for name in NAMES
        ),
    ]
    return {
        "closures": Table.from_columns({name: columns[name] for name in order}, ".10g")
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Heat lost by each of three species, and how far the pairs are from the exact
    exchange.
    """
    figure, (heat, error) = gallery.figure(1, 2, size=(11, 4.8))
    table = tables["closures"]

    def column(mixture: str, species: Species, closure: str) -> Any:
        return table[header(mixture, species, closure)]

    for each in MIXTURES["three"]:
        colour = COLOURS[each.name]
        exact, pairs = (column("three", each, name) for name in NAMES[:2])
        heat.plot(T_CHAR, exact / 1e6, color=colour)
        heat.plot(T_CHAR, pairs / 1e6, "--", color=colour)
        gallery.label_line(heat, each.name, T_CHAR[-1], exact[-1] / 1e6, colour, (5, 0))
        error.semilogy(T_CHAR, np.abs(pairs / exact - 1), color=colour)
    heat.plot([], [], "k", label="exact: eq. 34 and enclosure")
    heat.plot([], [], "k--", label="pairs, eqs. 2-11")
    heat.axhline(0, color="0.7", linewidth=0.6)
    heat.legend(loc="upper left")
    heat.set(title="Three species", ylabel="heat lost by radiation [MW/m$^3$]")
    error.text(1580, 4e-4, "three species; two agree to 2e-12", ha="center")
    error.set(
        title="Pairs against the exact exchange",
        ylabel="relative difference",
        ylim=(1e-5, 10),
    )
    for axes in (heat, error):
        axes.set_xlabel("temperature of the char [K]")
    heat.set_xlim(T_CHAR[0], T_CHAR[-1] + 130)
    return {"closures": figure}

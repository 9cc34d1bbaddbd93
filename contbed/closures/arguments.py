"""Arguments and results of closures: symbol, unit and meaning, each stated once.

A data sheet takes its rows from `arguments.csv` beside this file; a row with a kind is
what the argument means in the closures of that kind alone. Constants of a single law,
and an argument that means something special in one law, stand in the docstring of that
closure.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple


class Argument(NamedTuple):
    """Unit and meaning of an argument, and the values that a scene may give it."""

    unit: str
    meaning: str
    bounds: str


def _read() -> Iterator[tuple[str, str, Argument]]:
    """Yield name, kind of closure or "", and description of each row of
    `arguments.csv`.
    """
    text = Path(__file__).with_suffix(".csv").read_text(encoding="utf-8")
    for name, kind, unit, bounds, meaning in list(csv.reader(text.splitlines()))[1:]:
        yield name, kind, Argument(unit, meaning, bounds)


_OF_KIND = {(name, kind): argument for name, kind, argument in _read()}

ARGUMENTS = {name: found for (name, kind), found in _OF_KIND.items() if not kind}
"""Unit and meaning of an argument in every kind of closure."""

RESULTS: dict[str, str] = {
    "bed_tube": "coefficient of a surface in the bed",
    "bubble_fraction": "share of bubbles in the volume of the bed",
    "bubble_growth": "growth per height",
    "bubble_heat": "per volume of bubbles: `bubbling_bed.bubbles.exchange`",
    "bubble_rise": "absolute velocity, upward",
    "bubble_size": "diameter of the sphere of equal volume",
    "bubble_start": "diameter",
    "conductivity": "effective stagnant conductivity",
    "contact": "coefficient of the contact",
    "contact_separation": "distance of the mean planes",
    "decay": "decay constant",
    "drag": "drag coefficient per volume of the bed",
    "eddy_viscosity": "kinematic eddy viscosity of the gas",
    "effective_restitution": "restitution that the dissipation has in place of e",
    "ejection": "solids thrown up from the surface of the bed",
    "elutriation": (
        "elutriation rate constant, times the mass fraction of the size the flow above "
        "the disengaging height"
    ),
    "emulsion_gas": "gas through the emulsion, per section of emulsion",
    "expansion": "ratio of the heights",
    "forchheimer": "Forchheimer constant",
    "gas_exchange": "volume exchanged per volume of bubbles and time",
    "granular_bulk_viscosity": "bulk/(rho_s d_p sqrt(theta))",
    "granular_conductivity": "k/(rho_s d_p sqrt(theta))",
    "granular_dissipation": "gamma d_p/(rho_s theta^1.5)",
    "granular_friction": "frictional pressure",
    "granular_friction_viscosity": "frictional viscosity",
    "granular_pressure": "p/(rho_s theta)",
    "granular_production": "S d_p^3 rho_s theta^0.5/(mu^2 slip^2)",
    "granular_viscosity": "mu/(rho_s d_p sqrt(theta))",
    "mass_dispersion": "axial dispersion coefficient",
    "minimum_fluidization": "Reynolds number of u_mf and the particle diameter",
    "nusselt": "Nusselt number on d_p and k_fluid",
    "nusselt_cylinder": "Nusselt number on the diameter of the cylinder",
    "permeability": "permeability",
    "pressure_gradient": "-dp/dx, of the sign of u",
    "radial_distribution": "radial distribution",
    "sherwood": "Sherwood number on d_p and the diffusion coefficient of the species",
    "solid_exchange": "per volume of emulsion: `solids.NAME.exchange` of a scene",
    "solids_mixing": "axial dispersion of the solids",
    "temperature_jump": "length of gas added to the gap",
    "terminal_velocity": "terminal velocity",
    "tortuosity": "tortuosity parameter G, never positive",
    "wall": "wall heat transfer coefficient",
    "wall_drag": "drag of cells that do not resolve clusters, over that far from walls",
    "wall_pressure": "pressure of the particles of such cells, over that far from walls",
    "wall_viscosity": "viscosity of the particles of such cells, over that far from "
    "walls",
}
"""What the closures of a kind return."""


def argument(name: str, kind: str) -> Argument | None:
    """Return unit and meaning of an argument in a closure of a kind, None where only
    the closure itself can say it.
    """
    return _OF_KIND.get((name, kind)) or ARGUMENTS.get(name)

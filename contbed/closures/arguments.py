"""Arguments and results of closures: symbol, unit and meaning, each stated once.

A data sheet takes its rows from here. Constants of a single law, and an argument that means something special in one
law, stand in the docstring of that closure.
"""

from __future__ import annotations

from typing import NamedTuple


class Argument(NamedTuple):
    """Unit and meaning of an argument, and the values that a scene may give it."""

    unit: str
    meaning: str
    bounds: str = ""


ARGUMENTS: dict[str, Argument] = {
    "Ar": Argument("-", "Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2"),
    "D_bed": Argument("m", "diameter of the bed", "(0, inf)"),
    "D_gas": Argument("m2/s", "diffusion coefficient"),
    "Pe": Argument("-", "superficial Peclet number on d_p"),
    "Pr": Argument("-", "Prandtl number of the fluid"),
    "Re": Argument("-", "superficial Reynolds number on d_p"),
    "T": Argument("K", "temperature"),
    "albedo": Argument("-", "K_s / beta"),
    "angle": Argument("rad", "angle of internal friction"),
    "area": Argument("m2", "area of plate for one orifice", "(0, inf)"),
    "cp_1": Argument("J/kg/K", "heat capacity of kind 1"),
    "cp_2": Argument("J/kg/K", "heat capacity of kind 2"),
    "cp_gas": Argument("J/kg/K", "heat capacity of the gas"),
    "cp_solid": Argument("J/kg/K", "heat capacity of the particles"),
    "d_1": Argument("m", "diameter of kind 1"),
    "d_2": Argument("m", "diameter of kind 2"),
    "d_b": Argument("m", "diameter of the bubbles"),
    "d_p": Argument("m", "particle diameter", "(0, inf)"),
    "delta": Argument("-", "share of bubbles in the volume"),
    "e": Argument("-", "restitution of two particles"),
    "emissivity": Argument("-", "emissivity of the particle surface", "(0, 1]"),
    "eps": Argument("-", "porosity"),
    "eps_max": Argument("-", "densest packing"),
    "eps_mf": Argument("-", "voidage at minimum fluidization"),
    "eps_min": Argument("-", "fraction above which particles rub", "[0, 1)"),
    "eps_s": Argument("-", "fraction of the particles"),
    "f_1": Argument("-", "share of kind 1 in the volume of the emulsion"),
    "f_2": Argument("-", "share of kind 2 in the volume of the emulsion"),
    "g0": Argument("-", "radial distribution at contact"),
    "k_1": Argument("W/m/K", "conductivity of the material of kind 1"),
    "k_2": Argument("W/m/K", "conductivity of the material of kind 2"),
    "k_fluid": Argument("W/m/K", "conductivity of the fluid"),
    "k_gas": Argument("W/m/K", "conductivity of the gas"),
    "k_solid": Argument("W/m/K", "conductivity of the solid"),
    "k_stagnant": Argument("W/m/K", "effective conductivity of the bed without flow"),
    "kinetic": Argument("-", "share of the kinetic part that guards leave"),
    "modulus": Argument("Pa", "of the pair, 4/3 over the sum of (1 - nu^2) / E", "(0, inf)"),
    "molar_mass": Argument("kg/mol", "molar mass of the gas"),
    "mu": Argument("Pa s", "viscosity of the gas"),
    "p": Argument("Pa", "pressure"),
    "p_friction": Argument("Pa", "frictional pressure"),
    "restitution": Argument("-", "coefficient of restitution", "[0, 1]"),
    "rho": Argument("kg/m3", "density of the fluid"),
    "rho_1": Argument("kg/m3", "density of kind 1"),
    "rho_2": Argument("kg/m3", "density of kind 2"),
    "rho_gas": Argument("kg/m3", "density of the gas"),
    "rho_solid": Argument("kg/m3", "density of the particles"),
    "shape": Argument("-", "1.25 spheres, 1.4 broken material, 2.5 cylinders", "(0, inf)"),
    "shear_rate": Argument("1/s", "square root of the second invariant of the strain rate"),
    "slip": Argument("m/s", "velocity of impact, of the order of u - u_mf"),
    "sphericity": Argument("-", "phi, surface of the sphere of equal volume over that of the particle", "(0, 1]"),
    "u": Argument("m/s", "superficial velocity"),
    "u_b": Argument("m/s", "velocity of the bubbles"),
    "u_excess": Argument("m/s", "u - u_mf"),
    "u_gas": Argument("m/s", "superficial velocity in the freeboard"),
    "u_mf": Argument("m/s", "superficial velocity at minimum fluidization"),
    "u_t": Argument("m/s", "terminal velocity"),
    "wake": Argument("-", "volume of wake over that of bubble", "[0, 1)"),
    "z": Argument("m", "height above the distributor"),
}
"""Unit and meaning of an argument in every kind of closure."""

OF_KIND: dict[str, dict[str, Argument]] = {
    "drag": {"Re": Argument("-", "superficial Reynolds number eps rho |u_gas - u_solid| d_p/mu")},
}
"""Arguments that mean something else in one kind of closure."""

RESULTS: dict[str, str] = {
    "bed_tube": "coefficient of a surface in the bed",
    "bubble_fraction": "share of bubbles in the volume of the bed",
    "bubble_growth": "growth per height",
    "bubble_heat": "per volume of bubbles: `bubbles.exchange` of a scene",
    "bubble_rise": "absolute velocity, upward",
    "bubble_size": "diameter of the sphere of equal volume",
    "bubble_start": "diameter",
    "conductivity": "effective stagnant conductivity",
    "decay": "decay constant",
    "drag": "drag coefficient per volume of the bed",
    "ejection": "solids thrown up from the surface of the bed",
    "elutriation": (
        "elutriation rate constant, times the mass fraction of the size the flow above the disengaging height"
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
    "granular_viscosity": "mu/(rho_s d_p sqrt(theta))",
    "minimum_fluidization": "Reynolds number of u_mf and the particle diameter",
    "nusselt": "Nusselt number on d_p and k_fluid",
    "permeability": "permeability",
    "pressure_gradient": "-dp/dx, of the sign of u",
    "radial_distribution": "radial distribution",
    "solid_exchange": "per volume of emulsion: `species.NAME.exchange` of a scene",
    "solids_mixing": "axial dispersion of the solids",
    "terminal_velocity": "terminal velocity",
    "tortuosity": "tortuosity parameter G, never positive",
    "wall": "wall heat transfer coefficient",
}
"""What the closures of a kind return."""


def argument(name: str, kind: str) -> Argument | None:
    """Return unit and meaning of an argument in a closure of a kind, None where only the closure itself can say it."""
    return OF_KIND.get(kind, {}).get(name) or ARGUMENTS.get(name)

"""Arguments and results of closures: symbol, unit and meaning, each stated once.

A data sheet takes its rows from here. Constants of a single law, and an argument that
means something special in one law, stand in the docstring of that closure.
"""

from __future__ import annotations

from typing import NamedTuple


class Argument(NamedTuple):
    """Unit and meaning of an argument, and the values that a scene may give it."""

    unit: str
    meaning: str
    bounds: str = ""


ARGUMENTS: dict[str, Argument] = {
    "Ar": Argument(
        "-", "Archimedes number d_p^3 rho (rho_solid - rho) g / mu^2", "(0, inf)"
    ),
    "D_bed": Argument("m", "diameter of the bed", "(0, inf)"),
    "D_gas": Argument("m2/s", "diffusion coefficient", "(0, inf)"),
    "Pe": Argument("-", "superficial Peclet number on d_p", "[0, inf)"),
    "Pr": Argument("-", "Prandtl number of the fluid", "(0, inf)"),
    "Re": Argument("-", "superficial Reynolds number on d_p", "[0, inf)"),
    "Re_t": Argument(
        "-", "Reynolds number on d_p of Stokes' terminal velocity", "(0, inf)"
    ),
    "Sc": Argument("-", "Schmidt number of the species in the gas", "(0, inf)"),
    "T": Argument("K", "temperature", "(0, inf)"),
    "accommodation": Argument(
        "-", "thermal accommodation coefficient of the gas on the surface", "(0, 1]"
    ),
    "albedo": Argument("-", "K_s / beta", "[0, 1]"),
    "angle": Argument("rad", "angle of internal friction", "(0, 1.5)"),
    "area": Argument("m2", "area of plate for one orifice", "(0, inf)"),
    "contact_time": Argument(
        "s", "mean time that particles stay at the wall", "(0, inf)"
    ),
    "cp_1": Argument("J/kg/K", "heat capacity of kind 1", "(0, inf)"),
    "cp_2": Argument("J/kg/K", "heat capacity of kind 2", "(0, inf)"),
    "cp_gas": Argument("J/kg/K", "heat capacity of the gas", "(0, inf)"),
    "cp_solid": Argument("J/kg/K", "heat capacity of the particles", "(0, inf)"),
    "d_1": Argument("m", "diameter of kind 1", "(0, inf)"),
    "d_2": Argument("m", "diameter of kind 2", "(0, inf)"),
    "d_b": Argument("m", "diameter of the bubbles", "(0, inf)"),
    "d_p": Argument("m", "particle diameter", "(0, inf)"),
    "delta": Argument("-", "share of bubbles in the volume", "[0, 1)"),
    "drag_rate": Argument(
        "1/s", "drag coefficient over the mass of gas in the volume", "[0, inf)"
    ),
    "e": Argument("-", "restitution of two particles", "[0, 1]"),
    "emissivity": Argument("-", "emissivity of the particle surface", "(0, 1]"),
    "eps": Argument("-", "porosity", "(0, 1]"),
    "eps_max": Argument("-", "densest packing", "(0, 1)"),
    "eps_mf": Argument("-", "voidage at minimum fluidization", "(0, 1)"),
    "eps_min": Argument("-", "fraction above which particles rub", "[0, 1)"),
    "eps_s": Argument("-", "fraction of the particles", "[0, 1)"),
    "f_1": Argument("-", "share of kind 1 in the volume of the emulsion", "[0, 1]"),
    "f_2": Argument("-", "share of kind 2 in the volume of the emulsion", "[0, 1]"),
    "filter_froude": Argument(
        "-", "filter size times g over the square of the terminal velocity", "[0, inf)"
    ),
    "g0": Argument("-", "radial distribution at contact", "[1, inf)"),
    "gamma": Argument("-", "ratio of the heat capacities of the gas", "(1, 2)"),
    "hardness": Argument("Pa", "microhardness of the softer solid", "(0, inf)"),
    "k_1": Argument("W/m/K", "conductivity of the material of kind 1", "(0, inf)"),
    "k_2": Argument("W/m/K", "conductivity of the material of kind 2", "(0, inf)"),
    "k_fluid": Argument("W/m/K", "conductivity of the fluid", "(0, inf)"),
    "k_gas": Argument("W/m/K", "conductivity of the gas", "(0, inf)"),
    "k_solid": Argument("W/m/K", "conductivity of the solid", "(0, inf)"),
    "k_stagnant": Argument(
        "W/m/K", "effective conductivity of the bed without flow", "(0, inf)"
    ),
    "kinetic": Argument("-", "share of the kinetic part that guards leave", "[0, 1]"),
    "mean_free_path": Argument("m", "mean free path of the gas", "[0, inf)"),
    "modulus": Argument(
        "Pa", "of the pair, 4/3 over the sum of (1 - nu^2) / E", "(0, inf)"
    ),
    "molar_mass": Argument("kg/mol", "molar mass of the gas", "(0, inf)"),
    "mu": Argument("Pa s", "viscosity of the gas", "(0, inf)"),
    "nu": Argument("m2/s", "kinematic viscosity of the gas", "(0, inf)"),
    "p": Argument("Pa", "pressure", "(0, inf)"),
    "p_friction": Argument("Pa", "frictional pressure", "[0, inf)"),
    "pressure": Argument("Pa", "load over the nominal area of the contact", "(0, inf)"),
    "radius": Argument(
        "m", "of the pipe, or half the width of the channel", "(0, inf)"
    ),
    "restitution": Argument("-", "coefficient of restitution", "[0, 1]"),
    "rho": Argument("kg/m3", "density of the fluid", "(0, inf)"),
    "rho_1": Argument("kg/m3", "density of kind 1", "(0, inf)"),
    "rho_2": Argument("kg/m3", "density of kind 2", "(0, inf)"),
    "rho_gas": Argument("kg/m3", "density of the gas", "(0, inf)"),
    "rho_solid": Argument("kg/m3", "density of the particles", "(0, inf)"),
    "roughness": Argument(
        "m",
        "root mean square of both surfaces, sqrt(sigma_1^2 + sigma_2^2)",
        "(0, inf)",
    ),
    "shape": Argument(
        "-", "1.25 spheres, 1.4 broken material, 2.5 cylinders", "(0, inf)"
    ),
    "shear_rate": Argument(
        "1/s", "square root of the second invariant of the strain rate", "[0, inf)"
    ),
    "sliding_friction": Argument(
        "-", "Coulomb's coefficient of two particles", "[0, inf)"
    ),
    "slip": Argument("m/s", "velocity of impact, of the order of u - u_mf", "[0, inf)"),
    "slope": Argument(
        "-",
        "mean slope of the asperities of both surfaces, sqrt(m_1^2 + m_2^2)",
        "(0, inf)",
    ),
    "sphericity": Argument(
        "-",
        "phi, surface of the sphere of equal volume over that of the particle",
        "(0, 1]",
    ),
    "terminal_froude": Argument(
        "-", "v_t^2/(g d_p) of Stokes' terminal velocity v_t", "(0, inf)"
    ),
    "u": Argument("m/s", "superficial velocity"),
    "u_b": Argument("m/s", "velocity of the bubbles", "(0, inf)"),
    "u_excess": Argument("m/s", "u - u_mf", "[0, inf)"),
    "u_friction": Argument(
        "m/s", "friction velocity of the gas alone at the same flow", "(0, inf)"
    ),
    "u_gas": Argument("m/s", "superficial velocity in the freeboard", "[0, inf)"),
    "u_mf": Argument("m/s", "superficial velocity at minimum fluidization", "(0, inf)"),
    "u_t": Argument("m/s", "terminal velocity", "(0, inf)"),
    "v": Argument("m/s", "velocity of the gas between the particles", "[0, inf)"),
    "wake": Argument("-", "volume of wake over that of bubble", "[0, 1)"),
    "wall_froude": Argument(
        "-",
        "distance from the wall times g over the square of the terminal velocity",
        "[0, inf)",
    ),
    "y": Argument("m", "distance from the wall", "[0, inf)"),
    "z": Argument("m", "height above the distributor", "[0, inf)"),
}
"""Unit and meaning of an argument in every kind of closure."""

OF_KIND: dict[str, dict[str, Argument]] = {
    "drag": {
        "Re": Argument(
            "-",
            "superficial Reynolds number eps rho |u_gas - u_solid| d_p/mu",
            "[0, inf)",
        )
    },
    "nusselt_cylinder": {
        "Re": Argument(
            "-", "Reynolds number of the free stream on the diameter", "[0, inf)"
        )
    },
}
"""Arguments that mean something else in one kind of closure."""

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
    return OF_KIND.get(kind, {}).get(name) or ARGUMENTS.get(name)

"""Every quantity that a run writes: fields, columns of tables, and named results, each
with unit and meaning.

Output, plots, sweeps and the manual read names, symbols and units here and nowhere
else. A part in capitals is chosen by the scene: NAME is a boundary, a solid phase, a
gas or a surface; PHASE is fluid, solid, emulsion or bubble. Headers of columns are
"name [unit]", "T_fluid [K]"; a dimensionless quantity has the unit 1.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache


@dataclass(frozen=True)
class Field:
    """One quantity in SI. `symbol` is mathtext; `lower` is an open bound; unit "1"
    is dimensionless.
    """

    name: str
    symbol: str
    unit: str
    description: str
    lower: float = -math.inf

    @property
    def header(self) -> str:
        """Column header, "T_fluid [K]"."""
        return f"{self.name} [{self.unit}]"

    @property
    def label(self) -> str:
        """Axis label with symbol and unit; a dimensionless quantity shows none."""
        return f"${self.symbol}$" + ("" if self.unit == "1" else f" [{self.unit}]")


# coordinates and fields, in profiles, tables and field files
_FIELDS = (
    Field("x", "x", "m", "coordinate along a planar bed or a box"),
    Field("y", "y", "m", "coordinate across a planar bed or a box"),
    Field("z", "z", "m", "height in a box, or coordinate along an axisymmetric bed"),
    Field("r", "r", "m", "distance from the axis of an axisymmetric bed"),
    Field("t", "t", "s", "time since the start of the run"),
    Field("dt", r"\Delta t", "s", "length of the last time step"),
    Field("T_fluid", r"T_\mathrm{f}", "K", "temperature of the fluid", lower=0.0),
    Field("T_solid", r"T_\mathrm{s}", "K", "temperature of the solid", lower=0.0),
    Field(
        "T_solid_NAME",
        r"T_\mathrm{NAME}",
        "K",
        "temperature of a solid phase",
        lower=0.0,
    ),
    Field(
        "T_surface",
        r"T_\mathrm{surface}",
        "K",
        "temperature of the surface of the particles",
        lower=0.0,
    ),
    Field(
        "T_centre",
        r"T_\mathrm{centre}",
        "K",
        "temperature in the centre of the particles",
        lower=0.0,
    ),
    Field(
        "T_fluid_axis",
        r"T_\mathrm{f,0}",
        "K",
        "temperature of the fluid at the axis of the bed",
        lower=0.0,
    ),
    Field(
        "T_fluid_wall",
        r"T_\mathrm{f,R}",
        "K",
        "temperature of the fluid at the wall of the bed",
        lower=0.0,
    ),
    Field(
        "T_solid_axis",
        r"T_\mathrm{s,0}",
        "K",
        "temperature of the particles at the axis of the bed",
        lower=0.0,
    ),
    Field(
        "T_solid_wall",
        r"T_\mathrm{s,R}",
        "K",
        "temperature of the particles at the wall of the bed",
        lower=0.0,
    ),
    Field(
        "T_solid_NAME_axis",
        r"T_\mathrm{NAME,0}",
        "K",
        "temperature of a solid phase at the axis of the bed",
    ),
    Field(
        "T_solid_NAME_wall",
        r"T_\mathrm{NAME,R}",
        "K",
        "temperature of a solid phase at the wall of the bed",
    ),
    Field("T_mean", r"\overline{T}", "K", "mean temperature of a particle", lower=0.0),
    Field(
        "mass_fraction", "m", "1", "mass that is left over that of the fresh particle"
    ),
    Field("T_gas", r"T_\mathrm{g}", "K", "temperature of the gas", lower=0.0),
    Field("theta_fluid", r"\theta_\mathrm{f}", "1", "scaled temperature of the fluid"),
    Field("theta_solid", r"\theta_\mathrm{s}", "1", "scaled temperature of the solid"),
    Field("u", "u", "m/s", "superficial velocity of the fluid"),
    Field("u_x", "u_x", "m/s", "superficial velocity of the fluid along x"),
    Field("u_y", "u_y", "m/s", "superficial velocity of the fluid along y"),
    Field("u_z", "u_z", "m/s", "superficial velocity of the fluid along z"),
    Field("u_r", "u_r", "m/s", "superficial velocity of the fluid away from the axis"),
    Field("speed", "|u|", "m/s", "magnitude of the superficial velocity of the fluid"),
    Field("rho_fluid", r"\rho_\mathrm{f}", "kg/m3", "density of the fluid", lower=0.0),
    Field("p", "p", "Pa", "pressure of the fluid over that at the outlet"),
    Field("p_gas", "p", "Pa", "pressure of a gas"),
    Field(
        "w_NAME",
        r"w_\mathrm{NAME}",
        "1",
        "mass fraction of a constituent of the solids, of X_KIND in its kind",
    ),
    Field(
        "n_NAME",
        r"n_\mathrm{NAME}",
        "mol/m3",
        "moles of a reacting constituent of the solids per volume of bed",
    ),
    Field(
        "p0",
        "p_0",
        "Pa",
        "pressure of a gas of variable density, the same in all of the vessel",
    ),
    Field(
        "G",
        "G",
        "W/m2",
        "incident radiation, the intensity integrated over all directions",
    ),
    Field(
        "angle",
        r"\varphi",
        "deg",
        "angle around a tube from its bottom, counterclockwise",
    ),
    Field("h", "h", "W/m2/K", "heat transfer coefficient of a sector of a tube"),
    Field("h_contact", "h", "W/m2/K", "part of it through contacts of particles"),
    Field(
        "h_gap", "h", "W/m2/K", "part of it through the gas between particles and tube"
    ),
    Field(
        "h_convection",
        "h",
        "W/m2/K",
        "part of it by the gas that flows beside the tube",
    ),
    Field("contacts", "n", "1", "number of particles that touch a sector of a tube"),
    Field(
        "eps",
        r"\varepsilon",
        "1",
        "porosity within a particle's diameter of a sector of a tube",
    ),
    Field(
        "q",
        "q",
        "W/m2",
        "heat flux from a sector of a tube to particles and gas as warm as they are "
        "beside it",
    ),
    Field(
        "heat_NAME",
        "Q",
        "J",
        "heat from a wall into the bed since the start; per m2 on a line, per m in a "
        "plane",
    ),
    Field(
        "heat_tube",
        "Q",
        "W",
        "heat from a tube to gas and particles, since the last row",
    ),
    Field("q_radiation", r"q_\mathrm{r}", "W/m2", "radiative heat flux along the bed"),
    # two fluids
    Field(
        "speed_solid",
        r"|u_\mathrm{s}|",
        "m/s",
        "magnitude of the velocity of the particles, averaged over time",
    ),
    Field("eps_s", r"\varepsilon_\mathrm{s}", "1", "solids volume fraction"),
    Field(
        "eps_s_max",
        r"\varepsilon_\mathrm{s,max}",
        "1",
        "largest solids volume fraction",
    ),
    Field("u_gas", r"u_\mathrm{g}", "m/s", "velocity of the gas between the particles"),
    Field("u_solid", r"u_\mathrm{s}", "m/s", "velocity of the particles"),
    Field(
        "u_solid_max", r"u_\mathrm{s,max}", "m/s", "largest velocity of the particles"
    ),
    Field(
        "theta",
        r"\Theta",
        "m2/s2",
        "granular temperature, a third of the mean square of the velocity fluctuation",
    ),
    Field(
        "theta_mean",
        r"\overline{\Theta}",
        "m2/s2",
        "mean granular temperature, weighted with the solids",
    ),
    Field(
        "theta_total",
        r"\Theta_\mathrm{t}",
        "m2/s2",
        "granular temperature with the resolved motion",
    ),
    Field("theta_centre", r"\Theta_0", "m2/s2", "granular temperature at the centre"),
    Field("beta", r"\beta", "kg/m3/s", "drag coefficient per volume of the bed"),
    Field("mu_solid", r"\mu_\mathrm{s}", "Pa s", "shear viscosity of the particles"),
    Field("solids", r"m_\mathrm{s}", "kg", "mass of the particles in the vessel"),
    Field(
        "centre_of_solids",
        r"z_\mathrm{s}",
        "m",
        "height of the centre of mass of the particles",
    ),
    Field(
        "pressure_gradient",
        r"-\mathrm{d}p/\mathrm{d}z",
        "Pa/m",
        "pressure gradient that drives the flow",
    ),
    Field("frequency", "f", "Hz", "frequency of a spectrum"),
    Field("spectral_density", "S", "Pa2 s", "power of the pressure drop per frequency"),
    Field(
        "T_gas_mean",
        r"\overline{T}_\mathrm{g}",
        "K",
        "mean temperature of the gas, by mass",
        lower=0.0,
    ),
    Field(
        "T_gas_max",
        r"T_\mathrm{g,max}",
        "K",
        "largest temperature of the gas",
        lower=0.0,
    ),
    Field(
        "T_solid_mean",
        r"\overline{T}_\mathrm{s}",
        "K",
        "mean temperature of the particles, by mass",
        lower=0.0,
    ),
    Field(
        "T_solid_max",
        r"T_\mathrm{s,max}",
        "K",
        "largest temperature of the particles",
        lower=0.0,
    ),
    # particles
    Field(
        "pressure_drop",
        r"\Delta p",
        "Pa",
        "pressure of the gas below a bed of particles over that above",
    ),
    Field("height", "H", "m", "mean height of the surface of a bed of particles"),
    Field(
        "height_max",
        r"H_\mathrm{max}",
        "m",
        "height of the centre of the highest particle",
    ),
    Field("coordination", "z", "1", "mean number of touching neighbours of a particle"),
    Field("radius", "R", "m", "radius of a particle"),
    Field("velocity", "v", "m/s", "velocity of a particle, three components"),
    Field("force", "F", "N", "force of the gas on a particle, three components"),
    # bubbling beds
    Field("u_mf", r"u_\mathrm{mf}", "m/s", "minimum fluidization velocity"),
    Field(
        "u_e", r"u_\mathrm{e}", "m/s", "superficial velocity of the gas in the emulsion"
    ),
    Field("u_b", r"u_\mathrm{b}", "m/s", "rise velocity of the bubbles"),
    Field("delta", r"\delta", "1", "share of the bubbles in the volume of the bed"),
    Field("d_b", r"d_\mathrm{b}", "m", "diameter of the bubbles"),
    Field(
        "flow_bubble", r"\dot m_\mathrm{b}", "kg/s", "mass flow of the gas in bubbles"
    ),
    Field(
        "flow_up",
        r"\dot m_\mathrm{up}",
        "kg/m2/s",
        "flux of particles that rise in the freeboard",
    ),
    Field(
        "G_freeboard", r"G_\mathrm{fb}", "W/m2", "incident radiation in the freeboard"
    ),
    Field(
        "T_NAME",
        r"T_\mathrm{NAME}",
        "K",
        "temperature of a solid phase, a gas or a surface",
        lower=0.0,
    ),
    Field(
        "h_NAME_water",
        r"h_\mathrm{NAME}",
        "kJ/kg",
        "enthalpy of water inside of a surface",
    ),
    Field("x_NAME", r"x_\mathrm{NAME}", "1", "mole fraction of a gas"),
    Field(
        "q_NAME",
        r"q_\mathrm{NAME}",
        "mol/kg",
        "moles of a gas in the particles, adsorbed and in pores, per mass",
    ),
    Field(
        "moisture", r"n_\mathrm{H_2O}", "mol/m", "moisture of the fuel held per height"
    ),
    Field("volatiles", r"m_\mathrm{v}", "kg/m", "mass of volatiles held per height"),
    Field("char", r"n_\mathrm{C}", "mol/m", "char held per height"),
    Field("CaCO3", r"n_\mathrm{CaCO_3}", "mol/m", "limestone held per height"),
    Field("CaO", r"n_\mathrm{CaO}", "mol/m", "lime held per height"),
    Field("CaSO4", r"n_\mathrm{CaSO_4}", "mol/m", "sulphate held per height"),
    # branches of steady states
    Field("point", "n", "1", "number of a point on a branch of steady states"),
    Field(
        "NAME_convection",
        "Q",
        "W",
        "heat that leaves the particles to a surface by convection",
    ),
    Field(
        "NAME_radiation",
        "Q",
        "W",
        "heat that leaves the particles to a surface by radiation",
    ),
    Field("turns", "k", "1", "number of folds passed on the way to a point"),
)

# named results, the keys of `qoi`; most end with their unit
_RESULTS = (
    # packed beds
    Field(
        "T_PHASE_out_K",
        r"T_\mathrm{out}",
        "K",
        "mean outlet temperature of a stream, weighted with its mass flux",
    ),
    Field(
        "heat_NAME_W",
        r"Q",
        "W",
        "heat into the bed through a boundary; per m2 on a line, per m in a plane",
    ),
    Field(
        "heat_NAME_error",
        r"\Delta Q/Q",
        "1",
        "estimate of the error that the mesh leaves in the heat of a wall: the change "
        "if all that enters the cells beside it mixed with what it has heated there",
    ),
    Field(
        "coefficient_NAME_W_m2K",
        "h",
        "W/m2/K",
        "mean heat flux of a wall over the difference between its temperature and the "
        "mean one of the particles, of the gas where there are none",
    ),
    Field(
        "duty_W",
        "Q",
        "W",
        "heat that the fluid takes up between inlet and outlet; per m2 or per m as "
        "heat_NAME_W",
    ),
    Field(
        "effectiveness",
        r"\epsilon",
        "1",
        "duty over the most that streams of these inlets could exchange",
    ),
    Field(
        "NTU",
        r"\mathrm{NTU}",
        "1",
        "transfer units of an exchanger without conduction along its streams that is "
        "as effective",
    ),
    Field(
        "pinch_K",
        r"\Delta T_\mathrm{min}",
        "K",
        "least difference of the temperatures of two streams along the bed",
    ),
    Field("pinch_m", "x", "m", "place of the pinch along the bed"),
    Field(
        "heat_reference_K",
        r"T_0",
        "K",
        "temperature at which the heat that streams carry is zero",
    ),
    Field(
        "u_max", r"u_\mathrm{max}", "m/s", "largest superficial velocity of the fluid"
    ),
    Field(
        "u_max_outlet",
        r"u_\mathrm{max}",
        "m/s",
        "largest superficial velocity of the fluid at the outlet",
    ),
    Field(
        "dT_section_max_K",
        r"\Delta T_r",
        "K",
        "largest difference of temperature between wall and axis",
    ),
    Field(
        "pressure_drop_Pa",
        r"\Delta p",
        "Pa",
        "pressure of the fluid at the inlet over that at the outlet",
    ),
    Field(
        "residence_time_s",
        "t",
        "s",
        "mean time that the fluid takes through a bed in plug flow",
    ),
    Field(
        "pressure_gradient_Pa_m",
        r"\mathrm{d}p/\mathrm{d}x",
        "Pa/m",
        "pressure gradient of the developed flow",
    ),
    Field("estimated_error", r"e", "1", "estimated error of theta"),
    Field(
        "estimated_error_velocity",
        r"e_u",
        "1",
        "estimated error of the velocity over that at the inlet",
    ),
    Field(
        "theta_equilibrium",
        r"\theta_\mathrm{eq}",
        "1",
        "scaled temperature at which both phases meet",
    ),
    Field(
        "equilibrium_length_m",
        r"L_\mathrm{eq}",
        "m",
        "distance after which both phases differ by 1 % of the span",
    ),
    Field("theta_overshoot", r"o", "1", "by how much theta leaves [0, 1]"),
    Field("time_steps", "n", "1", "number of time steps"),
    Field(
        "flow_solutions",
        "n",
        "1",
        "how often the flow was solved again, as the temperatures changed it",
    ),
    Field(
        "flow_change",
        r"\Delta u/u_0",
        "1",
        "largest mean change of the velocity from one flow to the next, over the inlet",
    ),
    Field("time_reached_s", "t", "s", "time that the run has reached"),
    # reacting beds
    Field(
        "conversion_NAME",
        "X",
        "1",
        "share of a species that enters and has reacted where its stream leaves",
    ),
    Field("x_NAME_out", "x", "1", "mole fraction in the gas that leaves"),
    Field(
        "out_NAME_mol_m2s", r"\dot n", "mol/m2/s", "gas that leaves per area of the bed"
    ),
    Field(
        "gas_out_mol_m2s",
        r"\dot n",
        "mol/m2/s",
        "all gas that leaves per area of the bed",
    ),
    Field(
        "mass_flux_out_kg_m2s",
        "G",
        "kg/m2/s",
        "mass of gas that leaves per area of the bed",
    ),
    Field(
        "solids_out_kg_m2s",
        "G_s",
        "kg/m2/s",
        "mass of solids that leave per area of the bed",
    ),
    Field(
        "T_solid_NAME_out_K",
        r"T_\mathrm{out}",
        "K",
        "temperature of a solid phase that leaves",
    ),
    Field(
        "solids_NAME_out_kg_m2s",
        "G_s",
        "kg/m2/s",
        "mass of a solid phase that leaves per area of the bed",
    ),
    Field("w_NAME_out", "w", "1", "mass fraction in the solids that leave"),
    Field(
        "u_in_m_s",
        "u",
        "m/s",
        "superficial velocity of the gas where it enters, at its own temperature",
    ),
    Field("u_out_m_s", "u", "m/s", "superficial velocity of the gas where it leaves"),
    Field("p_out_Pa", "p", "Pa", "pressure of the gas where it leaves"),
    Field(
        "extent_NAME_mol_m2s",
        r"\xi",
        "mol/m2/s",
        "moles of a reaction per area of the bed and time",
    ),
    Field(
        "Q_over_K_NAME",
        "Q/K",
        "1",
        "approach to equilibrium of a reaction in the gas that leaves",
    ),
    Field(
        "equilibrium_approach_NAME_K",
        r"\Delta T_\mathrm{eq}",
        "K",
        "temperature of a reaction where the gas leaves over that at which this gas "
        "would be in equilibrium",
    ),
    Field(
        "selectivity_NAME",
        "S",
        "1",
        "of CO_C: atoms of C in the CO that is made over those in the gases that are "
        "used up, where no solid takes or gives C",
    ),
    Field(
        "yield_NAME",
        "Y",
        "1",
        "of CO_C: atoms of C in the CO that is made over those fed in the gases that "
        "are used up, where no solid takes or gives C",
    ),
    Field(
        "space_time_yield_NAME_mol_m3s",
        r"\dot n_V",
        "mol/m3/s",
        "gas that is made, leaving less entering, per volume of the bed",
    ),
    Field(
        "GHSV_1_h",
        r"\mathrm{GHSV}",
        "1/h",
        "volume of gas fed per hour, at 273.15 K and 101325 Pa, over that of the bed",
    ),
    Field(
        "WHSV_1_h",
        r"\mathrm{WHSV}",
        "1/h",
        "mass of gas fed per hour over that of the particles in which gases react",
    ),
    Field(
        "hot_spot_K",
        r"T_\mathrm{max}",
        "K",
        "largest temperature of gas and particles in a bed with reactions",
    ),
    Field("hot_spot_m", "x", "m", "place of the hot spot along the bed"),
    Field(
        "breakthrough_NAME_s",
        "t_b",
        "s",
        "of 5_CO2: time at which the mole fraction of CO2 that leaves an adsorbing bed "
        "reaches 5 % of that which enters, before its streams change",
    ),
    Field(
        "mass_transfer_zone_NAME_m",
        r"L_\mathrm{MTZ}",
        "m",
        "length of the bed times the time from 5 to 95 % of breakthrough over that to "
        "50 %",
    ),
    Field(
        "capacity_used_NAME",
        r"\phi",
        "1",
        "what the bed has taken up of a gas at 5 % of breakthrough over that at 95 %",
    ),
    Field(
        "purity_NAME",
        "x",
        "1",
        "share of a gas in all that leaves in the part of a cycle of adsorption in which "
        "that share is largest; parts lie between changes of the streams",
    ),
    Field(
        "recovery_NAME",
        "R",
        "1",
        "moles of a gas that leave in the part of a cycle in which it is purest, over "
        "those that enter in the whole cycle",
    ),
    Field(
        "productivity_NAME_mol_kgs",
        r"\dot n_m",
        "mol/kg/s",
        "moles of a gas that leave in the part of a cycle in which it is purest, per "
        "mass of particles and time of the cycle",
    ),
    Field(
        "metallization",
        r"\eta_\mathrm{Fe}",
        "1",
        "share of the iron that leaves as metal",
    ),
    Field(
        "metallization_NAME", r"\eta_\mathrm{Fe}", "1", "metallization of a solid phase"
    ),
    Field(
        "reduction_NAME",
        "R",
        "1",
        "share of the oxygen of Fe2O3 that is removed from a solid phase",
    ),
    Field(
        "reduction",
        "R",
        "1",
        "share of the oxygen of Fe2O3 that is removed from the solids that leave",
    ),
    Field(
        "share_negative",
        "s",
        "1",
        "share of the points at which a fraction lies below -1e-6",
    ),
    Field(
        "cells_damped",
        "N",
        "1",
        "cells in which amounts that would fall below zero are damped",
    ),
    Field("steps_damped", "N", "1", "steps in time in which cells are damped"),
    Field(
        "steps_limited",
        "N",
        "1",
        "steps in time in which reactions take all that there is of a solid at rest",
    ),
    Field("cells", "N", "1", "number of cells"),
    Field(
        "cells_most",
        "N",
        "1",
        "largest number of cells of a run in time whose cells follow its errors",
    ),
    Field(
        "cells_changes", "n", "1", "how often a run in time went on with other cells"
    ),
    Field(
        "cells_error",
        "e",
        "1",
        "mean over time of the largest error of a cell, over the sizes of the fields",
    ),
    # radiation
    Field(
        "optical_thickness", r"\tau", "1", "extinction times the extent of the medium"
    ),
    Field("ordinates", "N", "1", "directions in each hemisphere that were needed"),
    Field(
        "estimated_error_angles",
        r"e_\Omega",
        "1",
        "estimated error of G and flux by the number of ordinates",
    ),
    Field("albedo", r"\omega", "1", "scattering over extinction"),
    Field(
        "flux_dimensionless",
        r"\Psi",
        "1",
        "heat flux over the difference of emissive powers of two walls",
    ),
    Field(
        "temperature_slip",
        r"1 - \Phi_0",
        "1",
        "difference of emissive powers of medium and first wall, scaled",
    ),
    Field(
        "flux_over_emissive_power",
        r"q/\sigma T^4",
        "1",
        "heat flux over the larger emissive power of two walls",
    ),
    # bubbling beds
    Field("T_distributor_K", r"T_\mathrm{d}", "K", "temperature of the distributor"),
    Field(
        "T_NAME_mid_K",
        r"T_\mathrm{NAME}",
        "K",
        "temperature of a solid phase at half of the height",
    ),
    Field(
        "T_NAME_top_K",
        r"T_\mathrm{NAME}",
        "K",
        "temperature of a gas at the top of the bed",
    ),
    Field(
        "NAME_convection_W",
        "Q",
        "W",
        "heat that leaves the particles to a surface by convection",
    ),
    Field(
        "NAME_radiation_W",
        "Q",
        "W",
        "heat that leaves the particles to a surface by radiation",
    ),
    Field("release_NAME_W", "Q", "W", "heat released in a phase"),
    Field("NAME_water_W", "Q", "W", "heat taken by the water in a surface"),
    Field(
        "NAME_water_out_K", "T", "K", "temperature of the water that leaves a surface"
    ),
    Field(
        "NAME_water_out_kJ_kg",
        "h",
        "kJ/kg",
        "enthalpy of the water that leaves a surface",
    ),
    Field(
        "NAME_water_out_quality",
        "x",
        "1",
        "steam quality of the water that leaves a surface",
    ),
    Field(
        "NAME_coefficient_W_m2K",
        "h",
        "W/m2/K",
        "mean heat transfer coefficient of a surface",
    ),
    Field(
        "height_at_minimum_fluidization_m",
        r"H_\mathrm{mf}",
        "m",
        "height of the bed without its bubbles",
    ),
    Field(
        "bed_height_m",
        "H",
        "m",
        "height of the bed that its particles settle at; of two fluids the height that "
        "they would fill at the mean solids fraction below their centre of mass",
    ),
    Field(
        "u_mf_m_s",
        r"u_\mathrm{mf}",
        "m/s",
        "superficial velocity at which the drag of the scene carries particles of the "
        "largest solids fraction of the start",
    ),
    Field(
        "u_over_u_mf",
        r"u/u_\mathrm{mf}",
        "1",
        "volume flow of gas fed over the section, over the minimum fluidization velocity",
    ),
    Field(
        "circulation_kg_m2s",
        "G_s",
        "kg/m2/s",
        "mean upward mass flux of particles over the section in the middle of the bed, "
        "of average velocities",
    ),
    Field("ejected_kg_m2s", r"F_0", "kg/m2/s", "particles thrown into the freeboard"),
    Field("carryover_kg_s", r"\dot m", "kg/s", "particles that the gas carries away"),
    Field(
        "NAME_diameter_m",
        "d",
        "m",
        "mean diameter of a solid phase that attrition and carryover leave",
    ),
    Field(
        "NAME_drain_kg_s",
        r"\dot m",
        "kg/s",
        "particles of a solid phase that are drained",
    ),
    Field(
        "NAME_carryover_kg_s",
        r"\dot m",
        "kg/s",
        "particles of a solid phase that the gas carries away",
    ),
    Field("steady_states_found", "n", "1", "number of steady states found"),
    Field(
        "fold_NAME",
        "p",
        "1",
        "value of the continuation's key at a fold, in the unit of the key",
    ),
    Field(
        "fold_distance",
        r"|p_1/p - 1|",
        "1",
        "distance to the first fold, or to the end, if none",
    ),
    Field("gas_out_mol_s", r"\dot n", "mol/s", "gas that leaves"),
    Field("x_NAME_wet", "x", "1", "mole fraction in the gas that leaves"),
    Field(
        "x_NAME_dry", "x", "1", "mole fraction in the gas that leaves, water left aside"
    ),
    Field("held_NAME_mol", "n", "mol", "amount of a solid in the bed"),
    Field("held_NAME_kg", "m", "kg", "mass of volatiles in the bed"),
    Field(
        "char_volume_fraction",
        r"\phi",
        "1",
        "share of char in the volume of the solids",
    ),
    Field("calcined", "X", "1", "share of the limestone that is calcined"),
    Field("lime_sulphated", "X", "1", "share of the lime that is sulphated"),
    Field("Ca_S", "Ca/S", "1", "calcium fed over sulphur fed"),
    Field(
        "carbon_conversion", "X", "1", "share of the fuel's carbon that leaves in gases"
    ),
    Field("fuel_power_W", "P", "W", "lower heating value of the fuel that is fed"),
    Field(
        "cold_gas_efficiency",
        r"\eta",
        "1",
        "heating value of the gas over that of the fuel",
    ),
    Field(
        "combustion_efficiency",
        r"\eta",
        "1",
        "heating value released over that of the fuel",
    ),
    Field(
        "loss_flue_gas",
        r"l_\mathrm{G}",
        "1",
        "heat above 298.15 K of the gas that leaves, less that of the gas that enters, "
        "and evaporation of the fuel's moisture, over the power of the fuel",
    ),
    Field(
        "loss_solids",
        r"l_\mathrm{s}",
        "1",
        "heat above 298.15 K of the solids that are drained over the power of the fuel",
    ),
    Field(
        "boiler_efficiency",
        r"\eta_\mathrm{B}",
        "1",
        "combustion efficiency less the losses by flue gas and solids",
    ),
    Field(
        "emission_NAME_mg_m3",
        r"\rho_\mathrm{NAME}",
        "mg/m3",
        "mass of a gas per volume of dry flue gas at 273.15 K, 101325 Pa and 6 % of O2",
    ),
    Field(
        "oxygen_ratio", r"\lambda", "1", "oxygen fed over that for complete combustion"
    ),
    Field(
        "sulphur_capture",
        r"\eta_\mathrm{S}",
        "1",
        "share of the sulphur that limestone captures",
    ),
    Field("ignited", "1", "1", "1 if more than half of what can burn burns"),
    # fully developed flow and two fluids
    Field(
        "u_gas_PLACE",
        r"u_\mathrm{g}",
        "m/s",
        "velocity of the gas at the centre or the wall",
    ),
    Field(
        "u_solid_PLACE",
        r"u_\mathrm{s}",
        "m/s",
        "velocity of the particles at the centre or the wall",
    ),
    Field(
        "theta_PLACE",
        r"\Theta",
        "m2/s2",
        "granular temperature at the centre, at the wall or at the end",
    ),
    Field(
        "eps_solid_PLACE",
        r"\varepsilon_\mathrm{s}",
        "1",
        "solids volume fraction at centre or wall, or its mean",
    ),
    Field("pressure_solid_Pa", r"p_\mathrm{s}", "Pa", "pressure of the particles"),
    Field("solutions_found", "n", "1", "number of solutions found for the same flows"),
    Field("time [s]", "t", "s", "time that the run has reached"),
    Field("steps", "n", "1", "number of time steps"),
    Field(
        "messages_per_step",
        "",
        "1",
        "messages that the busiest of several ranks sends in a step",
    ),
    Field(
        "message_bytes_per_step",
        "",
        "B",
        "bytes that the busiest of several ranks sends in a step",
    ),
    Field("reductions_per_step", "", "1", "sums and maxima over all ranks in a step"),
    Field(
        "mass_drift_relative",
        "e",
        "1",
        "relative residual of the mass of the particles",
    ),
    Field(
        "max_velocity",
        r"u_\mathrm{s,max}",
        "m/s",
        "largest velocity of the particles at the end",
    ),
    Field(
        "eps_s_max",
        r"\varepsilon_\mathrm{s,max}",
        "1",
        "largest solids volume fraction at the end",
    ),
    Field(
        "pressure_drop [Pa]",
        r"\Delta p",
        "Pa",
        "pressure below the bed over that above",
    ),
    Field(
        "pressure_drop_mean [Pa]",
        r"\Delta p",
        "Pa",
        "pressure drop, averaged over time",
    ),
    Field(
        "slip_velocity",
        "u",
        "m/s",
        "mean velocity of the gas past the particles in the middle of the vessel",
    ),
    Field(
        "T_PHASE_mean [K]",
        r"\overline{T}",
        "K",
        "mean temperature of a phase at the end",
    ),
    Field(
        "T_PHASE_max [K]",
        r"T_\mathrm{max}",
        "K",
        "largest temperature of a phase at the end",
    ),
    Field("p0 [Pa]", "p_0", "Pa", "pressure of a gas of variable density at the end"),
    Field(
        "weight_of_solids", "w", "Pa", "weight of the particles over the cross-section"
    ),
    Field(
        "weight_NAME",
        "w",
        "1",
        "share of the weight that is carried by pressure, particles, walls or inflow",
    ),
    Field(
        "filter_size [m]",
        r"\Delta_f",
        "m",
        "size of the filter of closures for cells that do not resolve clusters",
    ),
    Field(
        "filter_froude",
        "F",
        "1",
        "the same over the square of the terminal velocity over gravity",
    ),
    Field(
        "effective_restitution",
        r"e_\mathrm{eff}",
        "1",
        "restitution that the dissipation has, with friction",
    ),
    Field(
        "theta_over_s2d2",
        r"\Theta/(S d)^2",
        "1",
        "granular temperature of a sheared bed, scaled",
    ),
    Field("averaged [s]", "t", "s", "time over which averages are taken"),
    Field(
        "difference_of_halves",
        "e",
        "1",
        "difference of the averages of both halves of that time",
    ),
    Field(
        "dominant_frequency [Hz]",
        "f",
        "Hz",
        "frequency of the largest power of the pressure drop",
    ),
    Field("front_position_m", "x", "m", "upper front of a suspension that settles"),
    Field(
        "lower_front_position_m", "x", "m", "lower front of a suspension that settles"
    ),
    Field(
        "eps_star",
        r"\varepsilon^*",
        "1",
        "solids volume fraction between shock and fan",
    ),
    Field("shock_speed", "s", "1", "speed of the shock over that of sound"),
    Field("NAME_cells", "n", "1", "how often a guard or a limit acted in a cell"),
    Field("limited_faces", "n", "1", "how often a flux was limited"),
    Field("limited_steps", "n", "1", "steps in which a flux was limited"),
    Field("NAME_rounds", "n", "1", "rounds of a limiter or of the packing"),
    Field(
        "first_order_steps",
        "n",
        "1",
        "steps of second order that fell back to the first",
    ),
    # particles
    Field("porosity", r"\varepsilon", "1", "porosity of a packing"),
    Field("coordination", "z", "1", "mean number of touching neighbours of a particle"),
    Field(
        "k_eff [W/m/K]", r"k_\mathrm{eff}", "W/m/K", "effective thermal conductivity"
    ),
    Field(
        "k_NAME [W/m/K]",
        "k",
        "W/m/K",
        "component of the effective conductivity, or that between two layers",
    ),
    Field(
        "k_eff_over_k_fluid",
        r"k_\mathrm{eff}/k_\mathrm{f}",
        "1",
        "effective conductivity over that of the fluid",
    ),
    Field(
        "k_eff_over_contact_scale",
        "k",
        "1",
        "effective conductivity over k_s r_c/r of the lattice",
    ),
    Field("share_NAME", "s", "1", "share of a mechanism in the heat"),
    Field("heat [W]", "Q", "W", "heat from the hot to the cold layer"),
    Field("isolated", "n", "1", "particles without a path to both layers"),
    Field(
        "closure_residual", "e", "1", "largest relative residual of a fitted closure"
    ),
    Field(
        "mass_fraction_end",
        "m",
        "1",
        "mass that is left at the end over that of the fresh particle",
    ),
    Field(
        "T_centre_max_K",
        r"T_\mathrm{centre,max}",
        "K",
        "largest temperature in the centre of the particle",
    ),
    Field(
        "time_of_T_centre_max_s",
        "t",
        "s",
        "time at which the centre of the particle is hottest",
    ),
    Field(
        "half_time_s",
        "t_{1/2}",
        "s",
        "time at which half of the loss of mass is reached",
    ),
    Field(
        "cycle_periods",
        "n",
        "1",
        "periods computed until the cyclic steady state was found",
    ),
    Field(
        "cycle_change",
        r"\Delta y",
        "1",
        "largest change over the period of a cycle of what a reacting bed stores",
    ),
    Field(
        "cycle_change_K",
        r"\Delta T",
        "K",
        "largest change of a temperature over the period of a cycle",
    ),
    Field(
        "heat_charged_J",
        "Q_+",
        "J",
        "heat that streams leave in the bed over the parts of a run in which they do",
    ),
    Field(
        "heat_discharged_J",
        "Q_-",
        "J",
        "heat that streams take out of the bed over the parts of a run in which they "
        "do",
    ),
    Field(
        "storage_efficiency",
        r"\eta",
        "1",
        "heat discharged over heat charged",
    ),
    Field(
        "effectiveness_charge",
        r"\varepsilon_+",
        "1",
        "heat left over what the stream could leave in the bed",
    ),
    Field(
        "effectiveness_discharge",
        r"\varepsilon_-",
        "1",
        "heat taken over what the stream could take out",
    ),
    Field(
        "heat_lost_J",
        r"Q_\mathrm{lost}",
        "J",
        "heat that leaves a store other than with the fluid: through walls, by radiation "
        "and by conduction at its ends",
    ),
    Field(
        "heat_lost_at_rest_J",
        r"Q_\mathrm{rest}",
        "J",
        "part of the heat lost while no fluid flows",
    ),
    Field(
        "heat_stored_J",
        r"\Delta Q",
        "J",
        "heat that a store holds more than at the start",
    ),
    Field(
        "storage_capacity_J",
        "Q_C",
        "J",
        "heat of a store between the lowest and highest temperature of the streams, "
        "without a cycle also of its start",
    ),
    Field(
        "utilisation",
        r"\phi",
        "1",
        "largest change of the heat that a store holds from one change of its streams "
        "to another, over its capacity",
    ),
    Field(
        "exergy_charged_J",
        "E_+",
        "J",
        "exergy that streams leave in the bed over the parts of a run in which they do, "
        "from packed_bed.dead_state and without that of pressure",
    ),
    Field(
        "exergy_discharged_J",
        "E_-",
        "J",
        "exergy that streams take out of the bed over the parts of a run in which they "
        "do",
    ),
    Field(
        "exergy_efficiency",
        r"\eta_E",
        "1",
        "exergy discharged over exergy charged",
    ),
    Field(
        "thermocline_m",
        r"\delta",
        "m",
        "length over which the solid of a store goes from 10 to 90 % of the span of "
        "temperatures, at the end",
    ),
    Field(
        "T_solid_mean_K",
        r"\overline{T}_\mathrm{s}",
        "K",
        "mean temperature of the particles at the end",
    ),
    Field(
        "T_fluid_max_K",
        r"T_\mathrm{max}",
        "K",
        "largest temperature of the gas at the end",
    ),
    Field(
        "radiation_not_balanced [J]",
        "Q",
        "J",
        "radiation between particles that pairs do not exchange exactly",
    ),
    Field(
        "bed_weight [Pa]", "w", "Pa", "weight of the particles over the cross-section"
    ),
    Field(
        "above_grid",
        "n",
        "1",
        "particles that left the grid of the gas through its top",
    ),
    Field(
        "porosities_raised",
        "n",
        "1",
        "how often the porosity of a cell was raised to its least value",
    ),
    Field(
        "h_NAME [W/m2/K]",
        "h",
        "W/m2/K",
        "heat transfer coefficient of a mechanism, mean of the particles",
    ),
    Field(
        "h_tube_NAME [W/m2/K]",
        "h",
        "W/m2/K",
        "heat transfer coefficient of a tube, or its part by a mechanism",
    ),
    Field(
        "heat_tube_NAME [W]",
        "Q",
        "W",
        "heat from a tube to gas and particles, mean of the averages",
    ),
    Field(
        "h_NAME_percentiles [W/m2/K]",
        "h",
        "W/m2/K",
        "5, 50 and 95 percent of the particles' coefficients",
    ),
    Field("samples", "n", "1", "number of samples that were averaged"),
    Field("height [m]", "H", "m", "mean height of the surface of the bed"),
)

FIELDS = {field.name: field for field in _FIELDS}
RESULTS = {field.name: field for field in _RESULTS}


def field(name: str) -> Field | None:
    """Find the field of a column by its name without unit; None if there is none.

    "T_sand" is found by "T_NAME", "wall p" of a probe by "p".
    """
    return _find(name.rpartition(" ")[2], "fields")


def result(key: str) -> Field | None:
    """Find the entry of a named result by its key, "heat_left_W" by "heat_NAME_W";
    None if there is none.
    """
    return _find(key, "results")


def header(name: str) -> str:
    """Return the column header of a field: `header("T_fluid")` is "T_fluid [K]"."""
    return FIELDS[name].header


def name_of(header: str) -> str:
    """Return the name in a column header; the inverse of `header`."""
    return header.split(" [")[0]


def unit_of(name: str) -> str | None:
    """Return the unit of a field or a named result ("u_gas_centre" is in m/s); None
    if the name is not known.
    """
    found = result(name) or field(name_of(name))
    return found.unit if found else None


@cache
def _find(name: str, table: str) -> Field | None:
    known = {"fields": FIELDS, "results": RESULTS}[table]
    if name in known:
        return known[name]
    return next(
        (entry for pattern, entry in _patterns(table) if pattern.fullmatch(name)), None
    )


@cache
def _patterns(table: str) -> list[tuple[re.Pattern[str], Field]]:
    """Return names with a part in capitals as patterns, the longest (most specific)
    first.
    """
    entries: Iterable[Field] = {"fields": FIELDS, "results": RESULTS}[table].values()
    chosen = [entry for entry in entries if re.search("NAME|PHASE|PLACE", entry.name)]
    chosen.sort(key=lambda entry: -len(entry.name))
    parts = ((re.split("NAME|PHASE|PLACE", entry.name), entry) for entry in chosen)
    return [
        (re.compile(".+".join(map(re.escape, part))), entry) for part, entry in parts
    ]

"""Former names of tables and keys of a reacting bed, see `scene.renames`."""

from __future__ import annotations

from collections.abc import Mapping

FLOW = "give boundary.NAME.gas.{} where the gas enters, positive into the bed"
VELOCITY = (
    "give boundary.NAME.solids.NAME.velocity where the solids enter, positive "
    "into the bed"
)

RENAMED: Mapping[str, str] = {
    "fluid": "gas",
    "solid": "solids.NAME",
    "solids.NAME.particle_diameter": "solids.NAME.diameter",
    "solids.NAME.velocity_solid": VELOCITY,
    "solids.NAME.diffusivity": "solids.NAME.inside.diffusivity",
    "bed.porosity": "packed_bed.porosity",
    "bed.particle_diameter": "solids.NAME.diameter",
    "bed.shape": "solids.NAME.shape",
    "bed.permeability": "closures.permeability",
    "bed.forchheimer": "closures.forchheimer",
    "flow.velocity": FLOW.format("velocity"),
    "flow.mass_flux": FLOW.format("mass_flux"),
    "flow.molar_flux": FLOW.format("molar_flux"),
    "flow.velocity_solid": VELOCITY,
    "flow.pressure_drop": "packed_bed.pressure_drop",
    "heat.nusselt": "closures.nusselt",
    "heat.conductivity_fluid": "closures.conductivity_gas",
    "heat.conductivity_solid": "closures.conductivity_solids",
    "heat.dispersion": "closures.dispersion",
    "mass.sherwood": "closures.sherwood",
    "mass.dispersion": "closures.dispersion_mass",
    "mass": "remove it: without closures.sherwood and closures.dispersion_mass there "
    "is no film and no dispersion",
    "wall.diameter": "mesh.diameter",
    "wall.coefficient": "boundary.wall.coefficient",
    "wall.ambient": "boundary.wall.ambient",
    "wall.flux": "boundary.wall.heat_flux",
    "section.conductivity_fluid": "packed_bed.section.conductivity_gas",
    "section.conductivity_solid": "packed_bed.section.conductivity_solids",
    "section.mass_dispersion": "packed_bed.section.dispersion_mass",
    "section": "packed_bed.section",
    "particle": "solids.NAME.inside",
    "adsorption": "solids.NAME.adsorption",
    "boundary.NAME.fluid.inflow": "boundary.NAME.gas.temperature",
    "boundary.NAME.fluid.fixed": "boundary.NAME.gas.fixed_temperature",
    "boundary.NAME.solid.inflow": "boundary.NAME.solids.NAME.temperature",
    "boundary.NAME.solid.fixed": "boundary.NAME.solids.NAME.temperature",
    "guess.temperature": "initial.temperature",
    "time.initial_temperature": "initial.temperature",
    "time.initial_composition": "initial.gas.composition",
    "time.initial.file": "initial.file",
    "time.initial.time": "initial.time",
    "time.gas": "packed_bed.gas_storage",
}

"""Former names of tables and keys of a packed bed, see `scene.renames`."""

from __future__ import annotations

from collections.abc import Mapping

_OF_A_PHASE = {
    "fixed": "fixed_temperature",
    "inflow": "temperature",
    "flux": "heat_flux",
    "coefficient": "coefficient",
    "emissivity": "emissivity",
    "ambient": "ambient",
}

RENAMED: Mapping[str, str] = {
    "fluid": "gas",
    "fluid.temperature": "gas.material_temperature",
    "solid": "solids.NAME",
    "solid.temperature": "solids.NAME.material_temperature",
    "bed.porosity": "packed_bed.porosity",
    "bed.particle_diameter": "solids.NAME.diameter",
    "bed.shape": "solids.NAME.shape",
    "bed.permeability": "closures.permeability",
    "bed.forchheimer": "closures.forchheimer",
    "flow.velocity": "give boundary.NAME.gas.velocity where the gas enters, positive "
    "into the bed",
    "flow.velocity_solid": "give boundary.NAME.solids.NAME.velocity where the solids "
    "enter, positive into the bed",
    "heat.nusselt": "closures.nusselt",
    "heat.reynolds": "packed_bed.reynolds",
    "heat.conductivity_fluid": "closures.conductivity_gas",
    "heat.conductivity_solid": "closures.conductivity_solids",
    "heat.tortuosity": "closures.tortuosity",
    "heat.dispersion": "closures.dispersion",
    "particle": "solids.NAME.inside",
    "radiation.emissivity": "solids.NAME.emissivity",
    "radiation.species.NAME.volume_fraction": "give solids.NAME.volume_share instead, "
    "the share of the volume "
    "of all particles",
    "radiation.species.NAME": "solids.NAME",
    "boundary.NAME.flow": "boundary.NAME.type",
    **{
        f"boundary.NAME.fluid.{old}": f"boundary.NAME.gas.{new}"
        for old, new in _OF_A_PHASE.items()
    },
    **{
        f"boundary.NAME.solid.{old}": f"boundary.NAME.solids.NAME.{new}"
        for old, new in _OF_A_PHASE.items()
    },
    "region.NAME.source_fluid": "region.NAME.gas.heat_source",
    "region.NAME.source_solid": "region.NAME.solids.heat_source",
    "time.initial_fluid": "initial.gas.temperature",
    "time.initial_solid": "initial.solids.NAME.temperature",
}

"""Former names of keys of scenes of two fluids."""

CLOSURES = {
    "drag": "drag",
    "radial_distribution": "radial_distribution",
    "pressure": "granular_pressure",
    "viscosity": "granular_viscosity",
    "conductivity": "granular_conductivity",
    "dissipation": "granular_dissipation",
}
"""Keys of [closures] by those that they had in the table of their model."""

SOLID = {
    "solid.particle_diameter": "solids.NAME.diameter",
    "solid.diameter": "solids.NAME.diameter",
    "solid.packing": "solids.NAME.packing_limit",
    "solid": "solids.NAME",
}

_FIELDS = {
    "eps_s": "solids.NAME.volume_fraction",
    "theta": "solids.NAME.granular_temperature",
    "u_gas": "gas.velocity",
    "u_solid": "solids.NAME.velocity",
    "T_gas": "gas.temperature",
    "T_solid": "solids.NAME.temperature",
}
_AT_BOUNDARIES = {
    "eps_s": "solids.NAME.volume_fraction",
    "theta": "solids.NAME.granular_temperature",
    "solid_flux": "solids.NAME.mass_flux",
    "solid_velocity": "solids.NAME.velocity",
    "T_gas": "gas.temperature",
    "T_solid": "solids.NAME.temperature",
    "T": "temperature",
    "pressure": "gas.pressure",
    "gas": "gas.wall",
    "solid": "solids.NAME.wall",
    "specularity": "solids.NAME.specularity",
    "restitution": "solids.NAME.restitution",
    "friction": "solids.NAME.friction",
}
_CLOSURES = CLOSURES | {
    "bulk_viscosity": "granular_bulk_viscosity",
    "effective_restitution": "effective_restitution",
    "friction": "friction_pressure",
    "friction_viscosity": "friction_viscosity",
    "wall_drag": "wall_drag",
    "wall_pressure": "wall_pressure",
    "wall_viscosity": "wall_viscosity",
}

RENAMED = {
    **{f"two_fluid.{old}": f"closures.{new}" for old, new in _CLOSURES.items()},
    **SOLID,
    **{f"initial.{old}": f"initial.{new}" for old, new in _FIELDS.items()},
    **{f"initial.layer.{old}": f"initial.layer.{new}" for old, new in _FIELDS.items()},
    **{
        f"boundary.NAME.{old}": f"boundary.NAME.{new}"
        for old, new in _AT_BOUNDARIES.items()
    },
    "boundary.NAME:inlet.velocity": "boundary.NAME.gas.velocity",
    "heat.heat_capacity_gas": "gas.heat_capacity",
    "heat.heat_capacity_solid": "solids.NAME.heat_capacity",
    "heat.conductivity_gas": "gas.conductivity",
    "heat.conductivity_solid": "solids.NAME.conductivity",
    "heat.nusselt": "closures.nusselt",
    "heat.conductivity_bed": "closures.conductivity_bed",
    "heat.effective_gas": "two_fluid.conductivity_gas",
    "heat.effective_solid": "two_fluid.conductivity_solids",
    "heat.density": "gas.density_law",
    "heat.T_reference": "gas.reference_temperature",
    "heat.pressure": "gas.pressure",
}
"""Present names by former ones, see `contbed.scene.renames`."""

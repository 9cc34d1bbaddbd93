"""Former names of keys of particles without and with a gas, see
`contbed.scene.renames`.
"""

_RADIUS = "solids.NAME.diameter takes the place of a radius, with twice the value"
_OF_THE_SOLID = {
    "density": "density",
    "heat_capacity": "heat_capacity",
    "conductivity": "conductivity",
    "emissivity": "emissivity",
    "material": "material",
    "material_temperature": "material_temperature",
    "modulus_real": "youngs_modulus",
    "poisson_ratio": "poisson_ratio",
    "restitution": "restitution",
    "sliding_friction": "sliding_friction",
    "rolling_friction": "rolling_friction",
}


def of_the_solid(table: str) -> dict[str, str]:
    """Return the present names of what a table said of the material of particles."""
    present = {
        f"{table}.{old}": f"solids.NAME.{new}" for old, new in _OF_THE_SOLID.items()
    }
    return {f"{table}.radius": _RADIUS} | present


RENAMED = {
    "lattice": "particles.lattice",
    "lattice.radius": _RADIUS,
    "packing": "particles.packing",
    "packing.modulus": "particles.modulus",
    "packing.spread": "solids.NAME.size_spread",
    **of_the_solid("packing"),
    **of_the_solid("particles"),
    "conduction.particles": "solids.NAME.conductivity",
    "conduction.fluid": "gas.conductivity",
    "conduction.paths": "particles.paths",
    "conduction.porosity": "particles.porosity",
    "conduction.correction.simulated": "particles.modulus",
    "conduction.correction.real": "solids.NAME.youngs_modulus",
    "conduction.correction.exponent": "particles.exponents",
    "surface.roughness": "solids.NAME.roughness",
    "surface.slope": "solids.NAME.asperity_slope",
    "surface.microhardness": "solids.NAME.microhardness",
    "surface.youngs_modulus": "solids.NAME.youngs_modulus",
    "surface.poisson_ratio": "solids.NAME.poisson_ratio",
    "surface.mean_free_path": "gas.mean_free_path",
    "surface.accommodation": "gas.accommodation",
    "surface.heat_capacity_ratio": "gas.heat_capacity_ratio",
    "surface.prandtl": "gas.prandtl",
    "layers": "particles.layers",
    "closure": "particles.closure",
    "radiation.emissivity": "solids.NAME.emissivity",
}

"""Former names of the tables and keys of a bubbling bed, see
`contbed.scene.renames`.
"""

RENAMED = {
    "gas.mass_flow": "boundary.bottom.gas.mass_flow",
    "gas.capacity_flow": "boundary.bottom.gas.capacity_flow",
    "gas.temperature": "boundary.bottom.gas.temperature",
    "gas.release": "bubbling_bed.release",
    "bubbling_bed.minimum_fluidization": "closures.minimum_fluidization",
    "bubbling_bed.expansion": "closures.expansion",
    "bubbles": "bubbling_bed.bubbles",
    "tubes": "bubbling_bed.tubes",
    "walls": "bubbling_bed.walls",
    "distributor": "bubbling_bed.distributor",
    "freeboard": "bubbling_bed.freeboard",
    "drain": "bubbling_bed.drain",
    "species": "solids",
    "species.NAME.volume_fraction": "solids.NAME.volume_share",
    "species.NAME.conductivity": "solids.NAME.mixing_conductivity",
    "species.NAME.thermal_conductivity": "solids.NAME.conductivity",
    "solids.NAME.volume_fraction": "solids.NAME.volume_share",
    "solids.NAME.thermal_conductivity": "solids.NAME.conductivity",
    "fuel": "this table is [solids.NAME.fuel] now, of the solid phase that it names "
    "as its species; its feed is solids.NAME.feed",
    "limestone": "this table is [solids.NAME.limestone] now, of the solid phase that "
    "it names as its species; its feed is solids.NAME.feed",
    "reactions.mixing_time": "bubbling_bed.mixing_time",
    "solver.guess": "initial.temperature",
}

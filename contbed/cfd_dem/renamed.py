"""Former names of keys of particles in a gas, see `contbed.scene.renames`."""

from contbed.dem.renamed import of_the_solid

RENAMED = {
    "fluid": "gas",
    "fluid.temperature": "gas.material_temperature",
    "gas.velocity": "boundary.bottom.gas.velocity",
    "gas.T": "boundary.bottom.gas.temperature",
    "gas.height": "particles.height",
    "gas.cell": "particles.cell",
    "gas.gravity": "particles.gravity",
    "gas.drag": "closures.drag",
    "gas.nusselt": "closures.nusselt",
    "gas.step": "time.step",
    "gas.no_slip": 'boundary.sides.gas.wall takes its place, as "slip" or "no_slip"',
    "gas.jet": "boundary.jet",
    "gas.jet.slot": "boundary.jet.start and boundary.jet.end take its place",
    "gas.jet.end": "boundary.jet.until",
    "gas.jet.mass_flux": "boundary.jet.gas.mass_flux",
    "gas.jet.T": "boundary.jet.gas.temperature",
    **of_the_solid("particles"),
    "tubes": "particles.tubes",
    "tubes.NAME.T": "particles.tubes.NAME.temperature",
    "heat.T": "initial.solids.NAME.temperature",
    "closure": "particles.closure",
}

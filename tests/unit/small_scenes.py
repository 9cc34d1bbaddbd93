"""The smallest scene that heats a bed, for tests of what surrounds a run."""

STEADY = """\
[mesh]
type = "line"
length = 1.0
cells = 10
[fluid]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.05
viscosity = 2e-5
[solid]
density = 2000.0
heat_capacity = 900.0
conductivity = 1.0
[bed]
porosity = 0.4
particle_diameter = 0.01
[flow]
velocity = 0.3
[heat]
nusselt = "wakao_kaguei"
[boundary.left]
fluid.inflow = 300.0
"""

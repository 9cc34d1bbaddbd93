"""The smallest scene that heats a bed, for tests of what surrounds a run."""

STEADY = """\
[mesh]
type = "line"
length = 1.0
cells = 10

[gas]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.05
viscosity = 2e-5

[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 1.0
diameter = 0.01

[packed_bed]
porosity = 0.4

[closures]
nusselt = "wakao_kaguei"

[heat]

[boundary.left]
gas.velocity = 0.3
gas.temperature = 300.0
"""

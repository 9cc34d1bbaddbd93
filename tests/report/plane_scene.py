"""A small plane bed in time, for reports and films."""

PLANE = """\
title = "Hot gas into a cold plane bed"
mesh = { type = "rectangle", length = 0.3, height = 0.1, cells = [12, 4] }
output = { plots = false }

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
gas.temperature = 600.0

[boundary.top]
solids.particles.fixed_temperature = 300.0

[initial]
gas.temperature = 300
solids.particles.temperature = 300

[time]
end = 1000
times = [200, 500]
"""

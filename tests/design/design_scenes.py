"""Scenes for tests of gradients: a moving bed between two streams, on few cells."""

SLIP = """\
[mesh]
type = "line"
length = 0.3
cells = 60
[fluid]
density = 0.4345
heat_capacity = 1986.8
conductivity = 0.0345
viscosity = 1.731e-5
[solid]
density = 2000.0
heat_capacity = 800.0
conductivity = 0.8625
[bed]
porosity = 0.6
particle_diameter = 0.01
permeability = 1e-7
forchheimer = 0.1
[flow]
velocity = 0.2
velocity_solid = 1e-4
[heat]
nusselt = 12.0
[boundary.left]
fluid.fixed = 300.0
solid.fixed = 400.0
[solver]
stabilisation = false
degree = 3
"""

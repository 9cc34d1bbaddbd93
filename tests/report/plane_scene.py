"""A small plane bed in time, for reports and films."""

PLANE = """\
title = "Hot gas into a cold plane bed"
mesh = { type = "rectangle", length = 0.3, height = 0.1, cells = [12, 4] }
fluid = { density = 1.0, heat_capacity = 1000.0, conductivity = 0.05, viscosity = 2e-5 }
solid = { density = 2000.0, heat_capacity = 900.0, conductivity = 1.0 }
bed = { porosity = 0.4, particle_diameter = 0.01 }
flow = { velocity = 0.3 }
heat = { nusselt = "wakao_kaguei" }
time = { end = 1000, times = [200, 500], initial_fluid = 300, initial_solid = 300 }
output = { plots = false }
[boundary.left]
fluid.inflow = 600.0
[boundary.top]
solid.fixed = 300.0
"""

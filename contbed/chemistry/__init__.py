"""Chemistry as functions of a point, for every model: species and their thermodynamics,
equations, rate laws, equilibrium.
"""

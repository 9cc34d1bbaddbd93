"""Weak forms of the packed bed: two energies, porous flow; fronts along
characteristics.
"""

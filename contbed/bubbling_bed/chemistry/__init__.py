"""Reactions of a bubbling bed: fuel, char, limestone and gas with Cantera's
thermodynamics.
"""

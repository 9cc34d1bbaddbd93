"""Packed and moving beds with species: gases and solids that react, two
temperatures, pressure along the bed.
"""

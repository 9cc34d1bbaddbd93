"""Transient two-fluid model of gas and particles with the kinetic theory of granular
flow.
"""

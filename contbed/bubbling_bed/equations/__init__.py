"""Equations of a bubbling bed: heat of particles and gases, composition, freeboard,
steam in tubes.
"""

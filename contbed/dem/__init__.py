"""Embedded discrete elements: spheres in motion, packings and heat between
particles, for closures.
"""

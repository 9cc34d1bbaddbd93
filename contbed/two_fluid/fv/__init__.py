"""Finite volumes on any mesh: cells and faces, gradients, reconstruction, flux
limiter.
"""

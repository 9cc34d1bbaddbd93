"""Radiation of a packed bed or of a stand-alone medium: P1, two-flux, discrete
ordinates, Rosseland.
"""

"""Equations of radiative transfer: P1 and two-flux as a weak form, discrete
ordinates on a line.
"""

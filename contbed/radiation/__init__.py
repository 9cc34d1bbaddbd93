"""Radiation of a packed bed or of a medium by itself: P1, two-flux, discrete ordinates, Rosseland."""

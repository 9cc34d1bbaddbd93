"""Plots of a packed bed: profiles along it, at output times of a transient, and fields of a plane bed."""

from contbed.output.plots import plot_profiles_and_fields as plot

__all__ = ["plot"]

"""Plots of a radiating medium: profiles along it, and fields of a plane one."""

from contbed.output.maps import plot_profiles_and_fields as plot

__all__ = ["plot"]

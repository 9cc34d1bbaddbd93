"""Picture of a scene of particles: temperature over height."""

from __future__ import annotations

from contbed.output.maps import plot_profiles_and_fields as plot

__all__ = ["plot"]

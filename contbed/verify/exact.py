"""Exact and high-precision reference solutions, under one name."""

from contbed.packed_bed.equations.modes import rates
from contbed.verify.exact_flow import ChannelFlow, brinkman_forchheimer_channel, plug_pressure_gradient
from contbed.verify.exact_packed_bed import fin, schumann, two_temperature_relaxation
from contbed.verify.exact_two_energy import (
    decay_rate,
    finite_length,
    nakayama_coefficients,
    nakayama_peclet,
    semi_infinite,
    tortuosity_parameter,
)

__all__ = [
    "ChannelFlow",
    "brinkman_forchheimer_channel",
    "decay_rate",
    "fin",
    "finite_length",
    "nakayama_coefficients",
    "nakayama_peclet",
    "plug_pressure_gradient",
    "rates",
    "schumann",
    "semi_infinite",
    "tortuosity_parameter",
    "two_temperature_relaxation",
]

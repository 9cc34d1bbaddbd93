"""Exact and high-precision reference solutions, under one name."""

from studies._exact.finite_length import finite_length
from studies._exact.flow import (
    ChannelFlow,
    brinkman_forchheimer_channel,
)
from studies._exact.modes import rates
from studies._exact.packed_bed import fin, schumann, two_temperature_relaxation
from studies._exact.two_energy import (
    decay_rate,
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
    "rates",
    "schumann",
    "semi_infinite",
    "tortuosity_parameter",
    "two_temperature_relaxation",
]

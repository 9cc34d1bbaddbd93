"""Why an interval of the discrete elements cannot be used, as an error message."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.dem import loop
from contbed.dem.kernel_arrays import Array

STRIDE = 0.1  # of the smallest radius: nothing may move farther in one step


class Failure(NamedTuple):
    """Status of `loop` and what it means for the user."""

    status: int
    text: str


def place(point: Array) -> str:
    """Write a point [m]."""
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ") m"


def of_particle(
    status: int, particle: int, where: Array, velocity: Array, time: float
) -> Failure:
    """Say what happened to a particle at `time` [s]."""
    speed = float(np.linalg.norm(velocity))
    what = {
        loop.TOO_FAST: f"moves at {speed:.4g} m/s, more than {STRIDE:g} of the "
        "smallest radius in a step",
        loop.LOST: "left the domain",
        loop.BEYOND_WALL: "was pushed through a wall",
    }[status]
    text = (
        f"dem: particle {particle} at {place(where)} {what} at t = {time:.6g} s; "
        "the state before this interval is kept; try a smaller time step or a closed "
        "domain"
    )
    return Failure(status, text)


def not_a_number(particle: int) -> Failure:
    """Say that the temperature of a particle is not a number."""
    text = (
        f"dem: temperature of particle {particle} is not a number; a heat source, or a "
        "heat "
        "capacity too small for the time step"
    )
    return Failure(loop.OK, text)

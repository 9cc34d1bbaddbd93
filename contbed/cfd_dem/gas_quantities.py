"""What passes between particles and gas, and between the phases of a step of the
gas.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array


@dataclass
class Motion:
    """The particles as the gas sees them: positions, velocities (n, 3), radii,
    temperatures [K] or None (n,).
    """

    x: Array
    v: Array
    radius: Array
    T: Array | None = None

    @property
    def volume(self) -> Array:
        """Of each particle [m3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3


@dataclass
class Local:
    """The gas around each particle (n,): porosity, superficial Reynolds number of the
    slip, Pr, mu, k, T [SI].

    `inside` is the part of each particle that is in the gas, less than 1 where it
    reaches above the grid.
    """

    eps: Array
    Re: Array
    Pr: Array
    mu: Array
    k: Array
    T: Array
    inside: Array


class Places(NamedTuple):
    """Where the particles are: cells (n, k) and shares in them, faces (n, 3, 8) and
    weights on them, porosities.

    `volume` (n,) [m3] is what of each particle is below the top of the grid, `inside`
    the part of its own that this is. `eps` (c,) of the cells, `eps_at` (n,) at the
    particles, `eps_face` (f,) on faces; `solid` (f,) [m3] is the volume of particles
    that belongs to a face.
    """

    where: NDArray[np.int32]
    share: Array
    inside: Array
    volume: Array
    faces: NDArray[np.int32]
    weight: Array
    eps: Array
    eps_at: Array
    solid: Array
    eps_face: Array


class Drag(NamedTuple):
    """Drag of the superficial slip q - eps v, implicit in q.

    `coefficient` [kg/s] (n,) and eps v [m/s], `carried` (n, 3), of each particle; sums
    on faces (f,) of the coefficients, `resisted` [kg/s], and of their products with eps
    v, `pushed` [N].
    """

    coefficient: Array
    carried: Array
    resisted: Array
    pushed: Array


class Prediction(NamedTuple):
    """Velocity without the pressure gradient (f,) [m/s], and what a gradient is
    divided by to correct it [kg/m3/s].
    """

    u: Array
    resistance: Array

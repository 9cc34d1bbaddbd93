"""What the closures give a step: drag, and pressure, viscosities, conductivity and
dissipation of the particles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Rheology(NamedTuple):
    """Fields (nc,) that the particles' stress and granular temperature need.

    g0 : radial distribution
    pressure : kinetic and collisional pressure over rho_s theta
    stiffness [m2/s2] : d p_solid/d eps_s/rho_s with friction
    mu, bulk [Pa s] : kinetic and collisional viscosities
    p_friction [Pa] : frictional pressure
    potential [m2/s2] : integral of d p_friction/(rho_s eps_s)
    conductivity [kg/m/s] : of granular energy
    dissipation [kg/m3] : gamma/theta^(3/2), so that gamma is in W/m3
    """

    g0: np.ndarray
    pressure: np.ndarray
    stiffness: np.ndarray
    mu: np.ndarray
    bulk: np.ndarray
    p_friction: np.ndarray
    potential: np.ndarray
    conductivity: np.ndarray
    dissipation: np.ndarray


@dataclass(frozen=True)
class Closures:
    """Functions of all cells.

    drag(eps_s, slip speed) gives K = beta/eps_s [kg/m3/s]; granular(eps_s, theta, K)
    the rest; friction(p_friction, shear rate) the frictional viscosity [Pa s], for
    which shear rates are found only where it is `sheared`. `packing` is a table of
    p_friction/rho_s [m2/s2]: eps_s of its start, spacing, values. `wall_froude` (nc,)
    is the distance from walls at which factors near them are taken, None without such
    factors.
    """

    drag: Callable[[np.ndarray, np.ndarray], np.ndarray]
    granular: Callable[[np.ndarray, np.ndarray, np.ndarray], Rheology]
    friction: Callable[[np.ndarray, np.ndarray], np.ndarray]
    sheared: bool = False
    packing: tuple[float, float, np.ndarray] = (1.0, 1.0, np.zeros(2))
    wall_froude: np.ndarray | None = None

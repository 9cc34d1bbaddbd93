"""Beds at rest of spheres so soft that their own weight packs them denser, estimated
without a settled packing.

A random packing that bears an isotropic pressure p has the mean force F in its
contacts, which overlap by delta:

    F = 4 pi R^2 p/(phi Z),   delta = (9 F^2/(8 R E*^2))^(1/3)

with the solids volume fraction phi and Z contacts of a sphere; exact for a simple cubic
lattice, phi = pi/6 and Z = 6.

Source: Walton (1987), J. Mech. Phys. Solids 35, 213-226,
    doi:10.1016/0022-5096(87)90036-6.
"""

from __future__ import annotations

import numpy as np

from contbed.dem.particles import Material
from contbed.dem.scene import SOLID_SHARE

GRAVITY = 9.81  # m/s2
TOUCHING = 6.0  # contacts of a sphere in a loose random bed with friction
# share by which the weight of a bed may pack it denser: a tenth more resistance to gas
# at 0.4 of voids
DENSER = 0.02


def overlap_by_pressure(
    pressure: float,
    radius: float,
    material: Material,
) -> float:
    """Find the overlap [m] of equal spheres of `radius` [m] whose packing bears a
    `pressure` [Pa].
    """
    force = 4.0 * np.pi * radius**2 * pressure / (SOLID_SHARE * TOUCHING)
    return float(
        (9.0 * force**2 / (8.0 * radius * material.contact_modulus**2)) ** (1.0 / 3.0)
    )


def denser_by_weight(height: float, radius: float, material: Material) -> float:
    """Estimate by what share the own weight makes a bed at rest denser than one of hard
    spheres.

    Distances between centres shrink by the overlap, in every direction; taken at half
    of the `height` [m].
    """
    pressure = SOLID_SHARE * material.density * GRAVITY * 0.5 * height
    return 1.5 * overlap_by_pressure(pressure, radius, material) / radius


def too_soft(
    height: float, radius: float, material: Material
) -> tuple[float, float] | None:
    """Return by what share a bed packs denser under its weight and the modulus [Pa]
    that is enough; None if it is.
    """
    denser = denser_by_weight(height, radius, material)
    if denser <= DENSER:
        return None
    return denser, material.youngs_modulus * (denser / DENSER) ** 1.5

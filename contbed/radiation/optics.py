"""Optics of a bed or a medium, from its particles or given directly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contbed.closures import optics as closures
from contbed.radiation.equations.p1 import emitted
from contbed.radiation.scene import Radiating


@dataclass(frozen=True)
class Optics:
    """Absorption, scattering and diffusion coefficient of a medium.

    `active` is K_a [1/m] of species at the temperature that is solved for, or that emit
    what they absorb; `passive` that of species of given temperature, `emission` is 4
    sum K_a sigma T^4 of these [W/m3], `diffusion` is D [m].
    """

    active: float
    passive: float
    emission: float
    scattering: float
    diffusion: float

    @property
    def absorption(self) -> float:
        """All K_a [1/m]."""
        return self.active + self.passive

    @property
    def extinction(self) -> float:
        """Beta [1/m]."""
        return self.absorption + self.scattering


def optics(scene: Radiating) -> Optics:
    """Return the optics of a scene, from its particles or given directly."""
    table = scene.radiation
    assert table is not None
    if table.absorption is not None or table.scattering is not None:
        temperatures = [table.temperature]
        found = closures.Optics(
            np.array([table.absorption or 0.0]),
            np.array([table.scattering or 0.0]),
            table.anisotropy,
        )
    else:
        solids = 1.0 - scene.packed_bed.porosity
        temperatures = [
            item.temperature or table.temperature for item in scene.solids.values()
        ]
        particles = [
            closures.Species(
                name, item.volume_share * solids, item.diameter, item.emissivity
            )
            for name, item in scene.solids.items()
        ]
        found = closures.optics(particles, table.correction, table.anisotropy)
    each = [(float(k), T) for k, T in zip(found.absorption, temperatures, strict=True)]
    given = [(k, T) for k, T in each if T is not None]
    return Optics(
        active=sum(k for k, T in each if T is None),
        passive=sum(k for k, _ in given),
        emission=sum(k * emitted(T) for k, T in given),
        scattering=float(found.scattering_total),
        diffusion=float(
            found.diffusion("two_flux" if table.level == "two_flux" else "p1")
        ),
    )

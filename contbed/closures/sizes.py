"""Sizes of particles: one diameter, or classes with their shares of the mass.

Equation numbers: Rabi and de Souza-Santos, Incorporation of a two-flux model for
radiative heat transfer in a comprehensive fluidized bed simulator, part I.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contbed.errors import SceneError

_SUM_TOLERANCE = 1e-6  # of mass fractions that are typed in


@dataclass(frozen=True)
class SizeDistribution:
    """Classes of particle size: mean diameter [m] and mass fraction [-] of each."""

    diameters: tuple[float, ...]
    mass_fractions: tuple[float, ...]

    def __post_init__(self) -> None:
        problems = []
        if not self.diameters or len(self.diameters) != len(self.mass_fractions):
            problems.append(
                f"sizes: {len(self.diameters)} diameters but "
                f"{len(self.mass_fractions)} mass fractions"
            )
        problems += [
            f"diameter = {d:g} must be above 0 and finite [m]"
            for d in self.diameters
            if not 0 < d < np.inf
        ]
        problems += [
            f"mass fraction = {x:g} must be within 0 and 1"
            for x in self.mass_fractions
            if not 0 <= x <= 1
        ]
        total = sum(self.mass_fractions)
        if not problems and abs(total - 1) > _SUM_TOLERANCE:
            problems.append(
                f"mass fractions sum to {total:.9g}, must sum to 1 within "
                f"{_SUM_TOLERANCE:g}"
            )
        if problems:
            raise SceneError(problems)

    @classmethod
    def from_sieves(
        cls, apertures: Sequence[float], mass_fractions: Sequence[float]
    ) -> SizeDistribution:
        """Between n + 1 increasing apertures [m] lie n classes, each with the middle
        of its interval for a diameter.
        """
        if len(apertures) != len(mass_fractions) + 1:
            wanted = (
                f"{len(mass_fractions)} classes lie between "
                f"{len(mass_fractions) + 1} apertures"
            )
            raise SceneError(f"sieves: {wanted}, got {len(apertures)}")
        if not all(low < high for low, high in pairwise(apertures)):
            raise SceneError(
                "sieves: apertures must increase, got "
                f"{', '.join(f'{a:g}' for a in apertures)} [m]"
            )
        middles = (0.5 * (low + high) for low, high in pairwise(apertures))
        return cls(tuple(middles), tuple(mass_fractions))

    @property
    def d_32(self) -> float:
        """Sauter mean diameter [m], 1 / sum(x_i / d_i): eqs. 20 and 21."""
        return 1 / sum(
            x / d for x, d in zip(self.mass_fractions, self.diameters, strict=True)
        )

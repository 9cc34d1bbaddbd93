"""What a cheaper level of intraparticle transport misses in what leaves a bed, by the
exact solutions of `uptake`.

The same for heat and for gases that are adsorbed: Bi = h R/k or k_f R/D, transfer units
h a L/(G c) or k_f a L/u, Fo = alpha L/(v R^2) or D L/(K v R^2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contbed.particle.uptake import (
    Level,
    breakthrough_error,
    moving_bed_error,
    steady_error,
)

# names of shapes in scenes
SHAPES = {"spheres": "sphere", "rods": "cylinder"}


@dataclass(frozen=True)
class Passage:
    """A bed as its particles see it; see the module.

    fourier : of particles that move, None at rest
    gamma : capacity flow of the solids over that of the fluid, signed; 0 without one
    last : end of the run over the time of the mean breakthrough
    """

    biot: float
    units: float
    shape: str
    fourier: float | None = None
    gamma: float = 0.0
    last: float = np.inf
    steady: bool = False

    def error(self, level: Level) -> float:
        """Return the predicted error of a level over the span of the inlets; a
        transient moving bed starts as one at rest and ends steady.
        """
        moves = self.fourier is not None and self.gamma != 0.0
        if self.steady and not moves:
            return steady_error(self.units, self.biot, level, self.shape)
        errors = []
        if not self.steady:
            errors.append(
                breakthrough_error(self.units, self.biot, level, self.shape, self.last)
            )
        if self.fourier is not None and moves:
            errors.append(
                moving_bed_error(self.gamma, self.biot, self.fourier, level, self.shape)
            )
        return max(errors)

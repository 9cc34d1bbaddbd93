"""Rough particles in a gas: what their contacts and the temperature jump put in the
way of heat.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contbed.arrays import Array
from contbed.closures.contact import (
    contact_cooper_mikic_yovanovich,
    contact_separation_yovanovich,
    temperature_jump_kennard,
)
from contbed.closures.ranges import RangeUse, usage

# pressure over hardness of pairs that do not touch, to keep the laws finite where they
# do not count
LIGHTEST = 1e-6


class Surface(NamedTuple):
    """Surface of the particles and gas at it.

    `roughness` [m] and `slope` [-] of one particle, `microhardness`,
    `youngs_modulus` [Pa] and `poisson_ratio` of the material; `mean_free_path` [m],
    `accommodation`, `heat_capacity_ratio` and `prandtl` [-] of the gas.
    """

    roughness: float
    slope: float
    microhardness: float
    youngs_modulus: float
    poisson_ratio: float
    mean_free_path: float
    accommodation: float = 0.9
    heat_capacity_ratio: float = 1.4
    prandtl: float = 0.71

    def pressure(self, r_contact: Array, R: float) -> Array:
        """Evaluate the mean pressure [Pa] of Hertz's contacts of equal spheres,
        4 E* r_c/(3 pi R*), R* = R/2.
        """
        modulus = 0.5 * self.youngs_modulus / (1.0 - self.poisson_ratio**2)
        return 8.0 * modulus * r_contact / (3.0 * np.pi * R)

    def uses(self, r_contact: Array, R: float) -> list[RangeUse]:
        """Compare the contacts of equal spheres with the ranges of the closures."""
        pressure = self.pressure(r_contact[r_contact > 0.0], R)
        both = np.sqrt(2.0) * self.roughness
        hardness = self.microhardness
        return [
            usage(
                contact_cooper_mikic_yovanovich,
                k_solid=1.0,
                roughness=both,
                slope=self.slope,
                pressure=pressure,
                hardness=hardness,
            ),
            usage(
                contact_separation_yovanovich,
                roughness=both,
                pressure=pressure,
                hardness=hardness,
            ),
            usage(
                temperature_jump_kennard,
                mean_free_path=self.mean_free_path,
                accommodation=self.accommodation,
                gamma=self.heat_capacity_ratio,
                Pr=self.prandtl,
            ),
        ]

    def judge(self, r_contact: Array, R: float) -> list[str]:
        """Warn of contacts of equal spheres that bear more than the solid can."""
        highest = float(np.max(self.pressure(r_contact, R), initial=0.0))
        if highest <= self.microhardness:
            return []
        return [
            f"contacts bear a mean pressure of up to {highest:.3g} Pa, more than the "
            f"microhardness of {self.microhardness:.3g} Pa: the solid would yield, and "
            "neither Hertz's contact nor its conductance holds; see youngs_modulus, "
            "microhardness and the radius of the contacts"
        ]

    def resistances(
        self, r_contact: Array, R: float, k_particle: float, k_fluid: float
    ) -> tuple[Array, float]:
        """Find the coefficient of each joint [W/m2/K], asperities and gas side by side,
        and the temperature jump [m].

        The pressure is the mean over a contact; taken point by point over Hertz's
        ellipse the coefficient would be 0.3 % lower.
        """
        pressure = np.maximum(
            self.pressure(r_contact, R), LIGHTEST * self.microhardness
        )
        both = np.sqrt(2.0)  # roughness and slope of two alike surfaces
        jump = float(
            temperature_jump_kennard(
                self.mean_free_path,
                self.accommodation,
                self.heat_capacity_ratio,
                self.prandtl,
            )
        )
        asperities = contact_cooper_mikic_yovanovich(
            k_particle,
            both * self.roughness,
            both * self.slope,
            pressure,
            self.microhardness,
        )
        separation = contact_separation_yovanovich(
            both * self.roughness, pressure, self.microhardness
        )
        return np.asarray(asperities + k_fluid / (separation + jump)), jump

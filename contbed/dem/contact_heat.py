"""Temperatures of particles that move: conduction through every closed contact, at
every step of the time loop.

    m_i c_i dT_i/dt = sum over contacts of G_ij (T_j - T_i) + q_i

G is Eq. 7 (`heat_impact`) during the first t_c of a contact, t_c the duration of an
elastic impact at the speed with which the particles met, and Eq. 6 (`heat_pair`)
afterwards; equation numbers are those of Zhou, Hou and Yu 2011. A step in which t_c
ends counts in part, so that an impact gives the heat Q = G t_c whatever the time step.
What leaves one particle enters another, so that heat is conserved to rounding. Walls
are adiabatic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array
from contbed.compiled.functions import inner
from contbed.dem.contact import Vector
from contbed.dem.heat_impact import (
    DURATION5,
    conductance_of,
    constants_of,
    impact_of,
)
from contbed.dem.kernel_arrays import HEAT_PAIR, Row, Table
from contbed.dem.particles import Material
from contbed.errors import SceneError


@dataclass(frozen=True)
class ContactHeat:
    """Thermal properties, one for all or one for each material, and corrections for too
    soft particles.

    Parameters
    ----------
    conductivity [W/m/K]; heat_capacity [J/kg/K]
    static, impact : factors c of `heat_pair.correction` for contacts at rest (exponent
        1/3) and impacts (1/5)
    """

    conductivity: ArrayLike
    heat_capacity: ArrayLike = 840.0
    static: float = 1.0
    impact: float = 1.0

    def capacities(self, materials: Sequence[Material]) -> Array:
        """Return the heat capacity of each material [J/kg/K]."""
        return self._each(self.heat_capacity, materials, "heat_capacity")

    def table(self, materials: Sequence[Material]) -> Table:
        """Tabulate the constants of all pairs of materials, shape (m, m), columns as
        in `kernel_arrays.HEAT_PAIR`.
        """
        k = self._each(self.conductivity, materials, "conductivity")
        C = np.array([material.density for material in materials]) * self.capacities(
            materials
        )
        table = np.empty((len(materials), len(materials)), HEAT_PAIR)
        table["at_rest"] = 4.0 * self.static / np.add.outer(1.0 / k, 1.0 / k)
        table["impact"] = self.impact**3
        constants = constants_of((k[:, None], k), (C[:, None], C))
        for name, values in zip(
            ("diffusivity", "capacity_ratio", "effusivity"), constants, strict=True
        ):
            table[name] = values
        return table

    @staticmethod
    def _each(values: ArrayLike, materials: Sequence[Material], name: str) -> Array:
        found = np.asarray(values, dtype=np.float64)
        if found.shape not in ((), (len(materials),)) or not (found > 0.0).all():
            raise SceneError(
                f"heat: {name} = {values!r} must be positive, one number or one for "
                "each material"
            )
        return np.broadcast_to(found, (len(materials),)).copy()


@inner(error_model="numpy", nogil=True)
def impact_conductance(
    at_rest: float, pair: Row, contact: Vector, speed: float, age: float, dt: float
) -> float:
    """Evaluate the conductance [W/K] of a contact in a step: Eq. 7 as long as the
    impact lasts, Eq. 6 afterwards.

    Batchelor and O'Brien (Eq. 6) for contacts at rest, Zhou, Yu and Horio (Eq. 7) for
    impacts.

    Parameters
    ----------
    at_rest : Eq. 6 at the present overlap [W/K]
    pair : a row of `kernel_arrays.HEAT_PAIR`
    contact : effective radius [m], mass [kg] and modulus [Pa]
    speed : normal speed at the first touch [m/s]
    age, dt : steps since the first touch, length of a step [s]
    """
    r_eff, m_eff, modulus = contact.x, contact.y, contact.z
    if speed * (age * dt) ** 5 >= DURATION5 * m_eff**2 / (r_eff * modulus**2):
        return at_rest
    _, duration, area = impact_of(r_eff, m_eff, modulus, speed)
    share = min(duration / dt - age, 1.0)
    hit = conductance_of(
        duration, area, pair.diffusivity, pair.capacity_ratio, pair.effusivity
    )
    return float(share * pair.impact * hit + (1.0 - share) * at_rest)

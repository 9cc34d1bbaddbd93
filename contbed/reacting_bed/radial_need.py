"""Whether a bed has to be resolved across the flow: Mears' criterion on the heat
through its wall.

    dT = q R/(2 K_r)                    from the axis to the wall, of a parabola that carries q [W/m2] through the wall
    dT < 0.4 R_g T^2/E                  for a mean rate within 5 % of that at the wall

with q = (T_a - T_in)/(1/h_w + R/(4 K_r)), or the given flux, K_r at the inlet and E the
largest apparent activation energy of the rates there.

Source: Mears 1971, Ind. Eng. Chem. Process Des. Dev. 10, 541-547,
    doi:10.1021/i260040a020.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.scene import Section

MEARS = 0.4  # of R T^2/E, the largest difference for a rate within 5 %
WARMER = 1.0  # [K], by which temperatures differ for apparent activation energies


@dataclass(frozen=True)
class Across:
    """Difference of temperature across the bed [K], and that which keeps rates
    within 5 %; None without rates.
    """

    difference: float
    limit: float | None

    def __str__(self) -> str:
        found = (
            f"the wall heat flux causes a difference of {self.difference:.3g} K "
            "across the bed at the inlet"
        )
        if self.limit is None:
            return found
        word = "below" if self.fits else "above"
        return (
            f"{found}, {word} the {self.limit:.3g} K that Mears' criterion allows "
            "for rates within 5 %"
        )

    @property
    def fits(self) -> bool:
        """Whether one dimension is enough."""
        return self.limit is None or self.difference < self.limit


def across(problem: Problem) -> Across | None:
    """Return the difference across a bed at its inlet; None without a wall, or where no
    conductivity is known.

    A bed in one dimension has the transverse conductivity of its closure "vdi".
    """
    diameter, bed = problem.scene.mesh.diameter, problem.bed
    if problem.scene.wall is None or diameter is None or not bed.layout.temperatures:
        return None
    state = bed.state(problem.first_point())
    medium = bed.medium
    if medium.scene.section is None:
        resolved = medium.scene.with_table(
            "packed_bed", section=Section(dispersion="vdi")
        )
        medium = medium.of(
            resolved, problem.species, problem.streams, medium.with_pressure
        )
    try:
        radial = medium.radial(state)
    except SceneError:
        return None
    K, radius = float(radial.conductivity), 0.5 * diameter
    q = float(
        medium.through_wall(
            problem.streams.T_gas, medium.wall_coefficient(state), K, 0.25 * radius
        )
    )
    return Across(abs(q) * radius / (2.0 * K), _limit(problem))


def _limit(problem: Problem) -> float | None:
    T = problem.streams.T_gas
    cold, hot = (_rates(problem, T + sign * WARMER) for sign in (-1.0, 1.0))
    with np.errstate(all="ignore"):
        per_kelvin = np.abs(np.log(hot / cold)) / (2.0 * WARMER)  # E/(R T^2)
    steepest = max(per_kelvin[np.isfinite(per_kelvin)], default=0.0)
    return float(MEARS / steepest) if steepest > 0.0 else None


def _rates(problem: Problem, T: float) -> Any:
    bed = problem.bed
    values = [
        T if each.is_temperature else value
        for each, value in zip(bed.layout.unknowns, problem.first_point(), strict=True)
    ]
    state = bed.state(values)
    return np.array([float(rate) for rate in bed.rates(state, bed.medium.at(state))])

"""Parts of settling: a bed comes to rest soft, then ever stiffer up to the modulus
of its material.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from contbed.dem.contact import largest_safe_step
from contbed.dem.particles import Material, Particles

SOFT = 1e6  # Pa, at which a bed settles first
STIFFER = 10.0  # factor of the modulus from one part to the next
CALM = 1e-4  # kinetic energy over N m g d before the last part
LONGEST = 4.0  # s of motion in one part
IMPACT = 0.3  # m/s, speed of impacts that the time step is made for
CHECK_EVERY = 500  # steps between looks at the kinetic energy
# s of processor to settle a particle, by the steps in which it would fall from the
# height of the loose bed: in the first stage, and in later, stiffer ones; within 0.6 to
# 1.7 of what 200 to 175,800 spheres with friction took
SETTLING = 0.6e-6, 0.13e-6
# times as long without friction, which damps what restitution leaves: of 1000 and 3000
# spheres
FRICTIONLESS = 2.9


class Stage(NamedTuple):
    """A part of settling: material, kinetic energy over N m g d at its end, time
    step [s], most steps.
    """

    material: Material
    at_rest: float
    time_step: float
    steps: int


def stages_of(
    bed: Particles, material: Material, at_rest: float, gravity: float
) -> list[Stage]:
    """List the parts of settling: soft at first, then stiffer up to the modulus of the
    material.

    Parameters
    ----------
    bed : the spheres where they start
    material : its modulus is that of the last part
    at_rest : kinetic energy over N m g d at the end of the last part
    gravity : [m/s2]
    """
    drop = np.sqrt(2.0 * float(np.max(bed.position[:, 2])) / gravity)
    modulus = min(SOFT, material.youngs_modulus)
    stages: list[Stage] = []
    while True:
        soft = replace(material, youngs_modulus=modulus)
        last = modulus == material.youngs_modulus
        step = largest_safe_step(bed, [soft], IMPACT)
        calm = at_rest if last and stages else max(at_rest, CALM)
        stages.append(Stage(soft, calm, step, round((LONGEST + drop) / step)))
        if last:
            return stages
        modulus = min(STIFFER * modulus, material.youngs_modulus)


def settling_time(
    stages: list[Stage], number: int, height: float, gravity: float
) -> float:
    """Predict how long a bed takes to settle [s of processor].

    Parameters
    ----------
    stages : of settling, see `stages_of`
    number : of spheres
    height : of the loose bed [m]
    gravity : [m/s2]
    """
    fall = float(np.sqrt(2.0 * height / gravity))
    first, *later = stages
    steps = SETTLING[0] / first.time_step + sum(
        SETTLING[1] / stage.time_step for stage in later
    )
    return (
        number
        * fall
        * steps
        * (FRICTIONLESS if first.material.sliding_friction == 0.0 else 1.0)
    )


def not_at_rest(stage: Stage, unrest: float) -> str:
    """Say that a part of settling ended before the spheres came to rest."""
    return (
        f"packing: kinetic energy {unrest:.3g} of N m g d after "
        f"{stage.steps * stage.time_step:.3g} s at "
        f"E = {stage.material.youngs_modulus:g} Pa, {stage.at_rest:g} is wanted; "
        "add friction or damping, or accept more"
    )

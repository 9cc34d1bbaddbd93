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


def not_at_rest(stage: Stage, unrest: float) -> str:
    """Say that a part of settling ended before the spheres came to rest."""
    return (
        f"packing: kinetic energy {unrest:.3g} of N m g d after "
        f"{stage.steps * stage.time_step:.3g} s at "
        f"E = {stage.material.youngs_modulus:g} Pa, {stage.at_rest:g} is wanted; "
        "a lower restitution and more sliding friction stop spheres sooner"
    )

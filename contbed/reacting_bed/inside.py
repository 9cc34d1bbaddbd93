"""What is resolved inside of particles that adsorb gas: the film alone, a linear driving force, or points inside.

The cheaper levels are judged by the exact breakthrough of a step, or in a bed that moves by its exact steady state,
both for the straight isotherm through what the gas that enters would load (`particle.uptake`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.closures.reactions import R_GAS
from contbed.particle.interior import SURFACE_OVER_VOLUME, interior
from contbed.particle.uptake import Level, breakthrough_error, moving_bed_error
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.inside import Inside, Isotherm, adsorbed

SHAPES = {"spheres": "sphere", "rods": "cylinder"}
LEVELS: Mapping[str, Level] = {"film": "lumped", "linear_driving_force": "effective", "interior": "interior"}
LEAST_FRACTION = 1e-9  # at which the slope of an isotherm is taken where none of its gas enters at the start


@dataclass(frozen=True)
class Choice:
    """The level of a bed and the numbers that chose it, those of the gas for which the cheaper levels miss most.

    biot : k_f R/D; units : k_f a L/u; fourier : D L/(K v R^2) of moving particles, None at rest, with K what is held
    per volume of particles over the concentration of the gas
    error : of each cheaper level in what leaves, over its step
    """

    level: str
    gas: str
    biot: float
    units: float
    fourier: float | None
    error: dict[str, float]

    def __str__(self) -> str:
        which = {
            "film": "one concentration per particle, film alone",
            "linear_driving_force": "one concentration per particle, film in series with diffusion inside",
            "interior": "points inside of the particles",
        }[self.level]
        stay = "" if self.fourier is None else f", Fo = {self.fourier:.3g}"
        errors = ", ".join(f"{name} {self.error[name]:.1e}" for name in self.error)
        return (
            f"{which}: for {self.gas} Bi = {self.biot:.3g}{stay}, {self.units:.3g} transfer units; error of what "
            f"leaves over its step, isotherms taken as straight: {errors}"
        )


def isotherms_of(scene: s.ReactingScene) -> dict[str, Isotherm]:
    """Return the isotherms of a scene by gas."""
    return {
        name: Isotherm(float(table.henry or table.affinity or 0.0), table.capacity, table.enthalpy, table.temperature)
        for name, table in scene.adsorption.items()
    }


def inside_of(scene: s.ReactingScene, bed: Bed, entering: Any, density: float) -> tuple[Inside | None, Choice | None]:
    """Return the particles of a scene that take up gas, and how their level was chosen; None without adsorption.

    Parameters
    ----------
    bed : without its particles' inside
    entering : state of the gas and the particles as they enter
    density : of the particles [kg/m3]
    """
    if not scene.adsorption:
        return None, None
    shape = SHAPES[scene.bed.shape]
    solid = scene.solid
    assert solid is not None
    points = interior(scene.particle.points, shape)
    inside = Inside(
        tuple(scene.adsorption),
        isotherms_of(scene),
        {name: table.diffusivity for name, table in scene.adsorption.items()},
        points.weights,
        points.stiffness,
        points.surface,
        0.0,
        0.5 * scene.bed.diameter,
        solid.porosity,
        density,
        bed.medium.solids,
    )
    choice = _chosen(scene, bed, inside, entering, shape)
    if choice.level == "interior":
        return inside, choice
    resistance = 0.0 if choice.level == "film" else 1.0 / (SURFACE_OVER_VOLUME[shape] + 2)
    return replace(inside, weights=np.ones(1), stiffness=np.zeros((1, 1)), resistance=resistance), choice


def _chosen(scene: s.ReactingScene, bed: Bed, inside: Inside, entering: Any, shape: str) -> Choice:
    """Return the level that a scene names, or the cheapest whose error is small for every gas."""
    films = bed.medium.at(entering).films
    T, u, length = float(entering.T_solid), float(entering.u), scene.mesh.length
    molar = float(entering.p) / (R_GAS * float(entering.T_fluid))
    c = {name: max(float(entering.c[name]), LEAST_FRACTION * molar) for name in inside.gases}
    q = adsorbed(inside.isotherms, c, T)
    found: list[Choice] = []
    for name in inside.gases:
        held = inside.porosity + inside.density * float(q[name]) / c[name]
        D, k = inside.diffusivities[name], float(films[name])
        biot = k * inside.radius / D
        units = k * inside.solids * inside.surface / inside.radius * length / abs(u)
        v, fourier = bed.velocity_solid, None
        if v:
            fourier = D / held * length / (abs(v) * inside.radius**2)
        error = {}
        for level, exact in LEVELS.items():
            if level == "interior":
                continue
            if fourier is not None and scene.time is None:
                error[level] = moving_bed_error(v * inside.solids * held / u, biot, fourier, exact, shape)
            else:
                error[level] = breakthrough_error(units, biot, exact, shape)
        found.append(Choice(scene.particle.adsorption, name, biot, units, fourier, error))
    worst = max(found, key=lambda each: each.error["linear_driving_force"])
    if worst.level != "auto":
        return worst
    for level in ("film", "linear_driving_force"):
        if all(each.error[level] <= scene.solver.accuracy for each in found):
            return replace(worst, level=level)
    return replace(worst, level="interior")

"""What is resolved inside of particles that adsorb gas: the film alone, a linear driving force, or points inside.

The cheaper levels are judged by the exact breakthrough of a step, or in a bed that moves by its exact steady state,
both for the straight isotherm through what the gas that enters would load (`particle.uptake`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from contbed.closures.reactions import R_GAS
from contbed.particle.interior import SURFACE_OVER_VOLUME, interior
from contbed.particle.uptake import Level, breakthrough_error, moving_bed_error
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.inside import Inside, Isotherm, adsorbed
from contbed.reacting_bed.equations.kinds import KindsBed, of_kind
from contbed.reacting_bed.equations.unknowns import State
from contbed.reacting_bed.kinds import kind_scene

SHAPES = {"spheres": "sphere", "rods": "cylinder"}
LEVELS: Mapping[str, Level] = {"film": "lumped", "linear_driving_force": "effective", "interior": "interior"}
LEAST_FRACTION = 1e-9  # at which the slope of an isotherm is taken where none of its gas enters at the start


@dataclass(frozen=True)
class Choice:
    """The level of a bed and the numbers that chose it, those of the gas for which the cheaper levels miss most.

    biot : k_f R/D; units : k_f a L/u; fourier : D L/(K v R^2) of moving particles, None at rest, with K what is held
    per volume of particles over the concentration of the gas
    error : of each cheaper level in what leaves, over its step
    reacts : whether gases react inside, which these errors do not know
    """

    level: str
    gas: str
    biot: float
    units: float
    fourier: float | None
    error: dict[str, float]
    reacts: bool = False

    def __str__(self) -> str:
        which = {
            "film": "one concentration per particle, film alone",
            "linear_driving_force": "one concentration per particle, film in series with diffusion inside",
            "interior": "points inside of the particles",
        }[self.level]
        stay = "" if self.fourier is None else f", Fo = {self.fourier:.3g}"
        reacts = "; gases that are adsorbed react, for which points are resolved" if self.reacts else ""
        errors = ", ".join(f"{name} {self.error[name]:.1e}" for name in self.error)
        return (
            f"{which}: for {self.gas} Bi = {self.biot:.3g}{stay}, {self.units:.3g} transfer units; error of what "
            f"leaves over its step, isotherms taken as straight: {errors}{reacts}"
        )


def isotherms_of(scene: s.ReactingScene) -> dict[str, Isotherm]:
    """Return the isotherms of a scene by gas."""
    return {
        name: Isotherm(float(table.henry or table.affinity or 0.0), table.capacity, table.enthalpy, table.temperature)
        for name, table in scene.adsorption.items()
    }


def with_inside(scene: s.ReactingScene, bed: Bed, entering: State) -> tuple[Bed, dict[str | None, Choice]]:
    """Return a bed whose particles take up gas, and how the level of each kind was chosen, None the only one.

    Errors of several kinds add at most, at rest and with straight isotherms: what passes one kind is spread by the
    others. Each may have its part of `solver.accuracy`.

    Parameters
    ----------
    bed : without its particles' inside
    entering : state of the gas and the particles as they enter
    """
    if not isinstance(bed, KindsBed):
        made, choice = _with_inside(scene, bed, entering, scene.solver.accuracy)
        return made, {None: choice}
    parts = dict(bed.parts)
    choices: dict[str | None, Choice] = {}
    views = {kind: kind_scene(scene, kind) for kind, table in scene.solids.items() if table.adsorption}
    for kind, view in views.items():
        limit = scene.solver.accuracy / len(views)
        parts[kind], choices[kind] = _with_inside(view, parts[kind], entering.kinds[kind], limit)
    layout = replace(
        bed.layout,
        inside=tuple(dict.fromkeys(gas for part in parts.values() for gas in part.layout.inside)),
        inside_kinds=tuple(of_kind(name, kind) for kind, part in parts.items() for name in part.layout.inner),
    )
    return replace(bed, parts=parts, layout=layout), choices


def _with_inside(scene: s.ReactingScene, bed: Bed, entering: State, accuracy: float) -> tuple[Bed, Choice]:
    """Return the bed of one kind whose particles take up gas, and how their level was chosen."""
    inside, choice = inside_of(scene, bed, entering, accuracy)
    layout = replace(bed.layout, inside=inside.gases, points=inside.count)
    return replace(bed, inside=inside, layout=layout), choice


def inside_of(scene: s.ReactingScene, bed: Bed, entering: State, accuracy: float) -> tuple[Inside, Choice]:
    """Return the particles of one kind that take up gas, and how their level was chosen.

    Parameters
    ----------
    bed : without its particles' inside
    entering : state of the gas and the particles as they enter
    accuracy : largest error of a level that is taken
    """
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
        bed.medium.solids_density / bed.medium.solids,
        bed.medium.solids,
    )
    choice = _chosen(scene, bed, inside, entering, accuracy)
    if choice.level == "interior":
        return inside, choice
    resistance = 0.0 if choice.level == "film" else 1.0 / (SURFACE_OVER_VOLUME[shape] + 2)
    return replace(inside, weights=np.ones(1), stiffness=np.zeros((1, 1)), resistance=resistance), choice


def _chosen(scene: s.ReactingScene, bed: Bed, inside: Inside, entering: State, accuracy: float) -> Choice:
    """Return the level that a scene names, or the cheapest whose error is small for every gas."""
    shape = SHAPES[scene.bed.shape]
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
    if replace(bed, inside=inside).reacts_inside:
        return replace(worst, level="interior", reacts=True)
    for level in ("film", "linear_driving_force"):
        if all(each.error[level] <= accuracy for each in found):
            return replace(worst, level=level)
    return replace(worst, level="interior")

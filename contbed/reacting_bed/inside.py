"""Level of intraparticle adsorption: external film only, a linear driving force, or
intraparticle points.

The cheaper levels are judged by the exact breakthrough of a step, or in a bed that
moves by its exact steady state, both for the straight isotherm through what the gas
that enters would load (`particle.uptake`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.chemistry.thermo import R_GAS
from contbed.particle.adsorption import Inside, Isotherm, adsorbed
from contbed.particle.interior import SURFACE_OVER_VOLUME, interior
from contbed.particle.level import SHAPES, Passage
from contbed.particle.uptake import Level
from contbed.plan_text import percent
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.unknowns import State

CHEAPER: Mapping[str, Level] = {
    "film": "lumped",
    "linear_driving_force": "effective",
}
# at which the slope of an isotherm is taken where none of its gas enters at the start
LEAST_FRACTION = 1e-9


@dataclass(frozen=True)
class Choice:
    """The level of a bed and the numbers that chose it, those of the gas for which the
    cheaper levels miss most.

    passage : with K the amount held per volume of particles over the concentration of
        the gas
    error : of each cheaper level in what leaves, over its step
    reacts : whether gases react inside, which these errors do not know
    """

    level: str
    gas: str
    passage: Passage
    error: dict[str, float]
    reacts: bool = False

    def __str__(self) -> str:
        which = {
            "film": "one concentration per particle, external film only",
            "linear_driving_force": "one concentration per particle, film in series "
            "with diffusion inside",
            "interior": "intraparticle points",
        }[self.level]
        passage, fourier = self.passage, self.passage.fourier
        residence = "" if fourier is None else f", Fo = {fourier:.3g}"
        reacts = ". Points are resolved, as adsorbed gases react" if self.reacts else ""
        errors = ", ".join(
            f"{name} {percent(error)}" for name, error in self.error.items()
        )
        return (
            f"{which} ({self.gas}: Bi = {passage.biot:.3g}{residence}, {passage.units:.3g} "
            "transfer units). Predicted outlet "
            f"error, with linear isotherms: {errors}{reacts}"
        )


def isotherms_of(table: s.Solid) -> dict[str, Isotherm]:
    """Return the isotherms of a solid phase by gas."""
    return {
        name: Isotherm(
            float(given.henry or given.affinity or 0.0),
            given.capacity,
            given.enthalpy,
            given.temperature,
        )
        for name, given in table.adsorption.items()
    }


def with_inside(
    scene: s.ReactingScene, bed: Bed, entering: State
) -> tuple[Bed, dict[str, Choice]]:
    """Return a bed whose particles take up gas, and how the level of each solid phase
    was chosen.

    Errors of several phases add at most, at rest and with straight isotherms: what
    passes one phase is spread by the others. Each may have its part of
    `solver.accuracy`.

    Parameters
    ----------
    bed : without its particles' inside
    entering : state of the gas and the particles as they enter
    """
    films = {
        name: transport.films
        for name, transport in bed.medium.at(entering).phases.items()
    }
    adsorbing = [name for name, table in scene.solids.items() if table.adsorption]
    choices: dict[str, Choice] = {}
    for name in adsorbing:
        bed, inside = _with_points(scene, bed, name)
        limit = scene.solver.accuracy / len(adsorbing)
        choices[name] = _chosen(
            scene, bed, name, entering.phases[name], films[name], limit
        )
        if choices[name].level != "interior":
            share = 1.0 / (SURFACE_OVER_VOLUME[SHAPES[scene.solids[name].shape]] + 2)
            resistance = 0.0 if choices[name].level == "film" else share
            one = replace(
                inside,
                weights=np.ones(1),
                stiffness=np.zeros((1, 1)),
                resistance=resistance,
            )
            bed = _with(bed, name, one)
    return bed, choices


def _with_points(scene: s.ReactingScene, bed: Bed, name: str) -> tuple[Bed, Inside]:
    """Return a bed with intraparticle points of a phase, and these particles."""
    table, medium = scene.solids[name], bed.phases[name].medium
    points = interior(table.inside.points, SHAPES[table.shape])
    inside = Inside(
        tuple(table.adsorption),
        isotherms_of(table),
        {gas: given.diffusivity for gas, given in table.adsorption.items()},
        points.weights,
        points.stiffness,
        points.surface,
        0.0,
        0.5 * medium.diameter,
        table.porosity,
        medium.density / medium.solids,
        medium.solids,
    )
    return _with(bed, name, inside), inside


def _with(bed: Bed, name: str, inside: Inside) -> Bed:
    """Return a bed whose particles of a phase take up gas."""
    phase = bed.phases[name]
    layout = replace(phase.layout, inside=inside.gases, points=inside.count)
    phases = {**bed.phases, name: replace(phase, inside=inside, layout=layout)}
    layouts = tuple(each.layout for each in phases.values())
    return replace(bed, phases=phases, layout=replace(bed.layout, phases=layouts))


def _chosen(
    scene: s.ReactingScene,
    bed: Bed,
    phase: str,
    entering: State,
    films: Mapping[str, Any],
    accuracy: float,
) -> Choice:
    """Return the level that a scene names for a phase, or the cheapest whose error is
    small for every gas.

    Parameters
    ----------
    bed : with intraparticle points of the phase
    entering : the gas and the particles as they enter, as the phase sees them
    films : coefficients of its films [m/s]
    accuracy : largest error of a level that is taken
    """
    shape = SHAPES[scene.solids[phase].shape]
    inside, v = bed.phases[phase].inside, bed.phases[phase].velocity
    assert inside is not None
    T, u, length = float(entering.T_solid), float(entering.u), scene.mesh.length
    molar = float(entering.p) / (R_GAS * float(entering.T_fluid))
    c = {
        name: max(float(entering.c[name]), LEAST_FRACTION * molar)
        for name in inside.gases
    }
    q = adsorbed(inside.isotherms, c, T)
    found: list[Choice] = []
    for name in inside.gases:
        held = inside.porosity + inside.density * float(q[name]) / c[name]
        D, k = inside.diffusivities[name], float(films[name])
        biot = k * inside.radius / D
        units = k * inside.solids * inside.surface / inside.radius * length / abs(u)
        moves = bool(v) and scene.time is None
        passage = Passage(
            biot,
            units,
            shape,
            D / held * length / (abs(v) * inside.radius**2) if v else None,
            v * inside.solids * held / u if moves else 0.0,
            steady=moves,
        )
        error = {level: passage.error(exact) for level, exact in CHEAPER.items()}
        wanted = scene.solids[phase].inside.adsorption
        found.append(Choice(wanted, name, passage, error))
    worst = max(found, key=lambda each: each.error["linear_driving_force"])
    if worst.level != "auto":
        return worst
    if bed.reacts_inside(phase):
        return replace(worst, level="interior", reacts=True)
    for level in CHEAPER:
        if all(each.error[level] <= accuracy for each in found):
            return replace(worst, level=level)
    return replace(worst, level="interior")

"""Plan of a reacting bed from its scene: unknowns, first cells, what is left out and
why.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.chemistry.effectiveness import effectiveness_of
from contbed.chemistry.kinetics import rates_of
from contbed.course.schedule import Schedule
from contbed.particle.level import SHAPES
from contbed.particle.uptake import correction
from contbed.plan_text import Rows, built_and_skipped, plan_text
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.cells import aim
from contbed.reacting_bed.course import follows
from contbed.reacting_bed.feeds import (
    LITTLE,
    least_left,
    require_gas_left,
    with_cells_of_one_value,
)
from contbed.reacting_bed.inside import Choice
from contbed.reacting_bed.pellet_level import PelletLevel, decided
from contbed.reacting_bed.phases import described_phases, species_of
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.radial_need import across
from contbed.reacting_bed.rate_checks import require_rates
from contbed.reacting_bed.schedule import kinks_passed, shortest_interval
from contbed.reacting_bed.solve import FIRST_CELLS
from contbed.reacting_bed.time_cells import FEWEST, SHORTEST

TRANSIENT_CELLS = 60  # of one length, through which fronts move
# of the gas over the times in which something changes, below which it is quasi-steady
SHORT_RESIDENCE = 0.01
PARTS = {"tube": "rings", "plane": "layers", "duct": "columns of a quarter"}
PELLETS = "intrapellet diffusion"
FIRST_LAYER = 1e-4  # length of the first and last cell over that of the bed


@dataclass(frozen=True)
class Plan:
    """The scene, the problem on its first cells at the start, its series, and what
    is built and left out.
    """

    scene: s.ReactingScene
    problem: Problem
    schedule: Schedule
    stores_gas: bool
    built: Rows
    skipped: Rows
    mesh: None = None

    @property
    def steps(self) -> bool:
        """Whether the run takes time steps that it could resume from."""
        return self.scene.time is not None

    @property
    def policy(self) -> Any:
        """Choice of the linear solver, which is that of bands."""
        from contbed.solvers.linear import Policy

        system = self.problem.system
        return Policy(1, block=system.size // system.line.cells)

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns on the first cells."""
        return {"bed": self.problem.system.size}

    def __str__(self) -> str:
        return plan_text(self)


def first_vertices(scene: s.ReactingScene) -> NDArray[np.float64]:
    """Return the vertices that a run begins with: given cells of one length, or
    cells that grow from both ends.
    """
    length = scene.mesh.length
    if scene.mesh.cells is not None:
        return np.linspace(0.0, length, scene.mesh.cells * 2**scene.mesh.refine + 1)
    if scene.time is not None:
        return np.linspace(
            0.0, length, (FEWEST if follows(scene) else TRANSIENT_CELLS) + 1
        )
    half = 0.5 * np.geomspace(2.0 * FIRST_LAYER, 1.0, FIRST_CELLS // 2)
    return length * np.concatenate([[0.0], half, 1.0 - half[-2::-1], [1.0]])


def plan(scene: s.ReactingScene) -> Plan:
    """Decide what a reacting bed needs.

    Raises
    ------
    SceneError : species, reactions or closures cannot be used
    """
    scene, level = decided(scene, first_vertices(scene))
    schedule, problem = _built(scene)
    little_left = least_left(scene, problem, schedule) < LITTLE
    stores_gas, reason = _gas_storage(scene, problem, schedule, little_left)
    if stores_gas and little_left:
        problem = with_cells_of_one_value(problem)
    parts = _parts(scene, problem, schedule, level)
    in_time = _parts_in_time(scene, problem, schedule, (stores_gas, reason))
    both = built_and_skipped([*parts, *in_time])
    return Plan(scene, problem, schedule, stores_gas, *both)


def _parts_in_time(
    scene: s.ReactingScene,
    problem: Problem,
    schedule: Schedule,
    storage: tuple[bool, str],
) -> Iterator[tuple[str, str, bool]]:
    """Yield what a run in time needs, see `built_and_skipped`; `storage` says whether
    the gas is stored, and why.
    """
    if scene.time is None:
        return
    from contbed.course.described import described_steps

    if scene.initial.file is not None:
        from contbed.reacting_bed.initial import profile_of

        initial = profile_of(scene, problem)
        yield "state at the start", initial.described(problem, storage[0]), True
    yield "steps", described_steps(scene.time, schedule), True
    yield "storage in the gas", storage[1], storage[0]
    if scene.time.cycle is not None:
        yield (
            "cyclic steady state",
            "periods until one closes, of which the run is the last; the time is that "
            "of one",
            True,
        )


def _built(scene: s.ReactingScene) -> tuple[Schedule, Problem]:
    """Return the series and the problem at the start, whose equations have been
    evaluated as everything enters.
    """
    schedule = Schedule.of(scene.boundary, scene.origin.base)
    problem = _at_start(scene, schedule)
    with np.errstate(all="ignore"):
        problem.bed(problem.first_point(), [0.0] * len(problem.layout.names), 0.0)
        if problem.rings is not None:
            state, medium = problem.bed.state(problem.first_point()), problem.bed.medium
            medium.radial(state)
            medium.wall_coefficient(state)
    require_rates(problem, _with_other_gases(scene, problem, schedule))
    require_gas_left(scene, problem, schedule)
    return schedule, problem


def _with_other_gases(
    scene: s.ReactingScene, problem: Problem, schedule: Schedule
) -> Iterator[Problem]:
    """Yield the problem with the streams of the first time at which other gases are
    there or not.
    """
    known = {_gases_there(problem)}
    composed = any(samples.species for samples in schedule.samples.values())
    for at in problem.at_moments(scene, schedule) if composed else ():
        if (there := _gases_there(at)) not in known:
            known.add(there)
            yield at


def _gases_there(problem: Problem) -> frozenset[str]:
    return frozenset(name for name, moles in problem.streams.gas.items() if moles)


def _gas_storage(
    scene: s.ReactingScene, problem: Problem, schedule: Schedule, little_left: bool
) -> tuple[bool, str]:
    """Return whether the gas is stored in time, and why.

    `little_left` says whether particles adsorb nearly all that enters.
    """
    time = scene.time
    if time is None:
        return False, ""
    delay = max(at.gas_residence for at in problem.at_moments(scene, schedule))
    shortest = shortest_interval(schedule, scene, SHORT_RESIDENCE * delay)
    what = (
        "the run"
        if len(schedule.cuts(time.end, kinks_passed(schedule, scene))) == 2
        else "the shortest time between changes of the streams"
    )
    size = f"the gas stays for {delay:.3g} s, {delay / shortest:.2g} of {what}"
    storage = scene.packed_bed.gas_storage
    if storage != "auto":
        return storage == "stored", f'packed_bed.gas_storage = "{storage}"; {size}'
    if little_left:
        return True, f"particles adsorb nearly all of the gas that enters; {size}"
    # where no particles hold gas as well
    fills = scene.initial.gas.composition is not None and not scene.adsorbs
    stored = delay > SHORT_RESIDENCE * shortest or fills
    return stored, size if stored else f"what leaves is early by that: {size}"


def _at_start(scene: s.ReactingScene, schedule: Schedule) -> Problem:
    """Return the problem with the streams at the start; it has a pressure if one of
    the streams of the run needs it.
    """
    species, vertices = species_of(scene), first_vertices(scene)
    problem = Problem.of(schedule.frozen(scene, 0.0), vertices, species)
    if problem.layout.pressure or scene.packed_bed.pressure_drop == "none":
        return problem
    for moment in schedule.moments():
        if Problem.of(
            schedule.frozen(scene, moment), vertices, species
        ).layout.pressure:
            resisted = scene.with_table("packed_bed", pressure_drop="ergun")
            return Problem.of(schedule.frozen(resisted, 0.0), vertices, species)
    return problem


def _effectiveness(problem: Problem, phase: str) -> str:
    """Return the effectiveness of each reaction in a solid phase where the gas
    enters, resolved and by Thiele.
    """
    pellets = problem.pellets[phase]
    at = problem.local(problem.bed.state(problem.first_point()), pellets.reactions[0])
    parts = []
    free = rates_of(pellets.reactions, lambda _: at)
    for reaction, mean, alone in zip(pellets.reactions, pellets(at), free, strict=True):
        rate = float(alone)
        if not rate:
            parts.append(f"{reaction.name} at rest")
            continue
        text = f"{reaction.name} {float(mean) / rate:.3g}"
        gas, moles = next(
            (name, -n) for name, n in reaction.stoichiometry.items() if n < 0
        )
        c = float(at.c[gas])
        k = moles * rate / pellets.solids / c if c else 0.0
        if k > 0.0:
            D = pellets.diffusivities[pellets.gases.index(gas)]
            text += (
                f" (by the Thiele modulus of {gas} "
                f"{float(effectiveness_of(at.radius, k, D)):.3g})"
            )
        parts.append(text)
    where = f" in {phase}" if len(problem.bed.phases) > 1 else ""
    gases = ", ".join(pellets.gases)
    return (
        f"diffusion and reaction of {gases}{where}; effectiveness at the inlet: "
        f"{', '.join(parts)}"
    )


def _followed(problem: Problem) -> str:
    """Return the aim of adaptive cells of a run in time."""
    if not follows(problem.scene):
        return ""
    shortest = SHORTEST * problem.scene.mesh.length
    return (
        f"; adaptive, to errors of {aim(problem):.1e} of the sizes of the fields, "
        f"down to {shortest:.2g} m"
    )


def _parts(
    scene: s.ReactingScene,
    problem: Problem,
    schedule: Schedule,
    level: PelletLevel | None,
) -> Iterator[tuple[str, str, bool]]:
    """Yield the parts of a bed, see `built_and_skipped`."""
    layout, species = problem.layout, problem.species
    cells = (
        f"{problem.line.cells} initially, polynomials of degree {problem.line.degree}"
    )
    yield "cells", f"{cells}{_followed(problem)}", True
    yield "gas", f"{', '.join(layout.gases)}: mole fluxes", True
    if layout.solids:
        yield "solids", f"{', '.join(layout.solids)}: moles per volume", True
    inert = [name for name in species.solids if name not in layout.solids]
    if inert:
        why = "inert: no reaction consumes or forms it"
        yield f"unknowns of {', '.join(inert)}", why, False
    several = len(scene.solids) > 1
    if several:
        yield "solid phases", described_phases(scene.solids), True
    if count := len(layout.temperatures):
        each = f"{count} temperatures: of the gas, and of {', '.join(scene.solids)}"
        known = {1: "one temperature", 2: "two temperatures"}
        yield "energy", known.get(count, each), True
    else:
        T = problem.streams.T_gas
        yield "energy", f"no [heat] table: isothermal at {T:g} K", False
    yield "pressure", _described_pressure(problem), layout.pressure
    yield from _parts_of_species(problem)
    across_it = across(problem)
    if problem.rings is not None:
        rings = f"{problem.rings.count} {PARTS[problem.rings.shape]}"
        yield "the section", f"{rings}; {across_it}" if across_it else rings, True
    elif across_it is not None:
        advice = "" if across_it.fits else ". Add [packed_bed.section] to resolve it"
        text = f"one dimension: {across_it}{advice}"
        yield "differences across the bed", text, False
    for phase, choice in problem.choices.items():
        by = f" by {phase}" if several else ""
        gases = ", ".join(scene.solids[phase].adsorption)
        text = f"{choice}{_short_fronts(problem, choice, scene.solids[phase])}"
        yield f"adsorption of {gases}{by}", text, True
    pellets = [_effectiveness(problem, phase) for phase in problem.pellets]
    if pellets:
        chosen = [str(level)] if level is not None and level.resolved else []
        yield PELLETS, "; ".join(pellets + chosen), True
    if level is not None and not level.resolved:
        yield PELLETS, str(level), False
    for name, table in scene.reactions.items():
        if table.surface is not None:
            text = (
                f"{table.surface} of {Path(str(table.mechanism)).name}, coverages in "
                "steady state with the gas at each point"
            )
            yield f"surface of {name}", text, True
    for reaction in problem.reactions:
        where = "at the particles" + (f", {reaction.phase}" if several else "")
        place = "in the gas" if reaction.site == "gas" else where
        yield f"reaction {reaction.name}", place, True
    if schedule:
        assert scene.time is not None
        keys = ", ".join(
            ".".join(str(part) for part in path) for path in schedule.samples
        )
        pieces = len(schedule.cuts(scene.time.end, kinks_passed(schedule, scene))) - 1
        yield "time series", f"{keys}, in {pieces} pieces", True


def _short_fronts(problem: Problem, choice: Choice, table: s.Solid) -> str:
    """Return what to do about fronts shorter than a cell, which polynomials follow in
    short steps: one transfer unit, film and inside, is as short as those of isotherms
    with a capacity get.
    """
    scene, passage = problem.scene, choice.passage
    unit = scene.mesh.length * correction(passage.biot, SHAPES[table.shape])
    unit /= passage.units
    curved = table.adsorption[choice.gas].capacity is not None
    polynomials = scene.time is not None and problem.line.degree and not follows(scene)
    if not (curved and polynomials) or unit > float(np.min(problem.line.h)):
        return ""
    return (
        f". Fronts of a favourable isotherm can be as short as {1e3 * unit:.3g} mm, less "
        "than a cell: if the run is slow, solver.degree = 0 takes far fewer steps and "
        "spreads them over a few cells"
    )


def _described_pressure(problem: Problem) -> str:
    if problem.layout.pressure:
        return "by closures.permeability and closures.forchheimer"
    if problem.scene.packed_bed.pressure_drop == "none":
        return 'packed_bed.pressure_drop = "none"'
    return "its drop is below 0.1 %, or no viscosity is known"


def _parts_of_species(problem: Problem) -> Iterator[tuple[str, str, bool]]:
    """Yield the films and the dispersion of species."""
    closures, layout = problem.scene.closures, problem.layout
    sherwood = any(
        s.film_of(closures, table, "sherwood") is not None
        for table in problem.scene.solids.values()
    )
    if not sherwood and closures.dispersion_mass is None:
        why = "no closures.sherwood, no closures.dispersion_mass"
        yield "films and dispersion of species", why, False
        return
    if closures.dispersion_mass is not None:
        yield "dispersion of species", "axial", True
    own_films = any(reaction.own_film for reaction in problem.reactions)
    if layout.films:
        yield "films", f"{', '.join(layout.films)} at the particles", True
    elif sherwood and not (layout.inside or own_films):
        yield "films", "no reaction at particles needs them", False

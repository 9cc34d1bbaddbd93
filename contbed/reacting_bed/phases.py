"""Solid phases of a scene: where reactions run, and the species of each.

A constituent or reaction X of the phase PHASE is X_PHASE in a bed of several phases.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from contbed.chemistry.equation import Equation
from contbed.chemistry.kinetics import basis_of
from contbed.chemistry.laws import equations_of, species_in
from contbed.chemistry.species import Species
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.streams import sauter_mean, shares_of
from contbed.reacting_bed.substances import (
    PhaseSpecies,
    Substances,
    constituents_of,
    fed_to,
    phases_named,
    species_without_phases,
)


def described_phases(phases: Mapping[str, s.Solid]) -> str:
    """Return shares and diameters of the solid phases, and their mean, in words."""
    each = [
        f"{name} ({shares_of(phases)[name]:.4g} of the volume, "
        f"{1e3 * table.diameter:.4g} mm)"
        for name, table in phases.items()
    ]
    return f"{', '.join(each)}; Sauter mean {1e3 * sauter_mean(phases):.4g} mm"


def places(scene: s.ReactingScene, species: Species) -> dict[str, tuple[str, ...]]:
    """Return the solid phases in which each reaction runs, none for one in the gas.

    Raises
    ------
    SceneError : a reaction at particles runs in none of several phases
    """
    equations = {
        name: list(equations_of(name, table).values())
        for name, table in scene.reactions.items()
    }
    at_particles = {
        name: any(
            _is_at_particles(name, scene.reactions[name], equation, species)
            for equation in found
        )
        for name, found in equations.items()
    }
    if len(scene.solids) == 1:
        only = tuple(scene.solids)
        return {name: only if inside else () for name, inside in at_particles.items()}
    found = _running(scene, equations, species)
    for name, inside in at_particles.items():
        if inside and not found[name]:
            where = scene.origin.at(("reactions", name))
            raise SceneError(
                f"{where}: reactions.{name}.solid: missing; it runs in particles, and "
                "none that enter hold what "
                f"reacts; name their phase, of {', '.join(scene.solids)}"
            )
    return {
        name: tuple(phase for phase in scene.solids if phase in inside)
        for name, inside in found.items()
    }


def _is_at_particles(
    name: str, table: s.Reaction, equation: Equation, species: Species
) -> bool:
    has_solids = any(each in species.solids for each in equation.stoichiometry)
    return has_solids or basis_of(name, table, equation, species) != "gas"


def _running(
    scene: s.ReactingScene,
    equations: Mapping[str, Iterable[Equation]],
    species: Species,
) -> dict[str, set[str]]:
    """Return the phases of each reaction: those that it names, or that hold what
    reacts, also what others make.
    """
    held = {phase: set(fed_to(table)) for phase, table in scene.solids.items()}
    found: dict[str, set[str]] = {name: set() for name in scene.reactions}
    grows = True
    while grows:
        grows = False
        for name, table in scene.reactions.items():
            for equation in equations[name]:
                solids = {
                    key for key in equation.stoichiometry if key in species.solids
                }
                for phase, there in held.items():
                    runs = phase in phases_named(table) or (
                        table.solid is None and _starts(equation, there, solids)
                    )
                    if runs and not (phase in found[name] and solids <= there):
                        there |= solids
                        found[name].add(phase)
                        grows = True
    return found


def _starts(equation: Equation, held: set[str], solids: set[str]) -> bool:
    """Return whether particles hold all solids on a side from which a reaction
    starts.
    """
    sides = [{name for name in solids if equation.stoichiometry[name] < 0}]
    if equation.reversible:
        sides.append({name for name in solids if equation.stoichiometry[name] > 0})
    return any(side and side <= held for side in sides)


def species_of(scene: s.ReactingScene) -> Substances:
    """Return the species of a scene; each solid phase has its own constituents.

    Raises
    ------
    SceneError : data of a species are missing, or it is not clear where a reaction runs
    """
    total, transport = species_without_phases(scene)
    where = places(scene, total)
    densities = {
        name: data.density
        for name, data in constituents_of(scene.solids).items()
        if data.density is not None
    }
    several = len(scene.solids) > 1
    phases = {}
    for phase, table in scene.solids.items():
        fed = fed_to(table)
        there = set(fed)
        for name, reaction in scene.reactions.items():
            if phase in where[name] or not several:
                there |= species_in(name, reaction) | set(reaction.orders or {})
        solids = {
            name: item
            for name, item in total.solids.items()
            if name in there or not several
        }
        suffix = f"_{phase}" if several else ""
        phases[phase] = PhaseSpecies(total.gases, solids, suffix, fed, densities)
    every = {
        each.full(name): item
        for each in phases.values()
        for name, item in each.solids.items()
    }
    return Substances(total.gases, every, transport, phases)

"""Checks of solid phases: names, shares and data, that there is what is needed of
them, and their reactions.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from contbed.chemistry.laws import equations_of, is_catalytic
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.streams import given_velocity
from contbed.reacting_bed.substances import (
    constituents_of,
    fed_to,
    phases_named,
)
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.mesh import MeshLine
from contbed.scene.names import nearest

Solids = dict[str, s.Solid]
Reactions = dict[str, s.Reaction]
Boundaries = dict[str, s.Boundary]
WUSTITE = "FeO"
WHOLE = 1e-6  # by which shares of the volume may miss one
NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*")


def reactions_in(reactions: Reactions, phase: str) -> Reactions:
    """Return the reactions that may run in a solid phase: those that name it, or
    none.
    """
    return {
        name: each
        for name, each in reactions.items()
        if each.solid is None or phase in phases_named(each)
    }


def constituents_in(solids: Solids, phase: str) -> set[str]:
    """Return the constituents of a solid phase as far as tables say; of several
    phases those that enter with it.
    """
    try:
        fed = set(fed_to(solids[phase]))
    except SceneError:
        fed = set()  # `compositions_sum_to_one` says so
    return fed | set(solids[phase].constituent) if len(solids) == 1 else fed


def stoichiometry(name: str, table: s.Reaction) -> Mapping[str, float]:
    """Return the moles made of each species by the equations of a reaction; none
    where they cannot be read.
    """
    try:
        return {
            key: n
            for equation in equations_of(name, table).values()
            for key, n in equation.stoichiometry.items()
        }
    except SceneError:
        return {}


def phases_fill_the_bed(solids: Solids, mesh: MeshLine, see: See) -> Mistakes:
    """Check names, shares and sizes of solid phases, and that each constituent has
    its data once.
    """
    total = sum(table.volume_share for table in solids.values())
    if not math.isclose(total, 1.0, abs_tol=WHOLE):
        yield (
            ("solids",),
            f"the shares of the volume sum to {total:.6g}, not to 1; correct "
            "volume_share",
        )
    seen: dict[str, tuple[str, s.Substance]] = {}
    for phase, table in solids.items():
        if len(solids) > 1 and not NAME.fullmatch(phase):
            yield (
                ("solids", phase),
                "a phase may have letters and digits in its name and begins "
                "with a letter, as results are named after it",
            )
        if table.diameter > mesh.length:
            text = (
                f"{table.diameter:g} m is more than the length of the bed, "
                f"{see('mesh.length')}"
            )
            yield ("solids", phase, "diameter"), f"{text}; is a unit missing?"
        for name, data in table.constituent.items():
            first, other = seen.setdefault(name, (phase, data))
            if other != data:
                yield (
                    ("solids", phase, "constituent", name),
                    f"has other data in solids.{first}; they hold in all phases: give "
                    "them once, or another name",
                )


def wustite_is_no_pure_oxide(reactions: Reactions, solids: Solids) -> Mistakes:
    """Look for reversible reactions of the FeO of thermodynamic tables: wustite lacks a
    twentieth of its iron and is reduced more easily.
    """
    data = constituents_of(solids).get(WUSTITE)
    if data is not None and (data.shomate or data.heat_capacity):
        return
    for name, table in reactions.items():
        if table.equilibrium_factor == 1.0 and any(
            each.reversible and WUSTITE in each.stoichiometry
            for each in equations_of(name, table).values()
        ):
            yield (
                ("reactions", name, "equation"),
                "thermodynamic tables hold the stoichiometric FeO, which no ore has: K "
                "of its reduction by H2 is 0.25 at 880 degC, and that of wustite, "
                "Fe0.947O, 0.5 to 0.6; give equilibrium_factor = 2.3, or data of wustite "
                f"as solids.NAME.constituent.{WUSTITE}",
            )


def all_phases_exchange_heat_or_none(solids: Solids, closures: s.Closures) -> Mistakes:
    """Check that a phase has a number of Nusselt where another has one of its own."""
    films = {
        phase: s.film_of(closures, table, "nusselt") for phase, table in solids.items()
    }
    if all(film is None for film in films.values()):
        return
    for phase, film in films.items():
        if film is None:
            yield (
                ("solids", phase, "nusselt"),
                "missing, as another phase has one; give it, or closures.nusselt for "
                "those without one",
            )


def reactions_name_phases(reactions: Reactions, solids: Solids) -> Mistakes:
    """Check that the solid phases exist in which reactions run."""
    for name, table in reactions.items():
        if table.solid is None:
            continue
        path = ("reactions", name, "solid")
        for phase in phases_named(table):
            if phase not in solids:
                yield (
                    path,
                    f"there is no solid phase {phase!r}; {nearest(phase, list(solids))}",
                )
        if table.basis in ("gas", "bed"):
            yield (
                path,
                f"a rate per m3 of {table.basis} is not that of a phase; give basis = "
                "'catalyst' or 'particle'",
            )


def steady_states_exist(
    reactions: Reactions, solids: Solids, boundary: Boundaries, time: s.Time | None
) -> Mistakes:
    """Check that solids that react in a steady bed are supplied."""
    for phase in solids if time is None else ():
        if given_velocity(boundary, phase)[1]:
            continue
        there = constituents_in(solids, phase)
        for name, table in reactions_in(reactions, phase).items():
            used = [
                key
                for key, n in stoichiometry(name, table).items()
                if n < 0 and key in there
            ]
            if used:
                yield (
                    ("reactions", name),
                    f"takes {', '.join(used)} of particles at rest, which are used up: "
                    "no steady state exists; give "
                    f"boundary.NAME.solids.{phase}.velocity, or add a [time] table",
                )


def particles_are_known(
    solids: Solids,
    boundary: Boundaries,
    heat: s.Heat | None,
    time: s.Time | None,
    reactions: Reactions,
) -> Mistakes:
    """Check that particles have the density and the heat capacity that something
    needs.
    """
    for phase, table in solids.items():
        moves = bool(given_velocity(boundary, phase)[1])
        if table.density is None:
            yield from _density_is_missing(
                phase,
                table,
                solids,
                reactions,
                moves or (heat is not None and time is not None),
            )
        stores_heat = heat is not None and (moves or time is not None)
        path = ("solids", phase, "heat_capacity")
        if stores_heat and table.composition is None and table.heat_capacity is None:
            yield (
                path,
                "missing; moving particles, and particles in time, store "
                "heat: give their heat capacity",
            )
        if table.composition is not None and table.heat_capacity is not None:
            yield (
                path,
                "has no meaning with a composition, whose constituents have theirs",
            )


def _density_is_missing(
    phase: str, table: s.Solid, solids: Solids, reactions: Reactions, needed: bool
) -> Mistakes:
    """Say what needs the density of particles without one."""
    path = ("solids", phase, "density")
    if table.composition is not None:
        data = constituents_of(solids)
        for name in constituents_in(
            {phase: table.model_copy(update={"constituent": {}})}, phase
        ):
            if name not in data or data[name].density is None:
                yield (
                    path,
                    f"missing; or give solids.{phase}.constituent.{name}.density",
                )
                return
        return
    if needed:
        yield (
            path,
            "missing; particles without composition that move or store heat need it",
        )
        return
    for name, each in reactions.items():
        per_mass = each.basis == "catalyst" or is_catalytic(name, each)
        runs_here = len(solids) == 1 or phase in phases_named(each)
        if per_mass and runs_here:
            yield path, f"missing; the rate of reactions.{name} is per mass of catalyst"
            return


CHECKS: tuple[Check, ...] = (
    phases_fill_the_bed,
    all_phases_exchange_heat_or_none,
    reactions_name_phases,
)

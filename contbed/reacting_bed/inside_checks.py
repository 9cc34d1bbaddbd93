"""Checks of intraparticle transport: gases that are adsorbed and react, pellets that
are resolved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from contbed.chemistry.laws import find_law, is_catalytic, species_in
from contbed.errors import SceneError
from contbed.materials.composition import names_in
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.phase_checks import (
    Boundaries,
    Reactions,
    Solids,
    reactions_in,
)
from contbed.reacting_bed.streams import given_velocity
from contbed.reacting_bed.substances import (
    fed_to,
    gases_named,
    phases_named,
)
from contbed.scene.checking import Mistakes
from contbed.scene.names import nearest
from contbed.scene.series import series_of
from contbed.scene.toml_lines import KeyPath, Origin

PARTICLES_REACT = (
    "resolves catalytic reactions of gases; particles that react have "
    "shrinking_core or three_interfaces"
)


def adsorbed_gases_are_there(
    solids: Solids,
    reactions: Reactions,
    gas: s.Mixture,
    boundary: Boundaries,
    initial: s.Initial,
    origin: Origin,
) -> Mistakes:
    """Check that the gases that are adsorbed enter the bed, fill it at the start or
    are made in it.
    """
    try:
        there = _gases_there(gas, boundary, initial, reactions, origin)
    except SceneError:
        return  # other checks say so
    for phase, table in solids.items():
        for name in table.adsorption:
            if name not in there:
                text = (
                    "no gas of this name enters, fills the bed or reacts; "
                    f"{nearest(name, sorted(there))}"
                )
                yield ("solids", phase, "adsorption", name), text


def _gases_there(
    gas: s.Mixture,
    boundary: Boundaries,
    initial: s.Initial,
    reactions: Reactions,
    origin: Origin,
) -> set[str]:
    """Return the gases that enter, fill the bed or react.

    Raises
    ------
    SceneError : a composition, file or equation cannot be read
    """
    there = set(gases_named(gas, boundary, origin.base))
    if initial.gas.composition is not None:
        there |= set(names_in(initial.gas.composition))
    if initial.file is not None:
        from contbed.reacting_bed.initial_rows import gases_in

        there |= set(gases_in(initial, origin.base))
    for name, table in reactions.items():
        there |= species_in(name, table)
    return there


def particles_can_adsorb(solids: Solids, closures: s.Closures) -> Mistakes:
    """Check that particles that adsorb have a density and a film."""
    for phase, table in solids.items():
        if not table.adsorption:
            continue
        if s.film_of(closures, table, "sherwood") is None:
            text = (
                "missing; the film around particles that adsorb: a number, or "
                "sherwood_wakao_funazkri"
            )
            yield ("closures", "sherwood"), text
        if table.density is None and table.composition is None:
            yield (
                ("solids", phase, "density"),
                "missing; loadings are per mass of particles",
            )


def _species_in_particles(reactions: Reactions, solid: s.Solid) -> dict[str, set[str]]:
    """Return the species of the reactions that run in particles; none where an
    equation cannot be read.
    """
    try:
        constituents = set(solid.constituent) | set(fed_to(solid))
        species = {name: species_in(name, table) for name, table in reactions.items()}
    except SceneError:
        return {}  # other checks say so
    return {
        name: named
        for name, named in species.items()
        if reactions[name].basis in ("catalyst", "particle")
        or is_catalytic(name, reactions[name])
        or reactions[name].surface is not None
        or named & constituents
    }


def _reacting_though_adsorbed(
    solids: Solids, reactions: Reactions
) -> Iterator[tuple[str, str, str]]:
    """Yield phase, reaction and gas where a gas reacts in the particles that adsorb
    it.
    """
    for phase, table in solids.items():
        for name, species in _species_in_particles(
            reactions_in(reactions, phase), table
        ).items():
            for gas in sorted(species & set(table.adsorption))[:1]:
                yield phase, name, gas


def adsorbed_gases_react_by_their_concentrations(
    solids: Solids, reactions: Reactions
) -> Mistakes:
    """Check that pores are modelled once where gases are adsorbed in the particles
    in which they react.
    """
    said: set[tuple[str, str]] = set()
    for phase, name, gas in _reacting_though_adsorbed(solids, reactions):
        table, inside = reactions[name], solids[phase].inside
        law, path = find_law(name, table), ("reactions", name)
        resolved = inside.mass == "interior" or (
            inside.mass != "none" and bool(inside.diffusivity)
        )
        text = f"{gas} is adsorbed by the particles in which it reacts"
        mistake = ""
        if law is not None and law.own_film:
            mistake = (
                f"{text}, and {table.law} has a film and a layer of its own; give a rate by "
                "concentrations, or name the "
                f"phase in which it runs, reactions.{name}.solid, and that which "
                "adsorbs"
            )
        elif resolved or (inside.mass == "effectiveness" and table.diffusivity):
            mistake = (
                f"{text}: it diffuses to the points of "
                f"solids.{phase}.adsorption.{gas}, where it reacts; remove "
                f"solids.{phase}.inside.mass and the diffusivities of pellets"
            )
        if mistake and (name, mistake) not in said:
            said.add((name, mistake))
            yield path, mistake


def pellets_have_diffusivities(solids: Solids, reactions: Reactions) -> Mistakes:
    """Check that gases that react in pellets that are resolved have diffusivities,
    and no others have.
    """
    for phase, table in solids.items():
        path, inside = ("solids", phase, "inside"), table.inside
        asked = inside.mass == "interior" or (
            inside.mass == "auto" and bool(inside.diffusivity)
        )
        if not asked:
            if inside.diffusivity and len(solids) > 1 and table.composition is not None:
                yield (*path, "diffusivity"), PARTICLES_REACT
            yield from _needless(path, inside.diffusivity, set())
            continue
        own = {
            name: each
            for name, each in reactions.items()
            if len(solids) == 1 or phase in phases_named(each)
        }
        species = _species_in_particles(own, table)
        if table.composition is not None:
            yield (
                (*path, "mass" if inside.mass == "interior" else "diffusivity"),
                PARTICLES_REACT,
            )
        elif inside.mass == "interior" and not species:
            text = (
                "nothing reacts in these particles; remove it, or give a reaction "
                f"solid = '{phase}'"
            )
            yield (*path, "mass"), text
        gases = (
            set() if table.composition is not None else set().union(*species.values())
        )
        for gas in sorted(gases - set(inside.diffusivity)):
            yield (
                (*path, "diffusivity"),
                f"{gas} reacts in the particles and has none; give {gas} = in m2/s",
            )
        yield from _needless(path, inside.diffusivity, gases)


def an_effectiveness_acts(solids: Solids, reactions: Reactions) -> Mistakes:
    """Check that diffusivities of reactions and particles with an effectiveness belong
    together.
    """
    slowed = {
        name
        for name, table in reactions.items()
        if table.diffusivity is not None
        and (law := find_law(name, table)) is not None
        and "diffusivity" in law.takes
    }
    inside = {
        phase: _species_in_particles(reactions_in(reactions, phase), table).keys()
        for phase, table in solids.items()
    }
    for name in sorted(slowed):
        path = ("reactions", name, "diffusivity")
        phases = [phase for phase, names in inside.items() if name in names]
        if not phases:
            text = (
                "has no meaning for a reaction in the gas between the particles; give "
                'basis = "particle" or "catalyst", or remove it'
            )
            yield path, text
        elif {solids[each].inside.mass for each in phases} <= {"auto", "interior"}:
            text = (
                f'give solids.{phases[0]}.inside.mass = "effectiveness", or remove it'
            )
            yield path, f"has no meaning without an effectiveness: {text}"
    for phase, names in inside.items():
        if solids[phase].inside.mass == "effectiveness" and not names & slowed:
            text = (
                "no reaction in these particles has a diffusivity, reactions.NAME."
                'diffusivity; without a solid a reaction of gases needs basis = "particle" '
                'or "catalyst"'
            )
            yield ("solids", phase, "inside", "mass"), text


def pores_are_those_of_spheres(solids: Solids, reactions: Reactions) -> Mistakes:
    """Check that no gas diffuses to its reactions in rods, whose pores are not
    modelled.
    """
    diffuses = any(
        getattr(each, "diffusivity", None) is not None for each in reactions.values()
    )
    for phase, table in solids.items():
        inside = table.inside
        resolved = inside.mass != "none" and (diffuses or bool(inside.diffusivity))
        if table.shape == "rods" and resolved:
            yield (
                ("solids", phase, "shape"),
                "intraparticle diffusion with reaction is that of spheres; give "
                f'shape = "spheres" and diameter = {1.5 * table.diameter:g} (m), which '
                "have the same surface over volume and pressure drop",
            )


def an_effectiveness_is_that_of_a_first_order(
    solids: Solids, reactions: Reactions
) -> Mistakes:
    """Look for effectiveness factors of reactions for which Thiele's is not exact."""
    if not any(table.inside.mass == "effectiveness" for table in solids.values()):
        return
    for name, table in reactions.items():
        law = find_law(name, table)
        if getattr(table, "diffusivity", None) is None or (law and law.own_film):
            continue
        orders = (getattr(table, "orders", None) or {}).values()
        reversible = "<->" in (table.equation or "")
        if reversible or any(n not in (0.0, 1.0) for n in orders):
            what = "is reversible" if reversible else "is not of first order"
            yield (
                ("reactions", name, "diffusivity"),
                f"the effectiveness is that of an irreversible reaction of first order, "
                f"and {name} {what}: conversions may be off by a third; take "
                'solids.NAME.inside.mass = "interior" with inside.diffusivity',
            )


def _needless(path: KeyPath, given: Mapping[str, float], gases: set[str]) -> Mistakes:
    """Check that no gas has a diffusivity that no reaction needs."""
    for gas in sorted(set(given) - gases):
        text = (
            "no reaction in particles that are resolved needs it; remove it; an "
            "effectiveness factor takes reactions.NAME.diffusivity"
        )
        yield (*path, "diffusivity", gas), text


def uptake_has_a_meaning(
    solids: Solids,
    reactions: Reactions,
    boundary: Boundaries,
    initial: s.Initial,
    time: s.Time | None,
) -> Mistakes:
    """Check that a bed that adsorbs is not one in which nothing is taken up."""
    reacting = {phase for phase, _, _ in _reacting_though_adsorbed(solids, reactions)}
    idle = [
        phase
        for phase, table in solids.items()
        if table.adsorption and phase not in reacting
    ]
    if not idle:
        return
    if time is None:
        for phase in idle:
            if given_velocity(boundary, phase)[1] == 0.0:
                yield (
                    ("solids", phase, "adsorption"),
                    "particles at rest take up nothing in a steady state: add a [time] "
                    "table, or give "
                    f"boundary.NAME.solids.{phase}.velocity",
                )
        return
    changes = list(series_of(boundary))
    if initial.gas.composition is None and initial.file is None and not changes:
        yield (
            ("initial", "gas", "composition"),
            "missing; particles begin in equilibrium with the gas that fills the bed, "
            "and without it this is the gas "
            "that enters, of which nothing more is taken up",
        )

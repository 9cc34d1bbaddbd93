"""Checks of intraparticle transport: gases that are adsorbed and react, pellets that are resolved."""

from __future__ import annotations

from collections.abc import Mapping

from contbed.closures.reactions_reforming import REACTIONS as REFORMING
from contbed.errors import SceneError
from contbed.materials.composition import names_in
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import CompositionSeries, constant
from contbed.reacting_bed.laws import STAGED
from contbed.reacting_bed.phases import phases_named as kinds_named
from contbed.reacting_bed.schedule import series_of
from contbed.reacting_bed.substances import equations_of
from contbed.scene.checking import Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.series import Series
from contbed.scene.toml_lines import KeyPath, Origin

Reactions = dict[str, s.Reaction]
Adsorptions = dict[str, s.Adsorption]
PARTICLES_REACT = "resolves catalytic reactions of gases; particles that react have shrinking_core or three_interfaces"


def adsorbed_gases_are_there(
    adsorption: Adsorptions, reactions: Reactions, fluid: s.Gas, time: s.Time | None, origin: Origin
) -> Mistakes:
    """Check that the gases that are adsorbed enter the bed, fill it at the start or are made in it."""
    texts = [] if time is None or time.initial_composition is None else [time.initial_composition]
    if isinstance(fluid.composition, CompositionSeries):
        if fluid.composition.file is not None:
            return  # its columns are read where series are checked
        texts += fluid.composition.values
    else:
        texts.append(fluid.composition)
    try:
        there = {name for text in texts for name in names_in(text)}
        if time is not None and time.initial is not None:
            from contbed.reacting_bed.initial_rows import gases_in

            there |= set(gases_in(time, origin.base))
        for name, table in reactions.items():
            there |= {key for equation in equations_of(name, table).values() for key in equation.stoichiometry}
    except SceneError:
        return  # other checks say so
    for name in adsorption:
        if name not in there:
            yield (
                ("adsorption", name),
                f"no gas of this name enters, fills the bed or reacts; {nearest(name, sorted(there))}",
            )


def particles_can_adsorb(adsorption: Adsorptions, mass: s.Mass | None, solid: s.Solids | None) -> Mistakes:
    """Check that particles that adsorb have a density and a film."""
    if not adsorption:
        return
    if mass is None or mass.sherwood is None:
        key = ("mass", "sherwood")
        yield key, "missing; the film around particles that adsorb: a number, or sherwood_wakao_funazkri"
    if solid is None:
        yield ("solid",), "missing; loadings are per mass of particles: give [solid] with density"


def _species_in_particles(reactions: Reactions, solid: s.Solids | None) -> dict[str, set[str]]:
    """Return the species of the reactions that run in particles; none where an equation cannot be read."""
    solids = set() if solid is None else set(solid.constituent)
    try:
        if solid is not None and solid.composition is not None:
            solids |= set(names_in(solid.composition))
        species = {
            name: {key for equation in equations_of(name, table).values() for key in equation.stoichiometry}
            for name, table in reactions.items()
        }
    except SceneError:
        return {}  # other checks say so
    return {
        name: named
        for name, named in species.items()
        if reactions[name].basis in ("catalyst", "particle") or reactions[name].law in REFORMING or named & solids
    }


def adsorbed_gases_react_by_their_concentrations(
    adsorption: Adsorptions, reactions: Reactions, solid: s.Solids | None, particle: s.Particle
) -> Mistakes:
    """Check that pores are modelled once where gases are adsorbed in the particles in which they react."""
    resolved = particle.mass != "none" and (particle.diffusivity or getattr(solid, "diffusivity", {}))
    for name, species in _species_in_particles(reactions, solid).items():
        both = sorted(species & set(adsorption))
        if not both:
            continue
        law, path = reactions[name].law or "power", ("reactions", name)
        if law == "shrinking_core" or law in STAGED:
            yield (
                path,
                f"{both[0]} is adsorbed by the particles in which it reacts, and {law} has a film and a layer of its "
                f"own; give a rate by concentrations, or name kinds: reactions.{name}.solid, "
                f"solids.NAME.adsorption.{both[0]}",
            )
        elif (
            resolved
            or particle.mass == "interior"
            or (particle.mass == "effectiveness" and reactions[name].diffusivity)
        ):
            yield (
                path,
                f"{both[0]} is adsorbed by the particles in which it reacts: it diffuses to the points of "
                f"adsorption.{both[0]}, where it reacts; remove particle.mass and the diffusivities of pellets",
            )


def _react_where_adsorbed(adsorption: Adsorptions, reactions: Reactions, solid: s.Solids | None) -> bool:
    return any(species & set(adsorption) for species in _species_in_particles(reactions, solid).values())


def pellets_have_diffusivities(particle: s.Particle, reactions: Reactions, solid: s.Solids | None) -> Mistakes:
    """Check that gases that react in pellets that are resolved have diffusivities, and no others have."""
    asked = particle.mass == "interior" or (particle.mass == "auto" and bool(particle.diffusivity))
    inside = _species_in_particles(reactions, solid) if asked else {}
    if asked and solid is not None and solid.composition is not None:
        yield ("particle", "mass" if particle.mass == "interior" else "diffusivity"), PARTICLES_REACT
    elif particle.mass == "interior" and not inside:
        yield ("particle", "mass"), "nothing reacts in the particles; remove it, or give a reaction basis = 'catalyst'"
    yield from _fitting(("particle", "diffusivity"), particle.diffusivity, inside, solid)


def _fitting(
    path: KeyPath, given: Mapping[str, float], inside: Mapping[str, set[str]], solid: s.Solids | None
) -> Mistakes:
    """Check diffusivities against the species of the reactions inside of pellets."""
    gases = set() if solid is not None and solid.composition is not None else set().union(*inside.values())
    for gas in sorted(gases - set(given)):
        yield path, f"{gas} reacts in the particles and has none; give {gas} = in m2/s"
    for gas in sorted(set(given) - gases):
        yield (*path, gas), "no reaction in particles that are resolved needs it; remove it"


def kinds_have_diffusivities(particle: s.Particle, reactions: Reactions, solids: dict[str, s.SolidKind]) -> Mistakes:
    """Check that each of several kinds has the diffusivities of the gases that react in its pellets, and no others."""
    if not solids:
        return
    for gas in particle.diffusivity:
        yield (
            ("particle", "diffusivity", gas),
            f"does not say in which solid phase; give solids.NAME.diffusivity.{gas}, for each whose inside is resolved",
        )
    anywhere = False
    for kind, table in solids.items():
        asked = particle.mass == "interior" or (particle.mass == "auto" and bool(table.diffusivity))
        named = {name: each for name, each in reactions.items() if kind in kinds_named(each)}
        inside = _species_in_particles(named, table) if asked else {}
        if table.composition is None:
            anywhere = anywhere or bool(inside)
            yield from _fitting(("solids", kind, "diffusivity"), table.diffusivity, inside, table)
        elif table.diffusivity:
            yield ("solids", kind, "diffusivity"), PARTICLES_REACT
    if particle.mass == "interior" and not anywhere:
        yield ("particle", "mass"), "nothing reacts in the particles; remove it, or name a kind, reactions.NAME.solid"


def uptake_has_a_meaning(
    adsorption: Adsorptions,
    reactions: Reactions,
    solid: s.Solids | None,
    flow: s.Flow,
    fluid: s.Gas,
    boundary: dict[str, s.Boundary],
    time: s.Time | None,
    see: See,
) -> Mistakes:
    """Check that a bed that adsorbs is not one in which nothing is taken up."""
    if not adsorption or _react_where_adsorbed(adsorption, reactions, solid):
        return
    if time is None:
        if not isinstance(flow.velocity_solid, Series) and not constant(flow.velocity_solid):
            yield (
                ("adsorption",),
                "particles at rest take up nothing in a steady state: add a [time] table, or give them a velocity, "
                f"{see('flow.velocity_solid')}",
            )
        return
    changes = [path for path, _ in series_of({"fluid": fluid, "boundary": boundary})]
    if time.initial_composition is None and time.initial is None and not changes:
        yield (
            ("time", "initial_composition"),
            "missing; particles begin in equilibrium with the gas that fills the bed, and without it this is the gas "
            "that enters, of which nothing more is taken up",
        )

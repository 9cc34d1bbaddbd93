"""The equations of a bed from its scene, species and streams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from contbed.chemistry.equation import Equation
from contbed.chemistry.kinetics import Reaction, reactions_of
from contbed.chemistry.thermo import T_STANDARD
from contbed.materials.curve import integral_of, latent_heat_of
from contbed.particle.pellets import in_pellets
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.phase import Enthalpy, Phase
from contbed.reacting_bed.equations.unknowns import Layout, PhaseLayout
from contbed.reacting_bed.medium import Medium
from contbed.reacting_bed.phases import places
from contbed.reacting_bed.streams import Streams, shares_of
from contbed.reacting_bed.substances import PhaseSpecies, Substances, fed_to


def bed_of(
    scene: s.ReactingScene, species: Substances, entering: Streams, medium: Medium
) -> Bed:
    """Return the equations of a bed.

    Raises
    ------
    SceneError : reactions cannot be used
    """
    reactions = _reactions(scene, species)
    layouts = [
        _layout(scene, name, species.phases[name], reactions) for name in scene.solids
    ]
    temperatures = _temperatures(scene, layouts)
    layout = Layout(
        tuple(species.gases), temperatures, medium.with_pressure, tuple(layouts)
    )
    phases = {}
    for each in layouts:
        own = species.phases[each.name]
        inert = _inert(scene.solids[each.name], own, each, entering)
        velocity = entering.velocities[each.name] / (1.0 - scene.packed_bed.porosity)
        phases[each.name] = Phase(
            each, medium.phases[each.name], own.enthalpies, velocity, inert
        )
    return Bed(
        layout,
        species.molar_masses,
        species.enthalpies,
        [_named_for_the_bed(reaction, species) for reaction in reactions],
        medium,
        phases,
        entering.pressure,
        entering.T_gas,
    )


def within(bed: Bed, scene: s.ReactingScene, entering: Streams) -> Bed:
    """Return a bed with the streams and surroundings of a scene that differs in
    nothing else.
    """
    medium = bed.medium.within(scene, entering)
    phases = {
        name: replace(
            phase,
            medium=medium.phases[name],
            velocity=entering.velocities[name] / (1.0 - scene.packed_bed.porosity),
        )
        for name, phase in bed.phases.items()
    }
    return replace(
        bed, medium=medium, phases=phases, p_in=entering.pressure, T_in=entering.T_gas
    )


def _temperatures(
    scene: s.ReactingScene, phases: Sequence[PhaseLayout]
) -> tuple[str, ...]:
    """Return the temperatures of gas and particles that are unknowns."""
    if scene.heat is None:
        return ()
    return (
        ("T_fluid", *(phase.temperature for phase in phases))
        if scene.two_temperatures
        else ("T",)
    )


def _reactions(scene: s.ReactingScene, species: Substances) -> list[Reaction]:
    """Return the reactions of the gas and of the solid phases, constituents by their
    own names.
    """
    found: list[Reaction] = []
    for name, running in places(scene, species.plain).items():
        table = scene.reactions[name]
        if not running:
            found += reactions_of(name, table, species.plain)
        for phase in running:
            own = species.phases[phase]
            with_effectiveness = scene.solids[phase].inside.mass == "effectiveness"
            for each in reactions_of(name, table, own, with_effectiveness):
                full = own.full(each.name) if len(running) > 1 else each.name
                found.append(replace(each, name=full, phase=phase, alone=each.name))
    for phase in scene.solids:
        found = _resolved(scene, phase, species, found)
    return found


def _resolved(
    scene: s.ReactingScene,
    phase: str,
    species: Substances,
    reactions: Sequence[Reaction],
) -> list[Reaction]:
    """Return reactions with those of a phase as means over its pellets, where their
    inside is resolved.
    """
    inside, share = scene.solids[phase].inside, shares_of(scene.solids)[phase]
    if inside.mass not in ("auto", "interior") or not inside.diffusivity:
        return list(reactions)
    own = [reaction for reaction in reactions if reaction.phase == phase]
    resolved = in_pellets(
        own,
        species.gases,
        inside.diffusivity,
        (1.0 - scene.packed_bed.porosity) * share,
    )
    by_name = {reaction.name: reaction for reaction in resolved}
    return [by_name.get(reaction.name, reaction) for reaction in reactions]


def _named_for_the_bed(reaction: Reaction, species: Substances) -> Reaction:
    """Return a reaction whose equation has the names of constituents in the whole
    bed.
    """
    if reaction.phase is None:
        return reaction
    own = species.phases[reaction.phase]
    moles = {
        own.full(name) if name in own.solids else name: n
        for name, n in reaction.stoichiometry.items()
    }
    return replace(reaction, equation=Equation(moles, reaction.equation.reversible))


def _layout(
    scene: s.ReactingScene, name: str, own: PhaseSpecies, reactions: Sequence[Reaction]
) -> PhaseLayout:
    """Return the unknowns of a solid phase without those inside of its particles."""
    running = [reaction for reaction in reactions if reaction.phase == name]
    reacting = {species for reaction in running for species in reaction.stoichiometry}
    solids = tuple(species for species in own.solids if species in reacting)
    return PhaseLayout(name, own.suffix, solids, _films(scene, name, own, running))


def _films(
    scene: s.ReactingScene, name: str, own: PhaseSpecies, running: Sequence[Reaction]
) -> tuple[str, ...]:
    """Return the gases whose films around particles are resolved, but for those that
    are adsorbed, see `inside`.
    """
    if s.film_of(scene.closures, scene.solids[name], "sherwood") is None:
        return ()
    through = [
        reaction
        for reaction in running
        if reaction.site != "gas" and not reaction.own_film
    ]
    wanted = {species for reaction in through for species in reaction.stoichiometry}
    for reaction in through:
        if reaction.key in scene.reactions:
            wanted |= set(scene.reactions[reaction.key].orders or {})
    adsorbed = scene.solids[name].adsorption
    return tuple(
        species
        for species in own.gases
        if species in wanted and species not in adsorbed
    )


def _inert(
    table: s.Solid, own: PhaseSpecies, layout: PhaseLayout, entering: Streams
) -> tuple[tuple[float, Enthalpy], ...]:
    """Return amount per volume of bed and enthalpy of what particles hold beside the
    constituents that react.
    """
    inert: list[tuple[float, Enthalpy]] = []
    for name, species in own.solids.items():
        moles = entering.solid[own.full(name)]
        if name not in layout.solids and moles > 0:
            inert.append((moles, species.enthalpy))
    if not fed_to(table) and table.heat_capacity is not None:
        latent = latent_heat_of(table.melting)
        content = integral_of(table.heat_capacity, latent, T_STANDARD)
        inert.append((entering.densities[layout.name], content))
    return tuple(inert)

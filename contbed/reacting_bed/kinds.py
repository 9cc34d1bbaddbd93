"""Several kinds of particles of a scene: where reactions run, and the species, streams and equations of each kind.

A kind is a bed of its own particles, [solid], with its share of the volume: a scene of each kind and one of the gas
make its parts by the functions of beds with one kind. A constituent X of the kind KIND is X_KIND in the whole bed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.assembled import bed_of, temperatures_of
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.kinds import KindsBed, of_kind
from contbed.reacting_bed.equations.unknowns import Layout
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.kinetics import Reaction, reactions_of, site_of
from contbed.reacting_bed.medium import Medium
from contbed.reacting_bed.pellets import in_pellets
from contbed.reacting_bed.streams import Streams, streams
from contbed.reacting_bed.substances import Equation, Substances, equations_of, substances

Kinds = Mapping[str, s.SolidKind]


def shares_of(solids: Kinds) -> dict[str, float]:
    """Return the share of each kind in the volume of the particles."""
    total = sum(table.volume_share for table in solids.values())
    return {kind: table.volume_share / total for kind, table in solids.items()}


def sauter_mean(solids: Kinds) -> float:
    """Return the diameter of spheres with the volume and surface of all [m]."""
    return 1.0 / sum(share / solids[kind].particle_diameter for kind, share in shares_of(solids).items())


def described_kinds(solids: Kinds) -> str:
    """Return shares and diameters of the kinds, and their mean, in words."""
    each = [
        f"{kind} ({shares_of(solids)[kind]:.4g} of the volume, {1e3 * table.particle_diameter:.4g} mm)"
        for kind, table in solids.items()
    ]
    return f"{', '.join(each)}; Sauter mean {1e3 * sauter_mean(solids):.4g} mm"


def velocities(solids: Kinds, flow: s.Flow) -> dict[str, float]:
    """Return the superficial velocity of each kind as if it filled the bed [m/s]."""
    given = {kind: table.velocity_solid for kind, table in solids.items()}
    return {kind: constant(flow.velocity_solid if v is None else v) for kind, v in given.items()}


def slowest(solids: Kinds, flow: s.Flow) -> float:
    """Return the velocity of the slowest kind that moves, 0 where none does [m/s]."""
    return min((v for v in velocities(solids, flow).values() if v), key=abs, default=0.0)


def fed_to(table: s.Solids) -> dict[str, float]:
    """Return the mass fractions of a kind where it enters."""
    return {} if table.composition is None else mole_fractions(table.composition)


def merged(solids: Kinds) -> s.Solids:
    """Return particles with the constituents of all kinds, for their names and data."""
    names = dict.fromkeys(name for table in solids.values() for name in fed_to(table))
    data = {name: table for kind in solids.values() for name, table in kind.constituent.items()}
    composition = ", ".join(f"{name}:{1.0 / len(names)!r}" for name in names) if names else None
    return s.Solids(composition=composition, constituent=data)


def gas_scene(scene: s.ReactingScene) -> s.ReactingScene:
    """Return the scene of the gas: particles of the mean diameter without exchange, and the slowest velocity."""
    solids, shares = scene.solids, shares_of(scene.solids)
    known = [table.conductivity for table in solids.values()]
    mean = sum(share * (k or 0.0) for share, k in zip(shares.values(), known, strict=True))
    update = {
        "solid": s.Solids(conductivity=None if None in known else mean),
        "solids": {},
        "bed": scene.bed.model_copy(update={"particle_diameter": sauter_mean(solids)}),
        "flow": scene.flow.model_copy(update={"velocity_solid": slowest(solids, scene.flow)}),
        "heat": None
        if scene.heat is None
        else scene.heat.model_copy(update={"nusselt": None, "conductivity_solid": None}),
        "mass": None if scene.mass is None else scene.mass.model_copy(update={"sherwood": None}),
    }
    return scene.model_copy(update=update)


def kind_scene(scene: s.ReactingScene, kind: str) -> s.ReactingScene:
    """Return the scene of one kind as if it filled the bed, without what concerns the gas alone."""
    table, heat, mass = scene.solids[kind], scene.heat, scene.mass
    data = merged(scene.solids).constituent
    if heat is not None:
        Nu = table.nusselt if table.nusselt is not None else heat.nusselt
        heat = s.Heat(nusselt=Nu, conductivity_solid=heat.conductivity_solid)
    if mass is not None:
        mass = s.Mass(sherwood=table.sherwood if table.sherwood is not None else mass.sherwood)
    update = {
        "solid": table.model_copy(update={"constituent": data}),
        "solids": {},
        "bed": scene.bed.model_copy(update={"particle_diameter": table.particle_diameter}),
        "flow": scene.flow.model_copy(update={"velocity_solid": velocities(scene.solids, scene.flow)[kind]}),
        "heat": heat,
        "mass": mass,
        "wall": None,
        "adsorption": table.adsorption,
        "particle": scene.particle.model_copy(update={"diffusivity": table.diffusivity}),
    }
    return scene.model_copy(update=update)


def places(scene: s.ReactingScene, species: Substances) -> dict[str, tuple[str, ...]]:
    """Return the kinds in which each reaction runs, none for one in the gas.

    Raises
    ------
    SceneError : a reaction at particles runs in none, or it is not clear in which
    """
    held = {kind: set(fed_to(table)) for kind, table in scene.solids.items()}
    equations = {name: equations_of(name, table).values() for name, table in scene.reactions.items()}
    found: dict[str, set[str]] = {name: set() for name in equations}
    while True:
        before = sum(map(len, held.values())) + sum(map(len, found.values()))
        for name, table in scene.reactions.items():
            for kind in held:
                for equation in equations[name]:
                    solids = [key for key in equation.stoichiometry if key in species.solids]
                    if kind in kinds_named(table) or (table.solid is None and _starts(equation, held[kind], solids)):
                        held[kind] |= set(solids)
                        found[name].add(kind)
        if before == sum(map(len, held.values())) + sum(map(len, found.values())):
            break
    for name, table in scene.reactions.items():
        at_particles = any(site_of(table, equation, species) != "gas" for equation in equations[name])
        if at_particles and not found[name]:
            where = scene.origin.at(("reactions", name))
            raise SceneError(
                f"{where}: reactions.{name}.solid: missing; it runs in particles, and none that enter hold what "
                f"reacts; name their kind, of {', '.join(scene.solids)}"
            )
    return {name: tuple(kind for kind in held if kind in kinds) for name, kinds in found.items()}


def kinds_named(table: s.Reaction) -> tuple[str, ...]:
    """Return the kinds that a reaction names."""
    return (table.solid,) if isinstance(table.solid, str) else table.solid or ()


def _starts(equation: Equation, held: set[str], solids: list[str]) -> bool:
    """Return whether particles hold all solids on a side from which a reaction starts."""
    sides = [[name for name in solids if equation.stoichiometry[name] < 0]]
    if equation.reversible:
        sides.append([name for name in solids if equation.stoichiometry[name] > 0])
    return any(side and held.issuperset(side) for side in sides)


def species_of(scene: s.ReactingScene) -> Substances:
    """Return the species of a scene; of several kinds each has its own constituents.

    Raises
    ------
    SceneError : data of a species are missing, or it is not clear where a reaction runs
    """
    if not scene.solids:
        return substances(scene)
    data = merged(scene.solids)
    total = substances(scene.model_copy(update={"solid": data, "solids": {}}))
    where = places(scene, total)
    kinds = {}
    for kind, table in scene.solids.items():
        fed = fed_to(table)
        there = set(fed)
        for name, reaction in scene.reactions.items():
            if kind in where[name]:
                there |= {key for each in equations_of(name, reaction).values() for key in each.stoichiometry}
                there |= set(reaction.orders or {})
        solids = {name: item for name, item in total.solids.items() if name in there}
        kinds[kind] = replace(total, solids=solids, fed=fed)
    every = {of_kind(name, kind): item for kind, each in kinds.items() for name, item in each.solids.items()}
    return Substances(total.gases, every, total.entering, {}, total.transport, {}, kinds)


def _entering_of(scene: s.ReactingScene, species: Substances, kind: str) -> Streams:
    """Return the streams of a kind with its share of the volume."""
    share = shares_of(scene.solids)[kind]
    alone = streams(kind_scene(scene, kind), species.kinds[kind])
    solid = {name: share * n for name, n in alone.solid.items()}
    return replace(alone, solid=solid, solids_density=share * alone.solids_density)


def entering(scene: s.ReactingScene, species: Substances) -> Streams:
    """Return the streams that enter a bed of several kinds."""
    gas = streams(gas_scene(scene), species)
    parts = {kind: _entering_of(scene, species, kind) for kind in scene.solids}
    solid = {of_kind(name, kind): n for kind, part in parts.items() for name, n in part.solid.items()}
    return replace(gas, solid=solid, solids_density=sum(part.solids_density for part in parts.values()))


def medium_of_kinds(scene: s.ReactingScene, species: Substances, entering: Streams) -> Medium:
    """Return the coefficients of a bed of several kinds."""
    shares = shares_of(scene.solids)
    kinds = {}
    for kind, share in shares.items():
        density = _entering_of(scene, species, kind).solids_density
        kinds[kind] = replace(Medium.of(kind_scene(scene, kind), species.kinds[kind], density, False), share=share)
    gas = Medium.of(gas_scene(scene), species, entering.solids_density, True)
    return replace(gas, kinds=kinds, velocity_solid=_mean_velocity(scene))


def _mean_velocity(scene: s.ReactingScene) -> float:
    speeds = velocities(scene.solids, scene.flow)
    return sum(share * speeds[kind] for kind, share in shares_of(scene.solids).items())


def _reactions(scene: s.ReactingScene, species: Substances) -> tuple[list[Reaction], dict[str, list[Reaction]]]:
    """Return the reactions of the gas, and those of each kind."""
    where = places(scene, _plain(species))

    def some(of: s.ReactingScene, names: list[str], known: Substances) -> list[Reaction]:
        return reactions_of(of.model_copy(update={"reactions": {name: scene.reactions[name] for name in names}}), known)

    gas = some(gas_scene(scene), [name for name, kinds in where.items() if not kinds], _plain(species))
    found: dict[str, list[Reaction]] = {kind: [] for kind in scene.solids}
    for kind in scene.solids:
        view = kind_scene(scene, kind)
        for name, kinds in where.items():
            if kind in kinds:
                for each in some(view, [name], species.kinds[kind]):
                    full = of_kind(each.name, kind) if len(kinds) > 1 else each.name
                    found[kind].append(replace(each, name=full, kind=kind, alone=each.name))
        found[kind] = in_pellets(view, found[kind], species.gases, shares_of(scene.solids)[kind])
    return gas, found


def _plain(species: Substances) -> Substances:
    """Return the species with constituents by their own names."""
    solids = {name: item for each in species.kinds.values() for name, item in each.solids.items()}
    return replace(species, solids=solids)


def bed_of_kinds(scene: s.ReactingScene, species: Substances, entering: Streams, medium: Medium) -> KindsBed:
    """Return the equations of a bed of several kinds."""
    gas, by_kind = _reactions(scene, species)
    parts, reactions = {}, list(gas)
    for kind, each in by_kind.items():
        own = species.kinds[kind]
        view = kind_scene(scene, kind)
        parts[kind] = bed_of(view, own, _entering_of(scene, species, kind), each, medium.kinds[kind])
        for reaction in each:
            moles = {of_kind(n, kind) if n in own.solids else n: c for n, c in reaction.stoichiometry.items()}
            reactions.append(replace(reaction, equation=Equation(moles, reaction.equation.reversible)))
    temperatures = temperatures_of(scene)
    if len(temperatures) > 1:
        temperatures = ("T_fluid", *(of_kind("T_solid", kind) for kind in parts))
    layout = Layout(
        tuple(species.gases),
        tuple(of_kind(name, kind) for kind, part in parts.items() for name in part.layout.solids),
        temperatures,
        medium.with_pressure,
        tuple(of_kind(name, kind) for kind, part in parts.items() for name in part.layout.films),
        kinds=tuple(parts),
    )
    return KindsBed(
        layout,
        species.molar_masses,
        species.enthalpies,
        reactions,
        medium,
        slowest(scene.solids, scene.flow) / (1.0 - scene.bed.porosity),
        (),
        entering.pressure,
        entering.T_gas,
        parts=parts,
    )


def within(bed: Bed, scene: s.ReactingScene, entering: Streams) -> KindsBed:
    """Return a bed with the streams and surroundings of a scene that differs in nothing else."""
    assert isinstance(bed, KindsBed)
    speeds, solids = velocities(scene.solids, scene.flow), 1.0 - scene.bed.porosity
    media, parts = {}, {}
    for kind, part in bed.parts.items():
        media[kind] = replace(part.medium, scene=kind_scene(scene, kind), velocity_solid=speeds[kind])
        parts[kind] = replace(part, medium=media[kind], velocity_solid=speeds[kind] / solids)
    medium = replace(bed.medium, scene=gas_scene(scene), velocity_solid=_mean_velocity(scene), kinds=media)
    v = slowest(scene.solids, scene.flow) / solids
    return replace(bed, medium=medium, parts=parts, velocity_solid=v, p_in=entering.pressure, T_in=entering.T_gas)

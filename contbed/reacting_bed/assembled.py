"""The equations of a bed with one kind of particles from its scene, species, streams and reactions."""

from __future__ import annotations

from collections.abc import Sequence

from contbed.materials.thermo import T_STANDARD
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.bed import Bed, Enthalpy
from contbed.reacting_bed.equations.unknowns import Layout
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.kinetics import Reaction
from contbed.reacting_bed.medium import Medium
from contbed.reacting_bed.streams import Streams
from contbed.reacting_bed.substances import Substances


def bed_of(
    scene: s.ReactingScene, species: Substances, entering: Streams, reactions: Sequence[Reaction], medium: Medium
) -> Bed:
    """Return the equations of a bed."""
    reacting = {name for reaction in reactions for name in reaction.stoichiometry}
    solids = tuple(name for name in species.solids if name in reacting)
    films = films_of(scene, species, reactions)
    layout = Layout(tuple(species.gases), solids, temperatures_of(scene), medium.with_pressure, films)
    return Bed(
        layout,
        species.molar_masses,
        species.enthalpies,
        reactions,
        medium,
        constant(scene.flow.velocity_solid) / (1.0 - scene.bed.porosity),
        inert_of(scene, species, entering, solids),
        entering.pressure,
        entering.T_gas,
    )


def temperatures_of(scene: s.ReactingScene) -> tuple[str, ...]:
    """Return the temperatures of gas and particles that are unknowns."""
    if scene.heat is None:
        return ()
    return ("T",) if scene.heat.nusselt is None else ("T_fluid", "T_solid")


def films_of(scene: s.ReactingScene, species: Substances, reactions: Sequence[Reaction]) -> tuple[str, ...]:
    """Return the gases whose films around particles are resolved, but for those that are adsorbed, see `inside`."""
    if scene.mass is None or scene.mass.sherwood is None:
        return ()
    through = [r for r in reactions if r.site != "gas" and not r.own_film]
    wanted = {name for r in through for name in r.stoichiometry} | {
        name
        for key, table in scene.reactions.items()
        if any(r.key == key for r in through)
        for name in table.orders or {}
    }
    return tuple(name for name in species.gases if name in wanted and name not in scene.adsorption)


def inert_of(
    scene: s.ReactingScene, species: Substances, entering: Streams, solids: Sequence[str]
) -> tuple[tuple[float, Enthalpy], ...]:
    """Return amount per volume of bed and enthalpy of what the particles hold beside the `solids` that react."""
    inert: list[tuple[float, Enthalpy]] = [
        (n, species.solids[name].enthalpy) for name, n in entering.solid.items() if name not in solids and n > 0
    ]
    solid = scene.solid
    if solid is not None and solid.composition is None and solid.heat_capacity is not None:
        capacity = solid.heat_capacity
        inert.append((entering.solids_density, lambda T: capacity * (T - T_STANDARD)))
    return tuple(inert)

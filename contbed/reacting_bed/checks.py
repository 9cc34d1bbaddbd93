"""Checks of a reacting bed: mistakes in a scene that remain although every single
value is valid.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.chemistry.checks import reaction_is_whole
from contbed.chemistry.elements import molar_mass_of
from contbed.chemistry.laws import find_law
from contbed.chemistry.species import atoms_of
from contbed.closures.binding import named
from contbed.closures.packed_beds import gas_conducts_twice, unusable
from contbed.errors import SceneError
from contbed.materials.composition import require_sum
from contbed.reacting_bed import curve_checks, phase_checks, stream_checks
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.closures import bound, places_of
from contbed.reacting_bed.formula_checks import (
    conversions_are_known,
    formulas_can_be_read,
    species_named,
)
from contbed.reacting_bed.inlet_series import SUM, CompositionSeries
from contbed.reacting_bed.inside_checks import (
    adsorbed_gases_are_there,
    adsorbed_gases_react_by_their_concentrations,
    an_effectiveness_acts,
    an_effectiveness_is_that_of_a_first_order,
    particles_can_adsorb,
    pellets_have_diffusivities,
    pores_are_those_of_spheres,
    uptake_has_a_meaning,
)
from contbed.reacting_bed.phase_checks import (
    Boundaries,
    Reactions,
    Solids,
)
from contbed.reacting_bed.schedule_checks import (
    a_cycle_changes_something,
    cells_can_follow,
    initial_profiles_fit_the_bed,
    initial_profiles_reach_both_ends,
    series_are_usable,
    times_are_in_order,
)
from contbed.reacting_bed.substances import (
    constituents_of,
    mechanism_of,
)
from contbed.scene.checking import Check, Mistakes
from contbed.scene.continuation import parameter_varies
from contbed.scene.mesh import MeshLine
from contbed.scene.mesh_checks import positions_lie_in_the_bed
from contbed.scene.names import nearest
from contbed.scene.toml_lines import KeyPath, Origin

MOST_OF_A_DUCT = 8  # rings; a step of 16 takes two minutes and 11 GB
# of a constituent [J/kg/K]; moisture has 4180, lithium 3600, wood 2500
LARGEST_CAPACITY = 4300.0


def compositions_sum_to_one(
    gas: s.Mixture, solids: Solids, boundary: Boundaries, initial: s.Initial
) -> Mistakes:
    """Check that fractions sum to one, where they are no amounts in moles."""
    given: list[tuple[KeyPath, str | None]] = [
        (("gas", "composition"), gas.composition)
    ]
    for name, table in boundary.items():
        entering = None if table.gas is None else table.gas.composition
        texts = (
            entering.values if isinstance(entering, CompositionSeries) else [entering]
        )
        given += [(("boundary", name, "gas", "composition"), text) for text in texts]
    given.append((("initial", "gas", "composition"), initial.gas.composition))
    given += [
        (("solids", phase, "composition"), table.composition)
        for phase, table in solids.items()
    ]
    for path, text in given:
        if text is None:
            continue
        try:
            require_sum(text, SUM, in_moles=path[0] != "solids")
        except SceneError as error:
            yield path, str(error)


def reactions_are_whole(
    reactions: Reactions, gas: s.Mixture, solids: Solids, origin: Origin
) -> Mistakes:
    """Check that reactions have equations that balance, and one law with what it
    needs.
    """
    if not reactions:
        return
    try:
        mechanism = mechanism_of(gas, origin.base)
    except SceneError as error:
        yield ("gas", "mechanism"), str(error)
        return
    tables = {**gas.species, **constituents_of(solids)}
    solids_react = any(table.composition is not None for table in solids.values())
    for name, table in reactions.items():
        yield from reaction_is_whole(
            name, table, lambda each: atoms_of(each, tables.get(each), mechanism)
        )
        law = find_law(name, table)
        if law is not None and law.of_solids and not solids_react:
            yield (
                ("reactions", name, "law"),
                f"{table.law} needs solids that react: give solids.NAME.composition",
            )


def orders_name_species(
    reactions: Reactions,
    gas: s.Mixture,
    boundary: Boundaries,
    solids: Solids,
    origin: Origin,
) -> Mistakes:
    """Check that orders refer to species of the scene."""
    if isinstance(gas, s.GasCantera):
        return  # any species of the mechanism
    species = species_named(gas, boundary, solids, reactions, origin)
    known = sorted(set().union(*species)) if species is not None else []
    for name, table in reactions.items() if species is not None else ():
        for each in table.orders or {}:
            if each not in known:
                yield (
                    ("reactions", name, "orders"),
                    f"there is no {each!r}; {nearest(each, known)}",
                )


def walls_pass_heat(
    boundary: Boundaries, heat: s.Heat | None, mesh: MeshLine, packed_bed: s.PackedBed
) -> Mistakes:
    """Check that a wall has a bed with temperatures and a diameter, and by name the
    bed beside it.
    """
    wall = boundary.get("wall")
    if wall is None:
        return
    if heat is None:
        yield (
            ("boundary", "wall"),
            "has no meaning without [heat]; add [heat], or remove it",
        )
    if mesh.diameter is None:
        yield (
            ("mesh", "diameter"),
            "missing; [boundary.wall] needs the diameter of the tube",
        )
    if named(wall.coefficient) and packed_bed.section is None:
        text = (
            "by name it is on the jump of temperature at the wall, which one "
            "dimension does not have"
        )
        advice = (
            "add [packed_bed.section], or give the coefficient to the mean "
            "temperature as a number"
        )
        yield ("boundary", "wall", "coefficient"), f"{text}; {advice}"


def sections_can_be_resolved(
    packed_bed: s.PackedBed,
    mesh: MeshLine,
    heat: s.Heat | None,
    closures: s.Closures,
    solids: Solids,
    boundary: Boundaries,
) -> Mistakes:
    """Check that a section has a size and something that passes across it."""
    section, path = packed_bed.section, ("packed_bed", "section")
    if section is None:
        return
    if mesh.diameter is None:
        yield ("mesh", "diameter"), "missing; the size of the section across the flow"
    gas = (section.conductivity_gas, section.dispersion)
    if heat is not None and all(
        value in (None, 0.0) for value in (*gas, section.conductivity_solids)
    ):
        yield (
            path,
            "no heat passes between the rings; give conductivity_gas, "
            "conductivity_solids or dispersion [W/m/K], such "
            'as dispersion = "vdi"; or remove [packed_bed.section] for a bed without '
            "differences across it",
        )
    two = heat is not None and s.films_of_heat(closures, solids)
    still = all(value in (None, 0.0) for value in gas)
    wall = boundary.get("wall")
    if (
        two
        and still
        and section.conductivity_solids
        and wall is not None
        and wall.coefficient is not None
    ):
        yield (
            path,
            "the wall exchanges heat with the gas, which conducts none to it across "
            "the bed; give conductivity_gas or "
            'dispersion [W/m/K], such as dispersion = "vdi"',
        )


def closures_exist(
    closures: s.Closures,
    packed_bed: s.PackedBed,
    solids: Solids,
    boundary: Boundaries,
    origin: Origin,
) -> Mistakes:
    """Check that closures are known, with their parameters, and get their arguments."""

    def bind(path: KeyPath, spec: Any, kind: str) -> object:
        direction = "transverse" if "section" in path else "axial"
        return bound(spec, kind, origin.base, direction)

    yield from unusable(places_of(closures, packed_bed, solids, boundary), bind)


def the_parameter_is_a_number(
    continuation: s.Continuation,
    gas: s.Mixture,
    closures: s.Closures,
    reactions: Reactions,
    boundary: Boundaries,
) -> Mistakes:
    """Check that the parameter of the continuation is a number of the scene that may
    vary.
    """
    tables = {
        "gas": gas,
        "closures": closures,
        "reactions": reactions,
        "boundary": boundary,
    }
    fixed = continuation.parameter.startswith("gas.species")
    examples = (
        "reactions.NAME.factor, boundary.left.gas.mass_flux, "
        "boundary.left.gas.temperature, boundary.wall.ambient"
    )
    yield from parameter_varies(continuation, tables, fixed, examples)


def phases_that_start_apart_have_own_temperatures(
    initial: s.Initial,
    solids: Solids,
    closures: s.Closures,
    heat: s.Heat | None,
    time: s.Time | None,
) -> Mistakes:
    """Require two temperatures and a run in time where phases start with their own."""
    for name in initial.solids:
        if name not in solids:
            text = f"no such solid phase; {nearest(name, list(solids))}"
            yield ("initial", "solids", name), text
    apart = [key for key in initial.temperatures if len(key) > 2]
    two = heat is not None and s.films_of_heat(closures, solids)
    if two and time is not None:
        return
    for key in apart:
        reason = (
            "a steady bed has one first guess"
            if time is None
            else "without closures.nusselt gas and solids have one temperature"
        )
        yield key, f"{reason}; give initial.temperature"


CHECKS: tuple[Check, ...] = (
    series_are_usable,
    times_are_in_order,
    a_cycle_changes_something,
    cells_can_follow,
    phases_that_start_apart_have_own_temperatures,
    initial_profiles_fit_the_bed,
    compositions_sum_to_one,
    stream_checks.boundaries_exist,
    stream_checks.one_end_gives_each_flow,
    the_parameter_is_a_number,
    reactions_are_whole,
    formulas_can_be_read,
    conversions_are_known,
    orders_name_species,
    phase_checks.steady_states_exist,
    phase_checks.particles_are_known,
    stream_checks.streams_have_a_state,
    curve_checks.curves_of_gases_are_positive,
    curve_checks.curves_of_solids_are_positive,
    walls_pass_heat,
    sections_can_be_resolved,
    adsorbed_gases_are_there,
    particles_can_adsorb,
    adsorbed_gases_react_by_their_concentrations,
    pellets_have_diffusivities,
    an_effectiveness_acts,
    pores_are_those_of_spheres,
    uptake_has_a_meaning,
    closures_exist,
    *phase_checks.CHECKS,
    positions_lie_in_the_bed,
)


def the_gas_conducts_once(
    closures: s.Closures, packed_bed: s.PackedBed, heat: s.Heat | None, origin: Origin
) -> Mistakes:
    """Look for a closure of the whole bed at rest beside the conductivity of its
    gas, along and across the bed.
    """
    if heat is None:
        return
    yield from gas_conducts_twice(("closures",), closures, origin.base)
    if packed_bed.section is not None:
        path = ("packed_bed", "section")
        yield from gas_conducts_twice(path, packed_bed.section, origin.base)


def heat_capacities_are_of_moles(solids: Mapping[str, s.Solid]) -> Mistakes:
    """Look for heat capacities that no solid has: those of constituents are per mole,
    and others per mass.
    """
    for phase, solid in solids.items():
        for name, data in solid.constituent.items():
            if data.heat_capacity is None:
                continue
            try:
                mass = data.molar_mass or molar_mass_of(atoms_of(name, data, None))
            except SceneError:
                continue
            by_mass = data.heat_capacity / mass
            if by_mass > LARGEST_CAPACITY:
                yield (
                    ("solids", phase, "constituent", name, "heat_capacity"),
                    f"in J/mol/K this is {by_mass:.4g} J/kg/K, more than any solid "
                    f'has: is "{data.heat_capacity:g} J/kg/K" meant? Multiply it by '
                    f"{mass:.4g} kg/mol",
                )


def ducts_are_affordable(packed_bed: s.PackedBed) -> Mistakes:
    """Look for a duct of so many columns that a step takes minutes."""
    section = packed_bed.section
    if section is None or section.shape != "duct" or section.rings <= MOST_OF_A_DUCT:
        return
    share = (section.rings / MOST_OF_A_DUCT) ** 4
    yield (
        ("packed_bed", "section", "rings"),
        f"a quarter of a duct has {section.rings**2} columns, whose equations take "
        f"{share:.2g} times the memory of rings = {MOST_OF_A_DUCT}, and minutes a "
        "step; contbed plan shows the memory",
    )


WARNINGS: tuple[Check, ...] = (
    the_gas_conducts_once,
    ducts_are_affordable,
    initial_profiles_reach_both_ends,
    heat_capacities_are_of_moles,
    an_effectiveness_is_that_of_a_first_order,
    phase_checks.wustite_is_no_pure_oxide,
)

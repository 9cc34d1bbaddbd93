"""Checks of a reacting bed: mistakes in a scene that remain although every single value is valid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.closures.binding import is_phase, named
from contbed.closures.fluid_conducts import fluid_conducts_twice
from contbed.closures.formula import parse_formula, require_names
from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions, names_in, require_sum
from contbed.materials.elements import elements_of
from contbed.reacting_bed import curve_checks, kind_checks
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import SUM, CompositionSeries, constant
from contbed.reacting_bed.inside_checks import (
    adsorbed_gases_are_there,
    adsorbed_gases_react_by_their_concentrations,
    kinds_have_diffusivities,
    particles_can_adsorb,
    pellets_have_diffusivities,
    uptake_has_a_meaning,
)
from contbed.reacting_bed.kind_checks import in_each_kind, of_all_kinds, of_one_kind
from contbed.reacting_bed.kinetics import SI_OF_BASIS
from contbed.reacting_bed.laws import NEEDS, known_laws
from contbed.reacting_bed.medium import GIVES, bound, places_of
from contbed.reacting_bed.schedule_checks import (
    a_cycle_changes_something,
    at_each_time,
    cells_can_follow,
    initial_profiles_fit_the_bed,
    initial_profiles_reach_both_ends,
    series_are_usable,
    times_are_in_order,
)
from contbed.reacting_bed.streams import gas_sign
from contbed.reacting_bed.substances import Equation, equations_of
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.scene.units import base_value, factor_and_offset
from contbed.scene.values import value_at

BALANCED = 1e-6  # atoms per mole of reaction within which an equation balances
Reactions = dict[str, s.Reaction]
Boundaries = dict[str, s.Boundary]


def compositions_sum_to_one(fluid: Any, solid: s.Solids | None, time: s.Time | None) -> Mistakes:
    """Check that fractions sum to one, where they are no amounts in moles."""
    gas = fluid.composition
    texts = gas.values if isinstance(gas, CompositionSeries) else [gas]
    given: list[tuple[KeyPath, str | None]] = [(("fluid", "composition"), text) for text in texts]
    if solid is not None:
        given.append((("solid", "composition"), solid.composition))
    if time is not None:
        given.append((("time", "initial_composition"), time.initial_composition))
    for path, text in given:
        if text is None:
            continue
        try:
            require_sum(text, SUM, in_moles=path[0] != "solid")
        except SceneError as error:
            yield path, str(error)


def equations_balance(reactions: Reactions, fluid: Any, solid: s.Solids | None) -> Mistakes:
    """Check that every reaction has an equation whose elements balance."""
    for name, table in reactions.items():
        path: KeyPath = ("reactions", name) if table.equation is None else ("reactions", name, "equation")
        try:
            equations = equations_of(name, table)
        except SceneError as error:
            if table.law is None or table.law in NEEDS:
                yield path, str(error)
            continue
        for equation in equations.values():
            try:
                left_over = imbalance(equation, fluid, solid)
            except SceneError as error:
                yield path, str(error)
                continue
            for element, atoms in left_over.items():
                verb = "makes" if atoms > 0 else "loses"
                yield path, f"{verb} {abs(atoms):.6g} atoms of {element} per mole of reaction; correct its coefficients"


def imbalance(equation: Equation, fluid: Any, solid: s.Solids | None) -> dict[str, float]:
    """Return the atoms of each element that an equation makes."""
    tables = {**fluid.species, **(solid.constituent if solid is not None else {})}
    total: dict[str, float] = {}
    for name, count in equation.stoichiometry.items():
        table = tables.get(name)
        atoms = dict(table.elements) if table is not None and table.elements else elements_of(name)
        for element, number in atoms.items():
            total[element] = total.get(element, 0.0) + count * number
    return {element: atoms for element, atoms in total.items() if abs(atoms) > BALANCED}


def laws_have_what_they_need(reactions: Reactions, solid: s.Solids | None) -> Mistakes:
    """Check that every reaction has one law, known and with its constants, or a formula."""
    for name, table in reactions.items():
        if table.rate is not None:
            if table.law is not None or table.A is not None:
                yield ("reactions", name, "rate"), "a formula is the whole rate; remove law, A, E and orders, or rate"
            continue
        law = table.law or "power"
        if law not in known_laws(name):
            yield ("reactions", name, "law"), f"unknown rate law; {nearest(law, known_laws(name))}"
            continue
        for key in NEEDS.get(law, ()):
            if getattr(table, key) is None:
                what = "the activation energy, 0 for a rate that does not depend on temperature" if key == "E" else key
                yield ("reactions", name, key), f"missing; the law {law} needs {what}"
        of_solids = law in ("grain", "grain_remaining", "shrinking_core") or law.startswith("three_interfaces")
        if of_solids and (solid is None or solid.composition is None):
            yield ("reactions", name, "law"), f"{law} needs solids that react: give solid.composition"
        if table.basis is not None and law not in ("power",):
            yield ("reactions", name, "basis"), f"has no meaning with the law {law}, whose rate has its own"


def formulas_can_be_read(reactions: Reactions, fluid: Any, solid: s.Solids | None) -> Mistakes:
    """Check formulas of rates: names, units of parameters and of the rate."""
    for name, table in reactions.items():
        if table.rate is None:
            continue
        path: KeyPath = ("reactions", name, "rate")
        for key, value in table.parameters.items():
            if isinstance(value, str):
                try:
                    base_value(value)
                except ValueError as error:
                    yield ("reactions", name, "parameters", key), str(error)
                    return
        try:
            formula = parse_formula(table.rate)
            gases, solids = _species_named(fluid, solid, reactions)
            known = {"T", "p", "R", "eps", "X", *table.parameters}
            known |= {f"{kind}_{gas}" for gas in gases for kind in "cxp"} | {f"n_{item}" for item in solids}
            require_names(formula, sorted(known))
        except SceneError as error:
            yield path, str(error)
            continue
        basis = table.basis or ("particle" if solids & set(_stoichiometry(name, table)) else "gas")
        if table.unit is not None and factor_and_offset(table.unit, SI_OF_BASIS[basis]) is None:
            wanted = SI_OF_BASIS[basis]
            yield ("reactions", name, "unit"), f"measures something else than {wanted}, the unit of a rate per {basis}"


def _stoichiometry(name: str, table: s.Reaction) -> Mapping[str, float]:
    try:
        return {k: v for e in equations_of(name, table).values() for k, v in e.stoichiometry.items()}
    except SceneError:
        return {}


def _species_named(fluid: Any, solid: s.Solids | None, reactions: Reactions) -> tuple[set[str], set[str]]:
    """Return names that may be gases, and those that may be solids."""
    try:
        gases = set(names_in(fluid.composition)) | set(fluid.species)
        solids = set() if solid is None else set(solid.constituent)
        if solid is not None and solid.composition is not None:
            solids |= set(mole_fractions(solid.composition))
    except SceneError:
        return set(), set()
    for name, table in reactions.items():
        gases |= set(_stoichiometry(name, table)) - solids
    return gases, solids


def orders_name_species(reactions: Reactions, fluid: Any, solid: s.Solids | None) -> Mistakes:
    """Check that orders refer to species of the scene."""
    gases, solids = _species_named(fluid, solid, reactions)
    if isinstance(fluid, s.GasCantera):
        return  # any species of the mechanism
    for name, table in reactions.items():
        for species in table.orders or {}:
            if species not in gases | solids:
                yield (
                    ("reactions", name, "orders"),
                    f"there is no {species!r}; {nearest(species, sorted(gases | solids))}",
                )


def steady_states_exist(
    reactions: Reactions, flow: s.Flow, solid: s.Solids | None, time: s.Time | None, see: See
) -> Mistakes:
    """Check that solids that react in a steady bed are supplied."""
    if flow.velocity_solid or solid is None or time is not None:
        return
    fed = set() if solid.composition is None else set(_fractions(solid.composition))
    for name, table in reactions.items():
        used = [key for key, n in _stoichiometry(name, table).items() if n < 0 and key in fed | set(solid.constituent)]
        if used:
            yield (
                ("reactions", name),
                f"takes {', '.join(used)} of particles at rest, which are used up: no steady state exists; give "
                f"them a velocity, {see('flow.velocity_solid')}, or add a [time] table",
            )


def _fractions(text: str) -> dict[str, float]:
    try:
        return mole_fractions(text)
    except SceneError:
        return {}


def particles_are_known(
    solid: s.Solids | None, flow: s.Flow, heat: s.Heat | None, time: s.Time | None, reactions: Reactions
) -> Mistakes:
    """Check that there are particles where something needs them, with density and heat capacity."""
    if flow.velocity_solid and solid is None:
        yield ("flow", "velocity_solid"), "there is no [solid]; give it, with composition, or density and heat_capacity"
    if solid is None:
        if heat is not None and time is not None:
            yield ("solid",), "missing; particles whose temperature changes hold heat: give density and heat_capacity"
        for name, table in reactions.items():
            if table.basis == "catalyst" or str(table.law).startswith("xu_froment"):
                yield (
                    ("reactions", name),
                    "its rate is per mass of catalyst; give [solid] with the density of particles",
                )
        return
    if solid.density is None:
        if solid.composition is None:
            yield ("solid", "density"), "missing; particles without composition need it"
        for name in _fractions(solid.composition or ""):
            data = solid.constituent.get(name)
            if data is None or data.density is None:
                yield ("solid", "density"), f"missing; or give solid.constituent.{name}.density"
                break
    stores = bool(flow.velocity_solid) or time is not None
    if heat is not None and stores and solid.composition is None and solid.heat_capacity is None:
        yield ("solid", "heat_capacity"), "missing; particles that move or whose temperature changes hold heat"
    if solid.composition is not None and solid.heat_capacity is not None:
        yield ("solid", "heat_capacity"), "has no meaning with a composition, whose constituents have theirs"


def streams_have_a_temperature(
    boundary: Boundaries, flow: s.Flow, heat: s.Heat | None, solid: s.Solids | None, see: See
) -> Mistakes:
    """Check that temperatures stand where streams enter, and nowhere else."""
    gas = gas_sign(flow)
    if gas == 0.0:
        key = next(name for name in ("mass_flux", "molar_flux", "velocity") if getattr(flow, name) is not None)
        yield ("flow", key), "no gas flows; give it a value other than 0"
        return
    entry = {"fluid": "left" if gas > 0 else "right"}
    moves = constant(flow.velocity_solid)
    if moves:
        entry["solid"] = "left" if moves > 0 else "right"
    for name, table in boundary.items():
        if name not in ("left", "right"):
            yield ("boundary", name), f"a line has no such end; {nearest(name, ['left', 'right'])}"
            continue
        for phase in ("fluid", "solid"):
            if getattr(table, phase) is not None and entry.get(phase) != name:
                key = "flow.velocity_solid" if phase == "solid" else "flow"
                yield ("boundary", name, phase), f"the {phase} does not enter here; see {see(key)}"
    for phase, name in entry.items():
        if (phase == "fluid" or heat is not None) and (name not in boundary or getattr(boundary[name], phase) is None):
            yield ("boundary",), f"the {phase} enters at '{name}': give boundary.{name}.{phase} = {{ inflow = ... }}"
    if heat is not None and heat.nusselt is None and moves * gas < 0:
        yield (
            ("heat", "nusselt"),
            "missing; gas and particles that move against each other have two temperatures",
        )


def heat_fits_the_bed(heat: s.Heat | None, wall: s.Wall | None, section: s.Section | None) -> Mistakes:
    """Check that a wall has a bed with temperatures, and a coefficient by name the bed beside the wall."""
    if wall is not None and heat is None:
        yield ("wall",), "has no meaning without [heat]; add [heat], or remove it"
    if wall is not None and named(wall.coefficient) and section is None:
        text = "by name it is on the jump of temperature at the wall, which one dimension does not have; add [section]"
        yield ("wall", "coefficient"), f"{text}, or give the coefficient to the mean temperature as a number"


def sections_can_be_resolved(section: s.Section | None, wall: s.Wall | None, heat: s.Heat | None) -> Mistakes:
    """Check that a section has a size and something that passes across it."""
    if section is None:
        return
    if wall is None:
        yield ("section",), "its size is not known; give [wall] with the diameter, and coefficient and ambient, or flux"
    across = (section.conductivity_fluid, section.conductivity_solid, section.dispersion)
    if heat is not None and all(value in (None, 0.0) for value in across):
        yield (
            ("section",),
            "no heat passes between the rings; give conductivity_fluid, conductivity_solid or dispersion [W/m/K], such "
            'as dispersion = "vdi"; or remove [section] for a bed without differences across it',
        )
    still = all(value in (None, 0.0) for value in (section.conductivity_fluid, section.dispersion))
    two = heat is not None and heat.nusselt is not None
    if two and still and section.conductivity_solid and wall is not None and wall.coefficient is not None:
        yield (
            ("section",),
            "the wall exchanges heat with the gas, which conducts none to it across the bed; give "
            'section.conductivity_fluid or section.dispersion [W/m/K], such as dispersion = "vdi"',
        )


def closures_exist(
    bed: s.Bed,
    heat: s.Heat | None,
    mass: s.Mass | None,
    section: s.Section | None,
    wall: s.Wall | None,
    origin: Origin,
) -> Mistakes:
    """Check that closures are known, with their parameters, and get their arguments."""
    for path, spec, kind in places_of(bed, heat, mass, section, wall):
        if named(spec) and not (kind == "conductivity" and is_phase(spec)):
            try:
                bound(spec, kind, origin.base, "transverse" if path[0] == "section" else "axial")
            except SceneError as error:
                yield path, str(error)


def positions_are_inside(mesh: Any, output: Any, see: See) -> Mistakes:
    """Check that profile positions lie in the bed."""
    for k, x in enumerate(output.positions):
        if not 0.0 <= x <= mesh.length:
            yield ("output", "positions", k), f"{x:g} m lies outside of the bed; see {see('mesh.length')}"


def the_parameter_is_a_number(
    continuation: s.Continuation | None,
    fluid: Any,
    flow: s.Flow,
    heat: s.Heat | None,
    mass: s.Mass | None,
    wall: s.Wall | None,
    reactions: Reactions,
    boundary: Boundaries,
) -> Mistakes:
    """Check that the parameter of the continuation is a number of the scene that may vary."""
    if continuation is None:
        return
    tables = {"fluid": fluid, "flow": flow, "heat": heat, "mass": mass, "wall": wall, "reactions": reactions}
    found = value_at(tables | {"boundary": boundary}, continuation.parameter)
    if not isinstance(found, float) or continuation.parameter.startswith("fluid.species"):
        yield (
            ("continuation", "parameter"),
            "no number of this scene can be varied under this key; allowed: keys such as reactions.NAME.factor, "
            "flow.mass_flux, boundary.left.fluid.inflow, wall.ambient",
        )
    elif found == continuation.to:
        yield ("continuation", "to"), "is the value that the scene has"
    elif continuation.back_to is not None and (continuation.back_to - found) * (continuation.to - found) > 0:
        yield ("continuation", "back_to"), f"lies on the same side of the value in the scene, {found:g}, as `to`"


CHECKS: tuple[Check, ...] = (
    series_are_usable,
    times_are_in_order,
    a_cycle_changes_something,
    cells_can_follow,
    initial_profiles_fit_the_bed,
    in_each_kind(compositions_sum_to_one),
    *(
        at_each_time(check)
        for check in (
            the_parameter_is_a_number,
            of_all_kinds(equations_balance),
            of_all_kinds(laws_have_what_they_need),
            of_all_kinds(formulas_can_be_read),
            of_all_kinds(orders_name_species),
            in_each_kind(steady_states_exist),
            in_each_kind(particles_are_known),
            of_all_kinds(streams_have_a_temperature),
            curve_checks.curves_of_gases_are_positive,
            in_each_kind(curve_checks.curves_of_solids_are_positive),
        )
    ),
    heat_fits_the_bed,
    sections_can_be_resolved,
    in_each_kind(adsorbed_gases_are_there),
    in_each_kind(particles_can_adsorb),
    in_each_kind(adsorbed_gases_react_by_their_concentrations),
    of_one_kind(pellets_have_diffusivities),
    kinds_have_diffusivities,
    in_each_kind(uptake_has_a_meaning),
    closures_exist,
    *kind_checks.CHECKS,
    positions_are_inside,
)


def the_fluid_conducts_once(heat: s.Heat | None, section: s.Section | None, origin: Origin) -> Mistakes:
    """Look for a closure of the whole bed at rest beside the conductivity of its gas, along and across the bed."""
    for name, table in (("heat", heat), ("section", section)):
        if table is not None:
            conductivities = table.conductivity_solid, table.conductivity_fluid
            yield from fluid_conducts_twice(name, *conductivities, GIVES["conductivity"], origin.base)


WARNINGS: tuple[Check, ...] = (the_fluid_conducts_once, initial_profiles_reach_both_ends)

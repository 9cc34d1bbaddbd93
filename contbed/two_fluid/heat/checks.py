"""What is wrong with the temperatures of a scene of two fluids although every single
value is right.
"""

from __future__ import annotations

from collections.abc import Iterator

from contbed.closures.binding import bind, named
from contbed.closures.packed_beds import RADIATES_TWICE, radiates_in
from contbed.errors import SceneError
from contbed.scene.checking import Mistakes
from contbed.scene.tables import Closure
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import GIVES, HEAT_KINDS, conducts
from contbed.two_fluid.conditions import (
    Boundary,
    Initial,
    Inlet,
    Outlet,
    Periodic,
    Symmetry,
    Wall,
    of_kind,
    places,
)
from contbed.two_fluid.heat.wall_laws import (
    EVERYWHERE,
    GAP,
    KIND,
    PENETRATION,
    is_layer,
    specs,
)
from contbed.two_fluid.heat.wall_laws import GIVES as WALL_GIVES

# [Pa] of an ideal gas; below, its mean free path is no longer small beside the
# particles
MIN_PRESSURE = 1e3
MAX_TEMPERATURE = 6000.0  # [K]; above, gases dissociate and no particle is solid


def heat_is_complete(
    heat: t.Heat | None,
    closures: t.Closures,
    two_fluid: t.TwoFluid,
    initial: Initial,
    boundary: dict[str, Boundary],
) -> Mistakes:
    """Check that temperatures are given where there is heat."""
    if heat is None:
        return
    if initial.gas.temperature is None:
        yield ("initial", "gas", "temperature"), "missing; [heat] needs it"
    for name, part in of_kind(boundary, Inlet).items():
        if part.gas.temperature is None:
            gas_enters = part.gas.velocity > 0
            if gas_enters or part.solid.temperature is None:
                yield (
                    ("boundary", name, "gas", "temperature"),
                    "missing; [heat] needs it",
                )
    for name, wall in of_kind(boundary, Wall).items():
        if (wall.coefficient is None) != (wall.ambient is None):
            key = "ambient" if wall.coefficient is None else "coefficient"
            yield ("boundary", name, key), "coefficient and ambient belong together"
        ways = [wall.temperature, wall.ambient, wall.heat_flux]
        if sum(way is not None for way in ways) > 1:
            yield (
                ("boundary", name),
                "give temperature, or coefficient and ambient, or heat_flux",
            )
        if wall.outside is None:
            if wall.emissivity is not None:
                yield (
                    ("boundary", name, "emissivity"),
                    "has no meaning without temperature or ambient",
                )
            continue
        choice = closures.wall_heat if wall.coefficient is None else wall.coefficient
        if is_layer(choice) and not conducts(closures, two_fluid):
            text = (
                "heats nothing without closures.conductivity_bed, "
                "two_fluid.conductivity_gas or _solids, or a number or closure for the "
                "coefficient"
            )
            key = "temperature" if wall.coefficient is None else "coefficient"
            yield ("boundary", name, key), text


def nothing_is_heated_without_heat(
    heat: t.Heat | None, gas: t.Gas, initial: Initial, boundary: dict[str, Boundary]
) -> Mistakes:
    """Check that temperatures are given only where they are solved, or fix the
    properties of the gas.
    """
    if heat is not None:
        return
    given = [path for path, T in _temperatures(initial, boundary) if T is not None]
    given += [
        ("boundary", name, key)
        for name in boundary
        for key in ("heat_flux", "coefficient", "emissivity")
        if getattr(boundary[name], key, None)
    ]
    for path in given:
        if "gas" not in path or gas.model == "constant":
            yield path, "has no meaning without [heat]"
    if gas.density_law != "constant":
        yield ("gas", "density_law"), "has no meaning without [heat]"


def properties_of_heat_are_given(
    heat: t.Heat | None,
    closures: t.Closures,
    gas: t.Gas,
    solids: dict[str, t.Solid],
    initial: Initial,
    boundary: dict[str, Boundary],
    origin: Origin,
) -> Mistakes:
    """Check that gas and particles have the properties that their temperatures need."""
    ((name, solid),) = solids.items()
    fluid = t.known_fluid(gas, initial, boundary, origin.base)
    if heat is None or fluid is None:
        return
    for key in ("heat_capacity", "conductivity"):
        if getattr(fluid, key) is None:
            yield ("gas", key), "missing; [heat] needs it"
    if solid.heat_capacity is None:
        yield ("solids", name, "heat_capacity"), "missing; [heat] needs it"
    by_name = isinstance(closures.conductivity_bed, str | Closure)
    if by_name and solid.conductivity is None:
        yield (
            ("solids", name, "conductivity"),
            "missing; closures.conductivity_bed needs it",
        )
    if gas.density_law == "ideal_gas" and gas.pressure < MIN_PRESSURE:
        yield (
            ("gas", "pressure"),
            f"absolute; below {MIN_PRESSURE:g} Pa a gas among particles is no continuum",
        )


def closures_of_heat_exist(
    heat: t.Heat | None,
    closures: t.Closures,
    two_fluid: t.TwoFluid,
    boundary: dict[str, Boundary],
    origin: Origin,
) -> Mistakes:
    """Check that the closures of heat exist and can be called."""
    if heat is None:
        return
    for key, kind in HEAT_KINDS.items():
        chosen = getattr(closures, key)
        if not named(chosen):
            continue
        try:
            bind(chosen, kind, GIVES[kind], origin.base)
        except SceneError as error:
            yield ("closures", key), str(error)
    yield from _wall_laws_exist(closures, boundary, origin)
    if (
        closures.conductivity_bed is not None
        and two_fluid.conductivity_gas + two_fluid.conductivity_solids > 0
    ):
        text = (
            "give either conductivity_bed, or two_fluid.conductivity_gas and "
            "conductivity_solids"
        )
        yield ("closures", "conductivity_bed"), text


def _wall_laws_exist(
    closures: t.Closures, boundary: dict[str, Boundary], origin: Origin
) -> Mistakes:
    """Check what walls have."""
    for place, spec in specs(closures, boundary).items():
        path = ("boundary", place, "coefficient")
        where = ("closures", "wall_heat") if place == EVERYWHERE else path
        if is_layer(spec):
            extra = spec.model_extra or {} if isinstance(spec, Closure) else {}
            gap = extra.get(GAP, 0.0)
            if set(extra) - {GAP}:
                yield (
                    where,
                    f'"{PENETRATION}" has one parameter, {GAP}; remove the others',
                )
            elif isinstance(gap, bool) or not isinstance(gap, int | float) or gap < 0.0:
                yield (
                    where,
                    f"{GAP} is the gap in particle diameters, a number of 0 or "
                    f"more; found {gap!r}",
                )
        elif named(spec):
            try:
                bind(spec, KIND, WALL_GIVES, origin.base)
            except SceneError as error:
                yield where, str(error)


def radiation_has_both_sides(
    heat: t.Heat | None,
    solids: dict[str, t.Solid],
    boundary: dict[str, Boundary],
) -> Mistakes:
    """Check that a wall that radiates has particles that do."""
    ((name, solid),) = solids.items()
    if heat is None:
        return
    for side, part in of_kind(boundary, Wall).items():
        if part.emissivity is not None and solid.emissivity is None:
            text = f"needs solids.{name}.emissivity"
            yield ("boundary", side, "emissivity"), text


def radiation_has_what_it_needs(
    heat: t.Heat | None,
    radiation: t.Radiation | None,
    solids: dict[str, t.Solid],
    closures: t.Closures,
    two_fluid: t.TwoFluid,
    origin: Origin,
) -> Mistakes:
    """Check that particles radiate among each other once, beside what they conduct."""
    if radiation is None:
        return
    if heat is None:
        yield ("radiation",), "has no meaning without [heat]"
        return
    ((name, solid),) = solids.items()
    if solid.emissivity is None:
        yield ("solids", name, "emissivity"), "missing; [radiation] needs it"
    if not conducts(closures, two_fluid):
        yield (
            ("radiation",),
            "needs closures.conductivity_bed, or two_fluid.conductivity_gas and "
            "_solids: a bed that radiates conducts as well",
        )
    if radiates_in(closures.conductivity_bed, origin.base):
        yield ("closures", "conductivity_bed"), RADIATES_TWICE


def temperatures_are_possible(
    gas: t.Gas, initial: Initial, boundary: dict[str, Boundary]
) -> Mistakes:
    """Check that no temperature is beyond what gas and particles bear."""
    reference: tuple[KeyPath, float | None] = (
        ("gas", "reference_temperature"),
        gas.reference_temperature,
    )
    for path, T in (reference, *_temperatures(initial, boundary)):
        if T is not None and T > MAX_TEMPERATURE:
            yield (
                path,
                f"above {MAX_TEMPERATURE:g} K gases dissociate and no particle is solid",
            )
    if (
        gas.reference_temperature is not None
        and gas.model == "constant"
        and gas.density_law == "constant"
    ):
        yield ("gas", "reference_temperature"), 'belongs to density_law = "ideal_gas"'


def _temperatures(
    initial: Initial, boundary: dict[str, Boundary]
) -> Iterator[tuple[KeyPath, float | None]]:
    """Yield the temperatures at the start and at boundaries with their paths."""
    for where, part in places(initial, boundary):
        if isinstance(part, Wall):
            yield (*where, "temperature"), part.temperature
            yield (*where, "ambient"), part.ambient
        elif not isinstance(part, Periodic | Outlet | Symmetry):
            yield (*where, "gas", "temperature"), part.gas.temperature
            for name, solid in part.solids.items():
                yield (*where, "solids", name, "temperature"), solid.temperature


HEAT_CHECKS = (
    heat_is_complete,
    nothing_is_heated_without_heat,
    properties_of_heat_are_given,
    closures_of_heat_exist,
    radiation_has_both_sides,
    radiation_has_what_it_needs,
    temperatures_are_possible,
)
"""Checks of temperatures, also where there is no [heat]."""

"""Checks of streams: exactly one end gives the flow of each phase, and temperatures
stand where streams enter.
"""

from __future__ import annotations

from contbed.course.schedule import boundaries_in_time
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.schedule import entering
from contbed.reacting_bed.streams import (
    INWARD,
    Boundaries,
    entry,
    flow_of_gas,
    gas_sign,
    given_velocity,
    velocity_of,
)
from contbed.scene.checking import Mistakes, See
from contbed.scene.names import nearest
from contbed.scene.toml_lines import Origin

WALL = "wall"


def boundaries_exist(boundary: Boundaries, solids: dict[str, s.Solid]) -> Mistakes:
    """Check the names of boundaries and of their solid phases, and that streams and
    heat pass the right ones.
    """
    for name, table in boundary.items():
        path = ("boundary", name)
        if name not in (*INWARD, WALL):
            yield path, f"a line has no such boundary; {nearest(name, [*INWARD, WALL])}"
            continue
        for key in ("coefficient", "heat_flux"):
            if name != WALL and getattr(table, key) is not None:
                yield (
                    (*path, key),
                    f"heat passes through [boundary.{WALL}] alone; give it there",
                )
        if name == WALL and (table.gas is not None or table.solids):
            yield path, "nothing enters through the wall; give streams at left or right"
        if name == WALL and table.coefficient is None and table.heat_flux is None:
            yield path, "give coefficient and ambient, or heat_flux"
        for phase in table.solids:
            if phase not in solids:
                yield (
                    (*path, "solids", phase),
                    f"no such solid phase; {nearest(phase, list(solids))}",
                )


def one_end_gives_each_flow(
    boundary: Boundaries, solids: dict[str, s.Solid], see: See
) -> Mistakes:
    """Check that one end gives the flow of the gas, and no more than one the
    velocity of each solid phase.
    """
    side, key = flow_of_gas(boundary)
    if not side:
        keys = ", ".join(s.FLOWS)
        yield (
            ("boundary",),
            f"the gas has no flow; give one of {keys} at the end where it enters, "
            "boundary.left.gas",
        )
    other = boundary.get("right")
    if side == "left" and other is not None and other.gas is not None:
        for second in s.FLOWS:
            if getattr(other.gas, second) is not None:
                text = (
                    f"{see(f'boundary.left.gas.{key}')} gives the flow of the gas "
                    "already; remove one"
                )
                yield ("boundary", "right", "gas", second), text
    for phase in solids:
        condition = None if other is None else other.solids.get(phase)
        if (
            given_velocity(boundary, phase)[0] == "left"
            and condition is not None
            and condition.velocity is not None
        ):
            text = (
                f"{see(f'boundary.left.solids.{phase}.velocity')} gives it already; "
                "remove one"
            )
            yield ("boundary", "right", "solids", phase, "velocity"), text


def streams_have_a_state(
    boundary: Boundaries,
    gas: s.Mixture,
    solids: dict[str, s.Solid],
    heat: s.Heat | None,
    closures: s.Closures,
    see: See,
    origin: Origin,
) -> Mistakes:
    """Check that temperature and composition stand where streams enter, and nowhere
    else, at each time of series.
    """
    if flow_of_gas(boundary)[0]:  # else `one_end_gives_each_flow` says so
        for now in boundaries_in_time(boundary, origin, entering):
            yield from _streams_have_a_state(
                now, gas, solids, heat is not None, closures, see
            )


def _streams_have_a_state(
    boundary: Boundaries,
    gas: s.Mixture,
    solids: dict[str, s.Solid],
    with_heat: bool,
    closures: s.Closures,
    see: See,
) -> Mistakes:
    side, key = flow_of_gas(boundary)
    sign = gas_sign(boundary)
    if sign == 0.0:
        yield (
            ("boundary", side, "gas", key),
            "no gas flows; give it a value other than 0",
        )
        return
    yield from _gas_has_a_state(
        boundary, gas, entry(sign), see(f"boundary.{side}.gas.{key}")
    )
    two, first = s.films_of_heat(closures, solids), 0.0
    for phase in solids:
        velocity = velocity_of(boundary, phase)
        yield from _solid_has_a_temperature(boundary, phase, velocity, with_heat)
        first = first or velocity
        given, _ = given_velocity(boundary, phase)
        if velocity * first < 0.0:
            path = ("boundary", given, "solids", phase, "velocity")
            yield (
                path,
                "solid phases that move go one way; let it enter where the others do",
            )
        if with_heat and not two and velocity * sign < 0.0:
            text = (
                "missing; gas and particles that move against each other have two "
                "temperatures"
            )
            yield ("closures", "nusselt"), text


def _gas_has_a_state(
    boundary: Boundaries, gas: s.Mixture, enters: str, where: str
) -> Mistakes:
    """Check temperature and composition of the gas at the end where it enters, and
    that the other end has none.
    """
    for name in INWARD:
        table = boundary[name].gas if name in boundary else None
        given = [
            key
            for key in ("temperature", "fixed_temperature", "composition")
            if getattr(table, key, None) is not None
        ]
        path = ("boundary", name, "gas")
        if name != enters:
            for key in given:
                yield (*path, key), f"the gas does not enter here; see {where}"
            continue
        if set(given) <= {"composition"}:
            yield path, f"the gas enters here: give boundary.{name}.gas.temperature"
        if gas.composition is None and "composition" not in given:
            yield (
                ("gas", "composition"),
                'missing; mole fractions of the gas that enters, "N2:0.79, O2:0.21"',
            )


def _solid_has_a_temperature(
    boundary: Boundaries, phase: str, velocity: float, needed: bool
) -> Mistakes:
    """Check that the temperature of a solid phase stands where it enters."""
    for name in INWARD:
        table = boundary[name].solids.get(phase) if name in boundary else None
        there = table is not None and table.temperature is not None
        path = ("boundary", name, "solids", phase, "temperature")
        enters = velocity * INWARD[name] > 0.0
        if there and not enters:
            yield (
                path,
                f"{phase} does not enter here; see "
                f"boundary.NAME.solids.{phase}.velocity",
            )
        if enters and needed and not there:
            yield path, "missing; particles enter here: give their value"

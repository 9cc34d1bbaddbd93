"""Checks of heat that passes the boundaries of a packed bed: a phase takes it, and
something fixes each temperature; see `scene.checking`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from contbed.packed_bed import scene as s
from contbed.packed_bed.schedule import PHASES
from contbed.packed_bed.schedule_checks import (
    NAMES,
    Boundaries,
)
from contbed.radiation.scene import Radiation
from contbed.scene.boundary import FLUXES, conditions_of
from contbed.scene.checking import Mistakes
from contbed.scene.mesh import SIDE, Mesh, MeshLine


def a_steady_temperature_is_determined(
    mesh: Mesh,
    solids: Mapping[str, s.Solid],
    heat: s.Heat | None,
    closures: s.Closures,
    time: s.Time | None,
    boundary: Boundaries,
    radiation: Radiation | None,
    region: Mapping[str, s.Region],
) -> Mistakes:
    """Check that something determines the temperature of a steady scene."""
    if heat is None or time is not None:
        return
    insulators = _insulators(closures, solids, radiation)
    tied = set()
    for side, conditions in boundary.items():
        takers = set(PHASES)
        if conditions.whole:
            beside = isinstance(mesh, MeshLine) and side == SIDE
            takers = _takers(beside, insulators)
        for phase in takers:
            condition = conditions.condition(phase)
            if condition is not None and condition.ties:
                tied.add(phase)
    if radiation is not None and (
        any(conditions.radiation for conditions in boundary.values())
        or any(part.tubes for part in region.values())
        or any(solid.temperature is not None for solid in solids.values())
    ):
        tied.add("solid")
    # Without exchange between the phases each needs a temperature of its own.
    loose = (
        [phase for phase in PHASES if phase not in tied]
        if closures.nusselt == 0 or not tied
        else []
    )
    if loose:
        yield (
            ("heat",),
            "the steady temperature of the "
            f"{' and the '.join(NAMES[phase] for phase in loose)} is undetermined: no "
            "boundary has temperature, fixed_temperature or coefficient, and no wall, "
            "tube or solid of given temperature radiates; give one, or a [time] table",
        )


def the_side_of_a_line_passes_heat(mesh: Mesh, boundary: Boundaries) -> Mistakes:
    """Check that the side of a line passes heat, and nothing else."""
    side = boundary.get(SIDE) if isinstance(mesh, MeshLine) else None
    if side is None:
        return
    for key in ("type", "radiation"):
        if getattr(side, key) is not None:
            yield ("boundary", SIDE, key), "has no meaning on the side of a line"
    heat_alone = (
        "only heat passes through the side of a line; give coefficient and ambient, or "
        "heat_flux"
    )
    if side.temperature is not None:
        yield ("boundary", SIDE, "temperature"), heat_alone
        return
    for path, _, condition in conditions_of({SIDE: side}):
        for key in ("velocity", "temperature", "fixed_temperature"):
            if getattr(condition, key) is not None:
                yield (*path, key), heat_alone


def temperatures_are_those_of_walls(mesh: Mesh, boundary: Boundaries) -> Mistakes:
    """Check that a temperature of the whole bed is that of a wall."""
    for name, table in boundary.items():
        beside = isinstance(mesh, MeshLine) and name == SIDE
        ends = table.type in (None, "inlet", "outlet")
        if table.temperature is not None and ends and not beside:
            yield (
                ("boundary", name, "temperature"),
                "that of a wall, which both phases take: give "
                'type = "wall" with it; gas.temperature is that of a stream',
            )


def phases_conduct_what_they_get(
    mesh: Mesh,
    closures: s.Closures,
    boundary: Boundaries,
    solids: Mapping[str, s.Solid],
    radiation: Radiation | None,
) -> Mistakes:
    """Check that heat enters no phase through a boundary from which that phase cannot
    conduct it: it would heat the cells at the boundary alone, whatever their size.
    """
    phases, insulators = {"gas", *solids}, _insulators(closures, solids, radiation)
    for path, phase, condition in conditions_of(boundary):
        side = str(path[1])
        takers = phases if boundary[side].passes_heat else {phase}
        beside = isinstance(mesh, MeshLine) and side == SIDE
        if beside or not takers <= set(insulators):
            continue
        zero = sorted({f"{insulators[taker]} = 0" for taker in takers})
        for key in FLUXES:
            if not getattr(condition, key):
                continue
            remedy = "give a phase a conductivity"
            if phases - set(insulators):
                table = "gas" if phase != "gas" else f"solids.{next(iter(solids))}"
                of_bed = key in s.Boundary.model_fields
                remedy = f"give boundary.{side}{'' if of_bed else '.' + table}.{key}"
            yield (
                (*path, key),
                f"no heat passes from '{side}' into the bed with "
                f"{' and '.join(zero)}; {remedy}",
            )


def _takers(beside_a_line: bool, insulators: Iterable[str]) -> set[str]:
    """Return the phases, "fluid" and "solid", that take heat given for the whole bed."""
    if beside_a_line:
        return {"fluid"}
    idle = {"fluid" if name == "gas" else "solid" for name in insulators}
    return set(PHASES) - idle


def _insulators(
    closures: s.Closures, solids: Mapping[str, s.Solid], radiation: Radiation | None
) -> dict[str, str]:
    """Return the phases that do not conduct, with the keys of their conductivities."""
    if closures.tortuosity is not None:
        return {}
    found = {}
    if closures.conductivity_gas == 0.0 and closures.dispersion is None:
        found["gas"] = "closures.conductivity_gas"
    as_conduction = radiation is not None and radiation.level == "rosseland"
    if closures.conductivity_solids == 0.0 and not as_conduction:
        found |= dict.fromkeys(solids, "closures.conductivity_solids")
    return found

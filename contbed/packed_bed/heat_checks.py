"""Checks of the heat of a packed bed: properties, exchange and intraparticle
conduction; see `scene.checking`.
"""

from __future__ import annotations

from collections.abc import Mapping

from contbed.closures.packed_beds import (
    RADIATES_TWICE,
    gas_conducts_twice,
    radiates_in,
)
from contbed.packed_bed import scene as s
from contbed.packed_bed.closures import OF_HEAT
from contbed.packed_bed.inlets import (
    given_velocity,
    key_of,
)
from contbed.packed_bed.schedule import PHASES
from contbed.packed_bed.schedule_checks import (
    Boundaries,
)
from contbed.radiation.scene import Radiation
from contbed.scene.boundary import conditions_of
from contbed.scene.checking import Mistakes
from contbed.scene.gas import Gas, GasConstant
from contbed.scene.toml_lines import Origin


def heat_has_its_properties(
    heat: s.Heat | None, solids: Mapping[str, s.Solid], gas: Gas, closures: s.Closures
) -> Mistakes:
    """Check that a scene with [heat] has the properties of its solid and its gas,
    and an exchange.
    """
    if heat is None:
        return
    needs = "missing; a scene with [heat] needs it"
    for name, solid in s.that_fill_the_bed(solids).items():
        for key in ("density", "heat_capacity", "conductivity"):
            if getattr(solid, key) is None:
                yield ("solids", name, key), needs
    if closures.nusselt is None:
        yield ("closures", "nusselt"), needs
    if isinstance(gas, GasConstant):
        for key in ("heat_capacity", "conductivity"):
            if getattr(gas, key) is None:
                yield ("gas", key), needs
            elif getattr(gas, key) == 0:
                yield ("gas", key), "is 0; a scene with [heat] needs it above 0"


def heat_alone_uses_temperatures(
    heat: s.Heat | None,
    closures: s.Closures,
    boundary: Boundaries,
    region: Mapping[str, s.Region],
    time: s.Time | None,
    gas: Gas,
) -> Mistakes:
    """Check that a scene without [heat] has no temperatures but that of the gas which
    enters, where the properties of the gas depend on it.
    """
    if heat is not None:
        return
    remedy = "has no meaning without a [heat] table"
    for key in OF_HEAT:
        if key in closures.model_fields_set:
            yield ("closures", key), remedy
    inlet = given_velocity(boundary, "fluid")
    varies = inlet is not None and not isinstance(gas, GasConstant)
    known = False
    for name, table in boundary.items():
        for phase in PHASES:
            condition = table.thermal(phase)
            if condition is None:
                continue
            if varies and phase == "fluid" and condition.temperature is not None:
                known = True
            else:
                at = ("temperature",) if condition.temperature is not None else ()
                yield key_of(boundary, name, phase, *at), remedy
    if varies and inlet is not None and not known:
        yield (
            ("boundary", inlet[0], "gas", "temperature"),
            "is missing: without [heat] the properties of the gas are taken at it",
        )
    for name in region:
        yield ("region", name), remedy
    if time is not None:
        yield ("time",), "needs a [heat] table: the flow is steady"


def the_inside_of_particles_fits_the_scene(
    solids: Mapping[str, s.Solid], heat: s.Heat | None, radiation: Radiation | None
) -> Mistakes:
    """Check that particles with an inside exchange heat, and that their mean
    temperature is not what radiates.
    """
    for name, solid in solids.items():
        if solid.inside is None:
            continue
        path = ("solids", name, "inside")
        if heat is None:
            yield (
                path,
                "intraparticle conduction needs the temperatures of two phases; add a "
                "[heat] table",
            )
        elif solid.inside.heat == "interior" and radiation is not None:
            yield (
                (*path, "heat"),
                "temperatures inside are not coupled with [radiation]; use "
                '"effective", a film coefficient corrected '
                "for conduction inside",
            )


def particles_that_melt_are_lumped(solids: Mapping[str, s.Solid]) -> Mistakes:
    """Look for intraparticle conduction where particles melt."""
    for name, solid in solids.items():
        inside = solid.inside
        if solid.melting is not None and inside is not None and inside.heat != "lumped":
            yield (
                ("solids", name, "inside", "heat"),
                "intraparticle conduction takes the heat capacity at the mean temperature of "
                "a particle; the front of melting within it is not resolved",
            )


def radiation_counts_once(
    closures: s.Closures,
    radiation: Radiation | None,
    boundary: Boundaries,
    origin: Origin,
) -> Mistakes:
    """Look for radiation beside a conductivity that contains it, and beside an
    emissivity towards surroundings of the same wall.
    """
    if radiation is None:
        return
    if radiates_in(closures.conductivity_solids, origin.base):
        yield ("closures", "conductivity_solids"), RADIATES_TWICE
    for path, _, condition in conditions_of(boundary):
        if condition.emissivity and boundary[str(path[1])].radiation is not None:
            yield (
                (*path, "emissivity"),
                f"radiates to its surroundings beside boundary.{path[1]}.radiation, the "
                "same heat a second time; give one",
            )


def the_gas_conducts_once(
    closures: s.Closures, heat: s.Heat | None, origin: Origin
) -> Mistakes:
    """Look for a closure of the whole bed at rest beside the conductivity of its
    gas.
    """
    if heat is not None:
        yield from gas_conducts_twice(("closures",), closures, origin.base)

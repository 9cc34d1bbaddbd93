"""Checks of the radiation of a scene: mistakes that remain although every single
value is valid.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.radiation.scene import RadiatingSolid, Radiation, Voidage
from contbed.radiation.thickness import rosseland_is_thick, two_flux_is_low
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.mesh import Mesh
from contbed.scene.mesh_checks import (
    boundaries_exist,
    mesh_file_exists,
    positions_lie_in_the_bed,
    the_line_of_profiles_fits_the_mesh,
)

# share of the solids that may be left out without a warning: rounding of what is
# written
MISSING_SOLIDS = 1e-3


def tubes_see_radiation(
    heat: Any | None, radiation: Radiation | None, region: Mapping[str, Any]
) -> Mistakes:
    """Check that tubes come with [heat] and a radiation level that includes them."""
    diffuse = radiation is not None and radiation.level in ("p1", "two_flux")
    for name, item in region.items():
        if item.tubes is not None and (heat is None or not diffuse):
            yield (
                ("region", name, "tubes"),
                "need [heat] and [radiation] with level p1 or two_flux",
            )


def radiation_is_complete(
    heat: Any | None,
    radiation: Radiation | None,
    solids: Mapping[str, RadiatingSolid],
    packed_bed: Any | None,
    boundary: Mapping[str, Any],
    mesh: Mesh,
    see: See,
) -> Mistakes:
    """Check that the optics are given once, and that level, mesh and boundaries suit
    each other.
    """
    if radiation is None:
        for name, conditions in boundary.items():
            if conditions.radiation is not None:
                yield (
                    ("boundary", name, "radiation"),
                    "has no meaning without a [radiation] table",
                )
        return
    ways = {
        "emissivity": any(solid.emissivity is not None for solid in solids.values()),
        "absorption": radiation.absorption is not None
        or radiation.scattering is not None,
    }
    if (count := sum(ways.values())) != 1:
        given = ", ".join(name for name, is_given in ways.items() if is_given) or "none"
        yield (
            ("radiation",),
            "give the optics once: emissivity of [solids.NAME], or absorption and "
            f"scattering; found {given}",
        )
    if ways["emissivity"]:
        for name, solid in solids.items():
            if solid.emissivity is None:
                yield (
                    ("solids", name, "emissivity"),
                    f"missing; all solids radiate; see {see('radiation')}",
                )
    if count == 1 and ways["emissivity"] and packed_bed is None:
        yield (
            ("packed_bed",),
            "this table is missing; the optics need its porosity; see "
            f"{see('radiation')}",
        )
    if radiation.level == "ordinates" and mesh.dimension > 1:
        yield (
            ("radiation", "level"),
            f"ordinates need a line; use p1; see {see('mesh.type')}",
        )
    if radiation.level == "ordinates" and heat is not None:
        yield (
            ("radiation", "level"),
            "ordinates solve [radiation] alone, as with [heat] the intensities of all "
            "directions would be unknowns of "
            "each step of Newton's method; use p1, and compare both levels without "
            f"[heat]; see {see('heat')}",
        )
    if radiation.level == "two_flux" and mesh.dimension > 1:
        yield (
            ("radiation", "level"),
            f"the two-flux method needs a line; use p1; see {see('mesh.type')}",
        )
    if radiation.level == "rosseland":
        if heat is None and not radiation.conductivity:
            yield (
                ("radiation", "level"),
                "rosseland is for a medium that conducts: [heat], or "
                "radiation.conductivity",
            )
        for name in walls_without_solid_temperature(heat, boundary):
            remedy = (
                f"give boundary.{name}.solids.NAME.fixed_temperature"
                if heat is not None
                else "give a temperature"
            )
            yield (
                ("boundary", name, "radiation"),
                f"with rosseland the solid has the temperature of a wall: {remedy}, or "
                "use p1; "
                f"see {see('radiation.level')}",
            )
        for name, solid in solids.items():
            if solid.temperature is not None:
                yield (
                    ("solids", name, "temperature"),
                    "with rosseland all particles have the temperature of the solid: "
                    "leave it out, or use p1; "
                    f"see {see('radiation.level')}",
                )
    for key in ("conductivity", "temperature"):
        if heat is not None and getattr(radiation, key) is not None:
            yield (
                ("radiation", key),
                f"is for a medium alone; [heat] already has it; see {see('heat')}",
            )
    if radiation.conductivity is not None and radiation.temperature is not None:
        yield (
            ("radiation", "temperature"),
            "is an unknown where the medium conducts, and cannot be given; "
            f"see {see('radiation.conductivity')}",
        )
    if (
        radiation.temperature is not None
        and ways["absorption"]
        and not radiation.absorption
    ):
        yield (
            ("radiation", "temperature"),
            "a medium that does not absorb does not emit: give radiation.absorption",
        )
    known = [radiation.temperature, *(solid.temperature for solid in solids.values())]
    if (
        heat is None
        and not any(known)
        and not any(b.radiation for b in boundary.values())
    ):
        yield (
            ("boundary",),
            "no boundary radiates and the medium has no temperature: nothing "
            "determines it",
        )


def solids_fit_together(
    solids: Mapping[str, RadiatingSolid],
) -> Mistakes:
    """Check that the shares of the solids do not exceed the whole."""
    filled = sum(solid.volume_share for solid in solids.values())
    if filled > 1.0 + 1e-9:
        yield (
            ("solids",),
            f"the volume shares sum to {filled:g}; those of all solids sum to 1",
        )


def optics_attenuate(radiation: Radiation | None) -> Mistakes:
    """Check that absorption or scattering stops rays, where these are given."""
    if radiation is None:
        return
    absorption, scattering = radiation.absorption, radiation.scattering
    given = absorption is not None or scattering is not None
    if given and not (absorption or 0.0) + (scattering or 0.0) * (
        1.0 - radiation.anisotropy
    ):
        yield (
            ("radiation",),
            "nothing stops a ray: absorption, or scattering with anisotropy < 1, must "
            "be above 0",
        )


def solids_sum_to_one(
    radiation: Radiation | None, solids: Mapping[str, RadiatingSolid]
) -> Mistakes:
    """Look for solids of the bed that no table describes."""
    if radiation is None or len(solids) < 2:
        return
    filled = sum(solid.volume_share for solid in solids.values())
    if filled < 1.0 - MISSING_SOLIDS:
        yield (
            ("solids",),
            f"the volume shares sum to {filled:g}: the other solids neither absorb nor "
            "scatter",
        )


def two_flux_scatters_evenly(radiation: Radiation | None, see: See) -> Mistakes:
    """Look for a mean cosine of scattering that the level does not take."""
    if radiation is not None and radiation.level == "two_flux" and radiation.anisotropy:
        yield (
            ("radiation", "anisotropy"),
            "is ignored: the two-flux method scatters half of the light forward; p1 "
            "takes it, and ordinates do; "
            f"see {see('radiation.level')}",
        )


def walls_without_solid_temperature(
    heat: Any, boundary: Mapping[str, Any]
) -> list[str]:
    """Return the radiating boundaries on which the solid does not have the wall's
    temperature.
    """
    found = []
    for name, table in boundary.items():
        wall = table.radiation
        if wall is None:
            continue
        solid = None if heat is None else table.thermal("solid")
        touched = heat is None or (
            solid is not None and solid.fixed_temperature == wall.temperature
        )
        if wall.temperature is None or not touched:
            found.append(name)
    return found


def a_medium_radiates(
    radiation: Radiation,
    solids: Mapping[str, RadiatingSolid],
    packed_bed: Voidage | None,
    boundary: Mapping[str, Any],
    mesh: Mesh,
    see: See,
) -> Mistakes:
    """Check the optics of a stand-alone medium."""
    yield from radiation_is_complete(
        None, radiation, solids, packed_bed, boundary, mesh, see
    )


CHECKS: tuple[Check, ...] = (
    a_medium_radiates,
    solids_fit_together,
    optics_attenuate,
    boundaries_exist,
    mesh_file_exists,
    positions_lie_in_the_bed,
    the_line_of_profiles_fits_the_mesh,
)
WARNINGS: tuple[Check, ...] = (
    solids_sum_to_one,
    two_flux_scatters_evenly,
    rosseland_is_thick,
    two_flux_is_low,
)

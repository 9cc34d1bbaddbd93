"""Checks of tubes and of radiation in a bubbling bed; see `scene.checking`."""

from __future__ import annotations

from collections.abc import Mapping

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.closures import (
    FREEBOARD,
)
from contbed.bubbling_bed.solids import Solid
from contbed.bubbling_bed.tables import BubblingBed, FreeboardSurface, Surface
from contbed.radiation.thickness import carries_less
from contbed.scene.checking import Mistakes, See
from contbed.scene.toml_lines import KeyPath

LEAST_TUBE = 0.0127  # [m] outside, half an inch: smaller ones are not used in beds


DENSEST = 0.9069  # share of a section that circles fill, pi/(2 sqrt 3)


Solids = Mapping[str, Solid]


def radiation_has_its_emissivities(
    radiation: b.Radiation, solids: Solids, see: See
) -> Mistakes:
    """Check that radiating particles have an emissivity, and the keys of the level."""
    level = radiation.level
    if level == "none":
        return
    for name, item in solids.items():
        if item.volume_share > 0 and item.emissivity is None:
            text = f"missing; radiation needs it; see {see('radiation')}"
            yield ("solids", name, "emissivity"), text
    if level in ("paper", "pairwise") and radiation.correction == "close_packed":
        text = (
            "exchange at one place is that of the surfaces: independent, or leave "
            "it out"
        )
        yield ("radiation", "correction"), text
    if level == "two_flux" and radiation.anisotropy:
        text = f"the two-flux method ignores it; see {see('radiation.level')}"
        yield ("radiation", "anisotropy"), text


def particles_pass_between_the_tubes(
    bubbling_bed: BubblingBed, solids: Solids, see: See
) -> Mistakes:
    """Check that particles are smaller than 2 A/p.

    That is the width of slits whose walls have the surface of the tubes.
    """
    tubes, section = bubbling_bed.tubes, bubbling_bed.section
    diameters = [item.diameter for item in solids.values() if item.volume_share > 0]
    largest = max(diameters, default=0.0)
    if tubes is not None and 2.0 * section < largest * tubes.perimeter:
        yield (
            ("bubbling_bed", "tubes", "perimeter"),
            f"leaves {2.0 * section / tubes.perimeter:.3g} m between surfaces, less "
            f"than particles of {largest:.3g} m; allowed: below "
            f"{2.0 * section / largest:.4g} m, see {see('bubbling_bed.section')}",
        )


def tubes_fit_in_the_section(bubbling_bed: BubblingBed, see: See) -> Mistakes:
    """Look for more surface than tubes have that touch each other, even those of the
    least diameter.
    """
    section, above = bubbling_bed.section, bubbling_bed.freeboard
    most = 4.0 * DENSEST / LEAST_TUBE * section
    given: list[tuple[KeyPath, Surface | FreeboardSurface | None]] = [
        (("bubbling_bed", "tubes"), bubbling_bed.tubes),
        ((*FREEBOARD, "tubes"), None if above is None else above.tubes),
    ]
    for path, table in given:
        if table is not None and table.perimeter > most:
            yield (
                (*path, "perimeter"),
                f"tubes of {1e3 * LEAST_TUBE:g} mm that touch each other have "
                f"{most:.4g} m in {section:g} m2; give less, or see "
                f"{see('bubbling_bed.section')}",
            )


def two_flux_is_low(
    radiation: b.Radiation, solids: Solids, bubbling_bed: BubblingBed
) -> Mistakes:
    """Look for beds along whose height the two-flux method carries too little heat."""
    if radiation.level != "two_flux":
        return
    from contbed.bubbling_bed.scene_coefficients import optics_of

    found = optics_of(radiation, solids, bubbling_bed.solids_fraction)
    tau = float(found.extinction) * bubbling_bed.height
    yield from carries_less(tau, tau, "p1")

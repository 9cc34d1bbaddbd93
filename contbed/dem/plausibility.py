"""Conductivities that no bed of such particles and gas can have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from contbed.closures.conductivity_bounds import (
    conductivity_hashin_shtrikman_lower,
    conductivity_hashin_shtrikman_upper,
)
from contbed.dem.heat import VIEW, Paths

# porosities of packings scatter by as much, and the bounds with them
MARGIN = 0.01
# share of radiation in the heat above which a run warns of its error
MUCH_RADIATION = 0.25


def judge(
    found: Mapping[float, float], eps: float, paths: Paths, equal: bool
) -> list[str]:
    """Warn of conduction outside of the bounds of Hashin and Shtrikman, which hold for
    every isotropic bed.

    `found` has the conductivity of the bed by that of the particles, without radiation
    and both over that of the gas; `equal` is whether all spheres have one
    radius.
    """
    outside = []
    for ratio, k in found.items():
        low = float(conductivity_hashin_shtrikman_lower(1.0, ratio, eps))
        high = float(conductivity_hashin_shtrikman_upper(1.0, ratio, eps))
        if not low * (1.0 - MARGIN) <= k <= high * (1.0 + MARGIN):
            outside.append(f"{k:.4g} at {ratio:.4g} ({low:.4g} to {high:.4g})")
    if not outside:
        return []
    advice = "a correlation such as conductivity_zehner_schluender holds there"
    if paths == "cones":
        others = [f'"{name}"' for name in get_args(Paths) if name != paths]
        advice = f"try {' or '.join(others)}"
        if not equal:
            advice += ", which need equal spheres: they show by how much"
    return [
        "k_eff/k_fluid by conduction is outside of the Hashin-Shtrikman bounds of any "
        f"isotropic bed of this porosity: {', '.join(outside)} times k_fluid; "
        f'particles.paths = "{paths}" misses there, {advice}'
    ]


def of_radiation(share: float) -> list[str]:
    """Warn of the error of radiation where it is much of the heat."""
    if share < MUCH_RADIATION:
        return []
    return [
        f"radiation is {share:.0%} of the heat: particles exchange it with neighbours "
        f"within {VIEW:g} diameters by one mean view, which is some 25 % off for lattices of "
        "black spheres, above or below; compare "
        "conductivity_zehner_bauer_schluender or a measurement"
    ]

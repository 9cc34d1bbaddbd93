"""Grains throughout a porous particle that react at their surface.

    r = 3 n0 a k c^m (1 - X)^(2/3)/(n_g r_g)      per volume of particles

`grain_remaining` has another factor 1 - X. n0 moles of fresh solid per volume, n_g per
volume of a grain of radius r_g, a the share of its surface that reacts.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import Case, RateLaw, powers
from contbed.closures.formula import odd_power
from contbed.errors import SceneError


def _grain(case: Case, exponent: float) -> Rate:
    table = case.table
    if case.equation.reversible:
        raise SceneError(
            f"reactions.{case.name}: grains have no reverse reaction: write '->', or "
            "take the law shrinking_core or power"
        )
    per_area = float(table.molar_density or 1.0) * float(table.grain_radius or 1.0)
    scale = 3.0 * table.active_share / per_area
    constant = case.constant("mol/m**2/s", sum(case.orders.values()))

    def rate(at: Local) -> Any:
        fresh = case.fresh(at)
        left = at.n[case.solid] / fresh
        return (
            constant(at.T)
            * powers(at, case.orders, case.basis)
            * odd_power(left, exponent, at.small.solids)
            * fresh
            * (scale / at.solids)
        )

    return rate


LAWS = {
    name: RateLaw(
        partial(_grain, exponent=exponent),
        needs=("A", "E", "grain_radius", "molar_density"),
        takes=("b", "orders", "active_share"),
        of_solids=True,
    )
    for name, exponent in (("grain", 2.0 / 3.0), ("grain_remaining", 2.0 / 3.0 + 1.0))
}

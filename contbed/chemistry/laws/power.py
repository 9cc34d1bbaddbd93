"""Concentrations to a power, with the constants of the scene.

r = A T^b exp(-E/(R T)) prod_i c_i^(n_i) (1 - Q/K)      K of reversible reactions alone
"""

from __future__ import annotations

from typing import Any

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import SI_OF_BASIS, Case, RateLaw, powers
from contbed.errors import SceneError


def _power(case: Case) -> Rate:
    left = {name: -n for name, n in case.gases.items() if n < 0}
    right = {name: n for name, n in case.gases.items() if n > 0}
    elementary = case.orders == left
    given = case.orders or case.table.orders is not None
    if not (given or case.equation.reversible):
        solids = [name for name in case.equation.left if name in case.species.solids]
        first = " or ".join(f'{{ "{name}" = 1.0 }}' for name in solids)
        raise SceneError(
            f"reactions.{case.name}.orders: missing, as no gas is on the left: give "
            f"{first} for a rate of first order in what is left of it, or 0.0 for one "
            "that does not depend on it"
        )
    constant = case.constant(SI_OF_BASIS[case.basis], sum(case.orders.values()))

    def rate(at: Local) -> Any:
        if case.equation.reversible and not elementary:
            traced = case.with_traces(at)
            forward = powers(traced, case.orders, case.basis)
            return constant(at.T) * forward * (1.0 - case.quotient(traced))
        forward = powers(at, case.orders, case.basis)
        if case.equation.reversible:
            back = powers(at, right, case.basis) / case.equilibrium_constant(at.T)
            return constant(at.T) * (forward - back)
        return constant(at.T) * forward

    return rate


LAWS = {
    "power": RateLaw(
        _power,
        needs=("A", "E"),
        takes=("b", "orders", "basis", "equilibrium_factor", "diffusivity"),
    )
}

"""Concentrations to a power, with the constants of the scene.

r = A T^b exp(-E/(R T)) prod_i c_i^(n_i) (1 - Q/K)      K of reversible reactions alone

A rate that runs back ends with each solid that it takes and whose amount n is not among
the orders: it has the factor n/sqrt(n^2 + s^2), s = 0.002 of all solids.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import SI_OF_BASIS, Case, RateLaw, powers
from contbed.errors import SceneError

# of all solids, over which a rate that runs back ends with what it takes; Newton's method
# finds no state with much shorter ones
LEAST_TAKEN = 2e-3


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
    ends = [
        name
        for name, n in case.equation.stoichiometry.items()
        if n > 0 and name in case.species.solids and name not in case.orders
    ]
    constant = case.constant(SI_OF_BASIS[case.basis], sum(case.orders.values()))

    def rate(at: Local) -> Any:
        if case.equation.reversible and not elementary:
            traced = case.with_traces(at)
            forward = powers(traced, case.orders, case.basis)
            net = constant(at.T) * forward * (1.0 - case.quotient(traced))
            return _with_ends(net, ends, at)
        forward = powers(at, case.orders, case.basis)
        if case.equation.reversible:
            back = powers(at, right, case.basis) / case.equilibrium_constant(at.T)
            return _with_ends(constant(at.T) * (forward - back), ends, at)
        return constant(at.T) * forward

    return rate


def _with_ends(net: Any, ends: list[str], at: Local) -> Any:
    """Return a net rate that ends, where it runs back, with the solids `ends`."""
    if not ends:
        return net
    share: Any = 1.0
    for name in ends:
        n, small = at.n[name], LEAST_TAKEN * at.all_solids
        share = share * n * (n * n + small * small) ** -0.5
    return np.maximum(net, 0.0) + np.minimum(net, 0.0) * share


LAWS = {
    "power": RateLaw(
        _power,
        needs=("A", "E"),
        takes=("b", "orders", "basis", "equilibrium_factor", "diffusivity"),
    )
}

"""Rates by a formula that a scene writes: [reactions.NAME] rate = "k*c_A/(1 + K*p_B)".

A formula is the whole rate. That of a reversible reaction of gases may name Q_over_K,
the ratio of products to reactants over that of equilibrium, by thermodynamics:
"k*p_CO*p_H2*(1 - Q_over_K)" ends at equilibrium.
"""

from __future__ import annotations

from typing import Any

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import SI_OF_BASIS, Case, RateLaw
from contbed.chemistry.thermo import R_GAS
from contbed.closures.formula import Formula, parse_formula
from contbed.scene.reactions import Reaction

QUOTIENT = "Q_over_K"


def formula_values(at: Local, left: Any) -> dict[str, Any]:
    """Return the values that a formula may name."""
    values: dict[str, Any] = {
        "T": at.T,
        "p": at.p,
        "R": R_GAS,
        "eps": at.eps,
        "X": 1.0 - left,
    }
    values |= {f"c_{name}": c for name, c in at.c.items()}
    values |= {f"x_{name}": x for name, x in at.x.items()}
    values |= {f"p_{name}": x * at.p for name, x in at.x.items()}
    return values | {f"n_{name}": n for name, n in at.n.items()}


def sizes_of(at: Local) -> dict[str, Any]:
    """Return the largest values of what a formula may name: those of one gas alone,
    and of one solid.
    """
    molar, solids = at.all_gases, at.all_solids
    of_gas = {
        f"{kind}_{name}": size
        for name in at.c
        for kind, size in (("c", molar), ("x", 1.0), ("p", at.p))
    }
    return {"X": 0.0, QUOTIENT: 1.0, **of_gas, **{f"n_{name}": solids for name in at.n}}


def formula_of(table: Reaction, basis: str) -> tuple[Formula, dict[str, float], float]:
    """Return the formula of a rate, its parameters in SI and the factor of its unit."""
    from contbed.scene.units import base_value, factor_and_offset

    parameters = {
        key: value if isinstance(value, float) else base_value(value)
        for key, value in table.parameters.items()
    }
    factor = 1.0
    if table.unit is not None:
        found = factor_and_offset(table.unit, SI_OF_BASIS[basis])
        factor = 1.0 if found is None else found[0]
    return parse_formula(str(table.rate)), parameters, factor


def _rate(case: Case) -> Rate:
    formula, parameters, factor = formula_of(case.table, case.basis)
    moles = case.equation.stoichiometry
    converts = "X" in formula.names and any(
        n < 0 and name in case.species.solids for name, n in moles.items()
    )

    def rate(at: Local) -> Any:
        if QUOTIENT in formula.names:
            at = case.with_traces(at)
        left = at.n[case.solid] / case.fresh(at) if converts else 1.0
        values = {**formula_values(at, left), **parameters}
        if QUOTIENT in formula.names:
            values[QUOTIENT] = case.quotient(at)
        sizes = {**values, **sizes_of(at)} if at.small.amounts else None
        return formula(values, at.small.amounts, sizes) * factor

    return rate


FORMULA = RateLaw(
    _rate,
    needs=("rate",),
    takes=("unit", "parameters", "basis", "equilibrium_factor", "diffusivity"),
)

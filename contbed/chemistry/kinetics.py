"""Rates of the reactions of a scene at a point of the bed, in moles of reaction per
volume of bed and time.

`local.Local` is the state that they see. Laws with concentrations to a power, grains
and shrinking cores take constants of the scene; others carry their own. K of a
reversible reaction comes from the thermodynamics of its species.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry import laws_of_gases as r
from contbed.chemistry import reforming, shrinking_core, three_interfaces
from contbed.chemistry.effectiveness import effectiveness_of
from contbed.chemistry.equation import Equation
from contbed.chemistry.laws import IRON, STAGED, equations_of
from contbed.chemistry.laws_of_gases import LAWS
from contbed.chemistry.local import Local
from contbed.chemistry.species import Species
from contbed.chemistry.thermo import R_GAS, Equilibrium
from contbed.closures.formula import TINY, Formula, odd_power, parse_formula, power
from contbed.scene.reactions import Reaction as ReactionTable

BAR = 1e5
SI_OF_BASIS = {
    "catalyst": "mol/kg/s",
    "gas": "mol/m**3/s",
    "particle": "mol/m**3/s",
    "bed": "mol/m**3/s",
}


Rate = Callable[[Local], Any]


@dataclass(frozen=True)
class Reaction:
    """One reaction. `site` is "gas" or "particle"; `own_film` says that the law
    contains the film around particles.

    `step` is None where `rate` gives the rate; else `rate` gives those of all steps of
    a law at once, as they share their work, and this is the step that is meant.
    """

    name: str
    equation: Equation
    rate: Rate
    site: str
    own_film: bool = False
    step: int | None = None
    phase: str | None = None  # solid phase in which it runs
    alone: str | None = None  # name without the phase, where it runs in several
    gases: frozenset[str] = frozenset()  # of its equation and of its rate
    has_roots: bool = False  # whether orders or a formula have powers between 0 and 1

    @property
    def key(self) -> str:
        """Name without the solid phase: the key in [reactions] of a reaction without
        stages.
        """
        return self.alone or self.name

    @property
    def stoichiometry(self) -> Mapping[str, float]:
        """Moles made of each species per mole of reaction."""
        return self.equation.stoichiometry


def reactions_of(
    tables: Mapping[str, ReactionTable], species: Species, with_effectiveness: bool
) -> list[Reaction]:
    """Return the reactions of tables in one place; one with stages gives one for each.

    `with_effectiveness` says that particles with a diffusivity have one by their Thiele
    modulus.
    """
    out: list[Reaction] = []
    for name, table in tables.items():
        equations = equations_of(name, table)
        if table.law in STAGED:
            out += _stages(table, equations)
            continue
        ((_, equation),) = equations.items()
        out.append(_one(name, table, equation, species, with_effectiveness))
    return out


def site_of(table: ReactionTable, equation: Equation, species: Species) -> str:
    """Return where a reaction runs, as the basis of its rate."""
    if table.basis is not None:
        return table.basis
    if table.law is not None and table.law in reforming.REACTIONS:
        return "catalyst"
    return (
        "particle"
        if any(name in species.solids for name in equation.stoichiometry)
        else "gas"
    )


def _one(
    name: str,
    table: ReactionTable,
    equation: Equation,
    species: Species,
    with_effectiveness: bool,
) -> Reaction:
    basis = site_of(table, equation, species)
    used = {**equation.stoichiometry, **(table.orders or {})}
    site = (
        "gas"
        if basis == "gas"
        or (basis == "bed" and not any(k in species.solids for k in used))
        else "particle"
    )
    gases = frozenset(species.gases)
    equilibrium = Equilibrium(
        equation.stoichiometry, species.all, gases, table.equilibrium_factor
    )
    rate: Rate
    own_film = False
    if table.rate is not None:
        rate = _formula(table, equation, basis, species)
    elif table.law in reforming.REACTIONS:
        rate = _reforming(str(table.law), equilibrium)
    elif table.law in ("grain", "grain_remaining"):
        rate = _grain(table, equation, species)
    elif table.law == "shrinking_core":
        rate, own_film = _shrinking_core(table, equation, equilibrium, species), True
    elif table.law not in (None, "power"):
        rate = _named(name, table, equation, equilibrium)
    else:
        rate = _power(table, equation, equilibrium, species)
    if with_effectiveness and table.diffusivity and not own_film and site == "particle":
        rate = _slowed(rate, table, equation, species, basis)
    scaled = _per_bed(rate, basis, table.factor)
    roots = any(0.0 < n < 1.0 for n in (table.orders or {}).values())
    if table.rate is not None:
        formula, parameters, _ = formula_of(table, basis)
        roots = formula.has_roots(parameters)
    return Reaction(
        name,
        equation,
        scaled,
        site,
        own_film,
        gases=_gases_of(table, used, gases),
        has_roots=roots,
    )


def _gases_of(
    table: ReactionTable, used: Mapping[str, float], gases: frozenset[str]
) -> frozenset[str]:
    """Return the gases of an equation, of its orders and of its rate."""
    found = set(used)
    if table.law in reforming.REACTIONS:
        found |= set(reforming.GASES)
    if table.rate is not None:
        found |= {
            name.partition("_")[2]
            for name in parse_formula(table.rate).names
            if name[:2] in ("c_", "p_", "x_")
        }
    return gases & found


def _per_bed(rate: Rate, basis: str, factor: float) -> Rate:
    """Return a rate per volume of bed from one per basis."""

    def scaled(at: Local) -> Any:
        volume = {
            "gas": at.eps,
            "particle": at.solids,
            "bed": 1.0,
            "catalyst": at.catalyst,
        }[basis]
        return rate(at) * (factor * volume)

    return scaled


def constant(table: ReactionTable, T: Any) -> Any:
    """Return k = A T^b exp(-E/(R T))."""
    k = (
        (table.A or 0.0) * np.exp(-(table.E or 0.0) / R_GAS / T)
        if table.E
        else (table.A or 0.0)
    )
    return k * T**table.b if table.b else k


def orders_of(
    table: ReactionTable, equation: Equation, species: Species
) -> dict[str, float]:
    """Return the orders of a reaction in its species; absent: the coefficients of
    gases on the left.
    """
    if table.orders is not None:
        return dict(table.orders)
    return {
        name: -count
        for name, count in equation.stoichiometry.items()
        if count < 0 and name in species.gases
    }


def _amount(at: Local, name: str) -> Any:
    return at.c[name] if name in at.c else at.n[name]


def _wholes(at: Local) -> tuple[Any, Any]:
    """Return the concentration of all gases [mol/m3] and the moles of all
    solids [mol/m3 bed].
    """
    return at.p / (R_GAS * at.T), sum(at.n.values())


def _powers(at: Local, orders: Mapping[str, float]) -> Any:
    """Return the product of amounts to their orders, at most one of the factors may
    be negative.
    """
    small = {}
    if at.small.amounts:
        gas, solids = _wholes(at)
        whole = {
            name: gas if name in at.c else solids
            for name, n in orders.items()
            if 0.0 < n < 1.0
        }
        small = {name: at.small.amounts * amount for name, amount in whole.items()}
    return r.product(
        [
            odd_power(_amount(at, name), n, small.get(name, TINY))
            if n != 1.0
            else _amount(at, name)
            for name, n in orders.items()
        ]
    )


def _power(
    table: ReactionTable, equation: Equation, equilibrium: Equilibrium, species: Species
) -> Rate:
    orders = orders_of(table, equation, species)
    gases = {
        name: n for name, n in equation.stoichiometry.items() if name in species.gases
    }
    left = {name: -n for name, n in gases.items() if n < 0}
    right = {name: n for name, n in gases.items() if n > 0}
    elementary = orders == left

    def rate(at: Local) -> Any:
        k = constant(table, at.T)
        forward = _powers(at, orders)
        if not equation.reversible:
            return k * forward
        moles = sum(gases.values())
        # in concentrations
        K = np.exp(equilibrium.ln_K(at.T)) * (BAR / (R_GAS * at.T)) ** moles
        if elementary:
            return k * (forward - _powers(at, right) / K)
        made: Any = 1.0
        for name, n in gases.items():
            made = made * power(at.c[name], n)
        return k * forward * (1.0 - made / K)

    return rate


def _named(
    name: str, table: ReactionTable, equation: Equation, equilibrium: Equilibrium
) -> Rate:
    law = LAWS[name][str(table.law)]

    def rate(at: Local) -> Any:
        small = r.SMALL * at.p / (R_GAS * at.T)
        forward = law.rate(at.T, at.c, small)
        if not law.reversible:
            return forward
        moles = sum(equation.stoichiometry.values())
        K = np.exp(equilibrium.ln_K(at.T)) * (BAR / (R_GAS * at.T)) ** moles
        back = r.product(
            [
                at.c[key] ** n if n != 1.0 else at.c[key]
                for key, n in equation.stoichiometry.items()
                if n > 0
            ]
        )
        return forward - law.constant(at.T) * back / K

    return rate


def _reforming(name: str, equilibrium: Equilibrium) -> Rate:
    def rate(at: Local) -> Any:
        p = {key: at.x[key] * at.p / BAR for key in reforming.GASES}
        return reforming.rate(name, at.T, p, np.exp(equilibrium.ln_K(at.T)))

    return rate


def solids_of(
    equation: Equation, species: Species
) -> tuple[str, float, dict[str, float]]:
    """Return the solid that reacts, its coefficient, and the solids that are made."""
    gone = [
        (name, -n)
        for name, n in equation.stoichiometry.items()
        if n < 0 and name in species.solids
    ]
    made = {
        name: n
        for name, n in equation.stoichiometry.items()
        if n > 0 and name in species.solids
    }
    return gone[0][0], gone[0][1], made


def whole(at: Local, equation: Equation, species: Species) -> Any:
    """Return the moles of the reacting solid with what has reacted of it
    already [mol/m3 bed].
    """
    name, count, made = solids_of(equation, species)
    total = at.n[name]
    share = sum(made.values())
    # several products count by their share of the moles that are made
    for product, n in made.items():
        total = total + at.n[product] * (count / n) * (n / share)
    return total


def _key(equation: Equation, species: Species) -> tuple[str, float]:
    """Return the gas on the left that a rate of first order refers to, and its
    coefficient.
    """
    return next(
        (name, -n)
        for name, n in equation.stoichiometry.items()
        if n < 0 and name in species.gases
    )


def _grain(table: ReactionTable, equation: Equation, species: Species) -> Rate:
    """Return 3 n0 a k c^m (1 - X)^(2/3)/(n_g r_g), times another 1 - X for
    `grain_remaining`, per particle volume.
    """
    orders = orders_of(table, equation, species)
    name, _, _ = solids_of(equation, species)
    scale = (
        3.0
        * table.active_share
        / (float(table.molar_density or 1.0) * float(table.grain_radius or 1.0))
    )
    exponent = 2.0 / 3.0 + (table.law == "grain_remaining")

    def rate(at: Local) -> Any:
        total = whole(at, equation, species)
        left = at.n[name] / total
        return (
            constant(table, at.T)
            * _powers(at, orders)
            * odd_power(left, exponent, at.small.solids)
            * total
            * (scale / at.solids)
        )

    return rate


def _shrinking_core(
    table: ReactionTable, equation: Equation, equilibrium: Equilibrium, species: Species
) -> Rate:
    name, _, _ = solids_of(equation, species)
    gas, moles = _key(equation, species)
    gases = {
        key: n for key, n in equation.stoichiometry.items() if key in species.gases
    }

    def rate(at: Local) -> Any:
        total = whole(at, equation, species)
        # not above 1, where the resistance of a product layer would be negative
        q = np.minimum(
            shrinking_core.remaining_radius(at.n[name] / total, at.small.solids), 1.0
        )
        k = constant(table, at.T)
        driving = at.c[gas]
        if equation.reversible:
            K = np.exp(equilibrium.ln_K(at.T)) * (BAR / (R_GAS * at.T)) ** sum(
                gases.values()
            )
            back: Any = 1.0
            for key, n in gases.items():
                if key != gas:
                    back = back * power(at.c[key], n)
            driving = (driving - power(back, 1.0 / moles) / K ** (1.0 / moles)) / (
                1.0 + 1.0 / K
            )
            k = k * (1.0 + 1.0 / K)
        film = at.films.get(gas, np.inf)
        tau = shrinking_core.times(
            at.radius,
            1.0,
            1.0,
            gas_per_solid=1.0,
            film=film,
            diffusivity=table.diffusivity,
            constant=k,
        )
        # tau for one mole of solid per volume and unit concentration: their product is
        # the gas taken per volume
        return driving * shrinking_core.rate(q, tau) / moles

    return rate


def _stages(table: ReactionTable, equations: Mapping[str, Equation]) -> list[Reaction]:
    """Return the three steps of a pellet with three interfaces."""
    gas = STAGED[str(table.law)]
    data = three_interfaces.TAKAHASHI[gas]

    def rates(at: Local) -> Any:
        left = interface_volumes(at.n)
        X = tuple(
            shrinking_core.remaining_radius(share, at.small.solids) for share in left
        )
        around = three_interfaces.Gas(
            at.c[data.reducing], at.c[data.oxidised], at.films.get(gas, np.inf)
        )
        guard = max(three_interfaces.GUARD, at.small.solids)
        taken = three_interfaces.interface_rates(
            X, at.radius, around, data.constants(at.T), guard
        )  # type: ignore[arg-type]
        scale = (3.0 / at.radius) * table.factor * at.solids
        return [w * x * x * scale for w, x in zip(taken, X, strict=True)]

    return [
        Reaction(key, equation, rates, "particle", True, step)
        for step, (key, equation) in enumerate(equations.items())
    ]


def interface_volumes(n: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """Return the shares of the iron inside of the three interfaces."""
    iron = [
        n[name] * atoms for name, atoms in zip(IRON, (2.0, 3.0, 1.0, 1.0), strict=True)
    ]
    total = iron[0] + iron[1] + iron[2] + iron[3]
    return (
        iron[0] / total,
        (iron[0] + iron[1]) / total,
        (iron[0] + iron[1] + iron[2]) / total,
    )


def _slowed(
    rate: Rate, table: ReactionTable, equation: Equation, species: Species, basis: str
) -> Rate:
    """Return a rate times the effectiveness of a sphere.

    The modulus is that of the size of the rate per concentration of the first gas that
    is used up: on the left, or on the right where the reaction runs back.
    """
    gas, moles = _key(equation, species)
    made = [
        (name, n)
        for name, n in equation.stoichiometry.items()
        if n > 0 and name in species.gases
    ]
    back, back_moles = made[0] if made else (gas, moles)

    def slowed(at: Local) -> Any:
        value = rate(at)
        share = {
            "particle": 1.0,
            "bed": 1.0 / at.solids,
            "catalyst": at.catalyst / at.solids,
            "gas": 1.0,
        }
        least = 1e-9 * at.p / (R_GAS * at.T)
        ahead: Any = np.asarray(getattr(value, "value", value)) >= 0.0
        used: Any = np.where(ahead, at.c[gas] / moles, at.c[back] / back_moles)
        k: Any = np.abs(value) * share[basis] / np.maximum(used, least)
        return value * effectiveness_of(at.radius, k, table.diffusivity)

    return slowed


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
    molar, solids = _wholes(at)
    of_gas = {
        f"{kind}_{name}": size
        for name in at.c
        for kind, size in (("c", molar), ("x", 1.0), ("p", at.p))
    }
    return {"X": 0.0, **of_gas, **{f"n_{name}": solids for name in at.n}}


def formula_of(
    table: ReactionTable, basis: str
) -> tuple[Formula, dict[str, float], float]:
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


def _formula(
    table: ReactionTable, equation: Equation, basis: str, species: Species
) -> Rate:
    formula, parameters, factor = formula_of(table, basis)
    has_solid = any(
        name in species.solids and n < 0 for name, n in equation.stoichiometry.items()
    )

    def rate(at: Local) -> Any:
        left: Any = 1.0
        if has_solid and "X" in formula.names:
            left = at.n[solids_of(equation, species)[0]] / whole(at, equation, species)
        values = {**formula_values(at, left), **parameters}
        sizes = {**values, **sizes_of(at)} if at.small.amounts else None
        return formula(values, at.small.amounts, sizes) * factor

    return rate

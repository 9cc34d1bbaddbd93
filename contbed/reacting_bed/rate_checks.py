"""Rates that take a species where there is none of it, or that have no value: reported
before a run and after it.

Rates r_j take species k where there is none if its amount is not above zero and all of
them together take of it

    -sum_j nu_jk r_j L > tolerance F_k,    F_k the flux of all gases, or of all solids that move [mol/m2/s]

with L the length of the bed. Rates that run back, such as those limited by an
equilibrium, take a product only where there is some. After a run the amount is the mean
of a cell, which a polynomial through a steep front leaves above zero. Solids at rest
have limits of their own, see `equations.consumption_limit`; laws that are named end with what they
take.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from contbed.arrays import Array, Flags
from contbed.chemistry.kinetics import Reaction
from contbed.chemistry.thermo import R_GAS
from contbed.closures.formula import parse_formula
from contbed.errors import SceneError
from contbed.fem.ad.dual import Dual
from contbed.materials.composition import mole_fractions
from contbed.reacting_bed.equations.unknowns import Role, State
from contbed.reacting_bed.least_amounts import allowed, along, at_rest
from contbed.reacting_bed.problem import Problem
from contbed.scene.toml_lines import KeyPath

# share of the concentration of all over which the rate of the remedy ends: shorter, no
# state is found
SWITCH = 5e-3
# share of the whole of which a failed iteration leaves no more where it is used up
HARDLY = 1e-2


class Amount(NamedTuple):
    """An unknown that is the amount of a species.

    row : its number in the layout
    species : as stoichiometries name it; gas : whether it is one
    phase : at the surface of whose particles it is; None in the bulk of the gas or in
        solids
    """

    row: int
    species: str
    gas: bool
    phase: str | None

    def gained(self, reaction: Reaction) -> float:
        """Return the moles that a reaction makes of it."""
        if self.phase is not None and (
            reaction.site == "gas" or reaction.phase != self.phase
        ):
            return 0.0
        return reaction.stoichiometry.get(self.species, 0.0)

    def __str__(self) -> str:
        place = "" if self.phase is None else " at the particles"
        return f"{self.species}{place}"


def amounts(problem: Problem) -> list[Amount]:
    """Return the gases, those at particles included, and the solids that move."""
    layout, out = problem.layout, []
    rest = at_rest(problem)
    for row, (_, role, species, phase) in enumerate(layout.unknowns):
        if role in (Role.GAS, Role.SOLID) and not rest[row]:
            out.append(Amount(row, str(species), role is Role.GAS, None))
        elif role is Role.FILM:
            out.append(Amount(row, str(species), True, phase))
    return out


ENTERS, FILLS = "as gas and solids enter", "in the gas that fills the bed at the start"


def require_rates(problem: Problem, later: Iterable[Problem] = ()) -> None:
    """Check the rates of a bed where everything is as it enters, and in time in the gas
    that fills the bed.

    A steady bed has the temperature from which its solution is sought, one in time that
    of its start. A start from a file is not looked at.

    Parameters
    ----------
    problem : of a run in time with what enters at its start
    later : with what enters later

    Raises
    ------
    SceneError : a rate or its slope is not finite there, or rates of a steady bed take
        a species that does not enter
    """
    time, initial = problem.scene.time, problem.scene.initial
    if not problem.reactions or (time is not None and initial.file is not None):
        return
    if time is None:
        T = initial.temperature or problem.mixing_temperature
        _takes_what_enters(
            problem, _require_values(problem, problem.streams.gas, T, ENTERS)
        )
        return
    for each in (problem, *later):
        _require_values(
            each,
            each.streams.gas,
            initial.gas_temperature or each.streams.T_gas,
            ENTERS,
        )
    if initial.gas.composition is not None:
        fills = mole_fractions(initial.gas.composition)
        _require_values(
            problem, fills, initial.gas_temperature or problem.streams.T_gas, FILLS
        )


def _require_values(
    problem: Problem, gas: Mapping[str, float], T: float, where: str
) -> list[Array]:
    """Return all rates in a gas of given moles at a temperature [K], with solids as
    they enter; they are finite.
    """
    entering = [part[:1, 0] for part in problem.start(T)[: len(problem.layout.names)]]
    whole = sum(gas.values())
    for row, name in enumerate(problem.layout.gases):
        share = gas.get(name, 0.0) / whole
        entering[row] = np.array([share * problem.streams.moles])
    with np.errstate(all="ignore"):
        state = problem.bed.state(
            [Dual(value, {k: np.ones(1)}) for k, value in enumerate(entering)]
        )
        rates = problem.bed.rates(state, problem.bed.medium.at(state))
    for reaction, rate in zip(problem.reactions, rates, strict=True):
        if not all(
            np.isfinite(part).all()
            for part in (_value(rate), *getattr(rate, "tangents", {}).values())
        ):
            raise SceneError(_without_value(problem, reaction, state, rate, where))
        if (sentence := _infinite_order(problem, reaction, state, where)) is not None:
            raise SceneError(sentence)
    return [np.broadcast_to(_value(rate), (1, 1)) for rate in rates]


def _takes_what_enters(problem: Problem, made: list[Array]) -> None:
    """Refuse rates of a bed as everything enters that take a species which does not.

    Raises
    ------
    SceneError : they do
    """
    tolerance = allowed(problem.scene)
    entering = problem.first_point()
    for amount in amounts(problem):
        if (
            entering[amount.row] == 0.0
            and _taken(problem, amount, made, tolerance).any()
        ):
            raise SceneError(_sentence(problem, amount, made, 0, "does not enter"))


def taken_though_absent(problem: Problem, u: Array) -> str | None:
    """Return what rates take in a state where there is none of it, beyond its
    errors; None if they do not.
    """
    tolerance = allowed(problem.scene)
    means = _means(problem, u)
    for amount in amounts(problem) if problem.reactions else ():
        low = means[:, amount.row].ravel()
        if not (low < -tolerance).any():
            continue
        made = _cell_rates(problem, u)
        wrong = (low < -tolerance) & _taken(problem, amount, made, tolerance)
        if wrong.any():
            at = int(np.where(wrong, low, 0.0).argmin())
            x = float(problem.line.points[at % problem.line.cells].mean())
            of = "gas" if amount.gas else "solids"
            return _sentence(
                problem,
                amount,
                made,
                at,
                f"falls to {low[at]:.2g} of the {of} at x = {x:.4g} m",
            )
    return None


def taken_to_the_end(problem: Problem, u: Array) -> str | None:
    """Return what rates keep consuming where hardly any is left of it in a state;
    None if they end with it.
    """
    means = _means(problem, u)
    for amount in amounts(problem) if problem.reactions else ():
        low = means[:, amount.row] < HARDLY
        if not low.any():
            continue
        empty = u.copy()
        empty.reshape(len(low), -1, *u.shape[1:])[:, amount.row][low] = 0.0
        made = [
            np.where(np.isfinite(rate), rate, 0.0)
            for rate in _cell_rates(problem, empty)
        ]
        wrong = low.ravel() & _taken(problem, amount, made, allowed(problem.scene))
        if wrong.any():
            at = int(wrong.argmax())
            x = float(problem.line.points[at % problem.line.cells].mean())
            return _sentence(problem, amount, made, at, f"is used up at x = {x:.4g} m")
    return None


def _means(problem: Problem, u: Array) -> Array:
    """Return the means of cells over the sizes of unknowns (rings, unknowns of the
    layout, N).
    """
    means = along(problem, u) @ problem.line.weights
    return means.reshape(-1, len(problem.layout.names), means.shape[1])


def _cell_rates(problem: Problem, u: Array) -> list[Array]:
    """Return the means of all rates in cells, those of one ring after those of
    another [mol/m3 bed/s].
    """
    weights, shape = problem.line.weights, u.shape[1:]
    return [
        (rate.reshape(-1, *shape) @ weights).ravel()
        for rate in rates_at_all_points(problem, u)
    ]


def rates_at_all_points(problem: Problem, u: Array) -> list[Array]:
    """Return the rates of all reactions at all points, those of one ring after those
    of another [mol/m3 bed/s].
    """
    flat = problem.at_all_points(u)
    state = problem.bed.state(flat)
    with np.errstate(all="ignore"):
        rates = problem.bed.rates(state, problem.bed.medium.at(state))
    return [np.broadcast_to(rate, flat[0].shape) for rate in rates]


def rate_without_value(problem: Problem, u: Array) -> str | None:
    """Return which rate is not finite in a state, and where; None if all are."""
    for reaction, rate in zip(
        problem.reactions, rates_at_all_points(problem, u), strict=True
    ):
        wrong = np.flatnonzero(~np.isfinite(rate))
        if wrong.size:
            x = problem.line.points.ravel()[wrong[0] % problem.line.points.size]
            return f"the rate of {reaction.name} is {rate[wrong[0]]:g} at x = {x:.4g} m"
    return None


def _value(rate: Any) -> Any:
    return np.asarray(getattr(rate, "value", rate))


def _taken(
    problem: Problem, amount: Amount, made: list[Array], tolerance: float
) -> Flags:
    """Return where reactions take more of a species than counts."""
    lost, by_written = np.zeros(made[0].size), np.zeros(made[0].size)
    for reaction, rate in zip(problem.reactions, made, strict=True):
        lost -= amount.gained(reaction) * rate.ravel()
        if _is_written(problem, reaction):
            by_written -= amount.gained(reaction) * rate.ravel()
    # what films pass is measured by the gas as well
    flux = problem.moles if amount.gas else problem.flux_sizes[amount.row]
    found: Flags = (
        np.minimum(lost, by_written) * problem.scene.mesh.length > tolerance * flux
    )
    return found


def _is_written(problem: Problem, reaction: Reaction) -> bool:
    """Return whether a scene writes a rate itself, by a formula or orders; laws with
    a name end with what they take.
    """
    table = problem.scene.reactions.get(reaction.key)
    return table is not None and (
        table.rate is not None or table.law in (None, "power")
    )


def _suffix(problem: Problem, reaction: Reaction) -> str:
    """Return what ends names of constituents in a reaction."""
    return (
        "" if reaction.phase is None else problem.species.phases[reaction.phase].suffix
    )


def _place(problem: Problem, reaction: Reaction) -> str:
    table = problem.scene.reactions[reaction.key]
    path: KeyPath = ("reactions", reaction.key) + (
        ("rate",) if table.rate is not None else ()
    )
    return f"{problem.scene.origin.at(path)}: {'.'.join(str(part) for part in path)}"


def _sentence(
    problem: Problem, amount: Amount, made: list[Array], at: int, what: str
) -> str:
    """Return which reaction takes a species that is not there, and the remedy."""
    pairs = [
        (reaction, rate.ravel()[at])
        for reaction, rate in zip(problem.reactions, made, strict=True)
    ]
    written = [
        (amount.gained(reaction) * rate, reaction, rate)
        for reaction, rate in pairs
        if _is_written(problem, reaction)
    ]
    change, reaction, rate = min(written, key=lambda each: each[0])
    text = (
        f"{_place(problem, reaction)}: takes {-change:.3g} mol/m3/s of {amount} where "
        "there is none, as its rate "
        f"is {rate:.3g} mol/m3/s of bed there: {amount.species} {what}. A rate ends "
        "with what it takes"
    )
    if rate < 0.0 and not reaction.equation.reversible:
        return (
            f"{text}: correct its sign, or let it run back only where there are "
            "products"
        )
    if rate < 0.0:
        return (
            f"{text}: an order in {amount.species} would stop it forward as well; give "
            "a formula whose part that runs back ends, such as "
            "k*n_A*max(1 - p_B/K, 0), with -> in the equation"
        )
    name = f"{'c' if amount.gas else 'n'}_{amount.species.removesuffix(_suffix(problem, reaction))}"
    if problem.scene.reactions[reaction.key].rate is None:
        return f"{text}: give an order in {amount.species} in `orders`"
    streams = problem.streams
    whole = (
        streams.pressure / (R_GAS * streams.T_gas)
        if amount.gas
        else problem.sizes[amount.row]
    )
    return (
        f"{text}: multiply it by a factor such as {name}/(abs({name}) + "
        f"{SWITCH * whole:.1g})"
    )


def _without_value(
    problem: Problem, reaction: Reaction, state: State, rate: Any, where: str
) -> str:
    """Return which rate has no value in a state, as everything enters or the bed is
    filled, and the remedy.
    """
    own = state.of(reaction.phase)
    T = float(_value(own.T_fluid if reaction.site == "gas" else own.T_solid).ravel()[0])
    value = float(_value(rate).ravel()[0])
    what = (
        f"is {value:g}" if not np.isfinite(value) else "has a slope that is not finite"
    )
    table = problem.scene.reactions[reaction.key]
    names = (
        set(reaction.stoichiometry) if table.rate is None else _species_of(table.rate)
    )
    amounts_there = {**state.g, **own.n}
    absent = sorted(
        name
        for name in names
        if name in amounts_there and not _value(amounts_there[name]).any()
    )
    because = f", where there is no {', no '.join(absent)}" if absent else ""
    remedy = (
        "; add a small amount to what it divides by, such as c_X + 1e-6"
        if absent
        else "; see its limits"
    )
    return f"{_place(problem, reaction)}: {what} {where}, at {T:g} K{because}{remedy}"


def _infinite_order(
    problem: Problem, reaction: Reaction, state: State, where: str
) -> str | None:
    """Return which negative order is one in a species that is not there, where
    powers are straight lines to zero.
    """
    table = problem.scene.reactions.get(reaction.key)
    orders = (table.orders if table is not None else None) or {}
    there = {**state.g, **state.of(reaction.phase).n}
    if any(
        order > 0.0 and name in there and not _value(there[name]).any()
        for name, order in orders.items()
    ):
        return None  # nothing reacts
    for name, order in orders.items():
        if order < 0.0 and name in there and not _value(there[name]).any():
            formula = f"{'c' if name in state.g else 'n'}_{name} + 1e-6"
            return (
                f"{_place(problem, reaction)}: is infinite {where}, where there is no "
                f"{name}, of which "
                f"the order is {order:g}: give a rate in place of A, E and orders, "
                f"with ({formula})**({order:g})"
            )
    return None


def _species_of(formula: str) -> set[str]:
    return {name.partition("_")[2] for name in parse_formula(formula).names}

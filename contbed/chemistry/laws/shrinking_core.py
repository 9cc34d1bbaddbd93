"""Conversion of a particle of constant size: one sharp interface that moves inwards.

Film, product layer ("ash") and reaction at the interface follow each other; with
q = (1 - X)^(1/3), the radius of the interface over that of the particle,

    t = tau_film X + tau_ash (1 - q)^2 (1 + 2 q) + tau_reaction (1 - q)
    dX/dt = 3 q^2/(3 q^2 tau_film + 6 q (1 - q) tau_ash + tau_reaction)

    tau_film = b R n/(3 k_film c),  tau_ash = b R^2 n/(6 D c),  tau_reaction = b R n/(k c)      [s]

b moles of gas per mole of solid, n [mol/m3] solid per volume of particle, c [mol/m3]
concentration beyond equilibrium. For a reversible first-order reaction
c = c_bulk - c_equilibrium and k = k_forward (1 + 1/K), with K of one mole of the gas;
where no gas is made k is that of the forward reaction.

q is the unknown to integrate: it falls at a finite rate down to 0, where X has an end
of infinite curvature.

Source: Levenspiel, Chemical Reaction Engineering, 3rd ed. (1999), ch. 25; Szekely,
    Evans, Sohn, Gas-Solid Reactions
(1976), ch. 3 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.rate_law import Case, RateLaw
from contbed.closures.formula import power
from contbed.errors import SceneError

# of the reacting solid that is left, below which fractional powers are straight lines
SMALL = 1e-6


@dataclass(frozen=True)
class Times:
    """Times for complete conversion if one resistance acted alone [s]; numbers,
    arrays or dual numbers.
    """

    film: Any
    ash: Any
    reaction: Any


def times(
    radius: Any,
    moles: Any,
    concentration: Any,
    *,
    gas_per_solid: float,
    film: Any,
    diffusivity: Any,
    constant: Any,
) -> Times:
    """Return the times of the three resistances.

    Parameters
    ----------
    radius : of the particle [m]
    moles : solid that reacts, per volume of fresh particle [mol/m3]
    concentration : of the gas beyond equilibrium [mol/m3], above 0
    gas_per_solid : moles of gas that one mole of solid takes
    film : coefficient of the film [m/s]
    diffusivity : effective, in the product layer [m2/s]
    constant : of the first-order rate per area of the interface [m/s], (1 + 1/K) times
        that if it is reversible
    """
    demand = gas_per_solid * radius * moles / concentration
    return Times(
        demand / (3.0 * film), demand * radius / (6.0 * diffusivity), demand / constant
    )


def rate(q: Any, tau: Times) -> Any:
    """Rate of conversion dX/dt [1/s] with the interface at q of the radius; odd, so
    that a negative rest recovers.
    """
    size = np.abs(q)
    return 3.0 * q * size * per_area(size, tau)


def per_area(q: Any, tau: Times) -> Any:
    """Return dX/dt over 3 q^2 [1/s], in which nothing is divided by q."""
    return 1.0 / (3.0 * q * q * tau.film + 6.0 * q * (1.0 - q) * tau.ash + tau.reaction)


def remaining_radius(left: Any, small: float = SMALL) -> Any:
    """Radius of the interface q = left^(1/3) [-] from the share of solid that is left.

    Below `small` it is a straight line through 0, odd, so that a slightly negative rest
    pulls back.
    """
    return left * (left * left + small * small) ** (-1.0 / 3.0)


def _shrinking_core(case: Case) -> Rate:
    """Return the rate of moles per volume of particles, by the law of the module."""
    gas, moles = case.first_gas
    others = [n for key, n in case.gases.items() if key != gas]
    made = sum(others)
    if case.equation.reversible and (
        min(others, default=0.0) < 0.0 or made not in (0.0, moles)
    ):
        raise SceneError(
            f"reactions.{case.name}: a shrinking core runs back only where one gas is "
            "taken up and as many moles of gas are made, or none: give a formula, "
            "rate = ..."
        )
    constant = case.constant("m/s")

    def rate_of(at: Local) -> Any:
        left = at.n[case.solid] / case.fresh(at)
        # not above 1, where the resistance of a product layer would be negative
        q = np.minimum(remaining_radius(left, at.small.solids), 1.0)
        k = constant(at.T)
        driving = at.c[gas]
        if case.equation.reversible:
            # of one mole of the gas
            K = case.equilibrium_constant(at.T) ** (1.0 / moles)
            back: Any = 1.0
            for key, n in case.gases.items():
                if key != gas:
                    back = back * power(at.c[key], n)
            driving = driving - power(back, 1.0 / moles) / K
            if made > 0.0:
                driving = driving / (1.0 + 1.0 / K)
                k = k * (1.0 + 1.0 / K)
        tau = times(
            at.radius,
            1.0,
            1.0,
            gas_per_solid=1.0,
            film=at.films.get(gas, np.inf),
            diffusivity=case.table.diffusivity,
            constant=k,
        )
        # tau for one mole of solid per volume and unit concentration: their product is
        # the gas taken per volume
        return driving * rate(q, tau) / moles

    return rate_of


LAWS = {
    "shrinking_core": RateLaw(
        _shrinking_core,
        needs=("A", "E", "diffusivity"),
        takes=("b", "equilibrium_factor"),
        own_film=True,
        of_solids=True,
    )
}

"""Reduction of a hematite pellet by H2 or CO: three sharp interfaces, Fe2O3 | Fe3O4 |
FeO | Fe, in one sphere.

Every interface i at radius X_i R, X_1 <= X_2 <= X_3, takes v_i of the reducing gas, per
4 pi R^2 [mol/m2/s]:

    v_i = X_i^2 k_i (1 + 1/K_i)(c_i - e_i),    e_i = (c_reducing + c_oxidised)/(1 + K_i)

c_i [mol/m3] is the concentration at interface i. In between the gas diffuses through
the products:

    c_1 = c_2 - v_1 b_1,  c_2 = c_3 - (v_1 + v_2) b_2,  c_3 = c - (v_1 + v_2 + v_3) b_3
    b_1 = (1/X_1 - 1/X_2) R/D_1,  b_2 = (1/X_2 - 1/X_3) R/D_2,  b_3 = (1/X_3 - 1) R/D_3 + 1/k_film

    d(X_i^3)/dt = -3 v_i/(s_i n_Fe R),     s = 1/6, 1/3, 1 mol gas per mol Fe

The system is solved from the inside, in v_i/X_i^2 and without dividing by X_i^2, so
that a core that is gone takes nothing and needs no case of its own. Two gases that
reduce at once act beside each other: their v_i add.

A stage reacts only while there is what it reduces, and goes back only while there is
product: its rate constant is multiplied by f/(f + guard), f the volume of that layer
over the volume within its outer interface. Without this X_3 < X_2 occurs below the
triple point near 849 K, where Fe3O4 turns to Fe directly.

Source: Spitzer, Manning, Philbrook, Trans. Metall. Soc. AIME 236 (1966) 726 (three
    interfaces); constants of Takahashi
et al. 1986 as used by Yu et al. 2021 and in a public shaft furnace model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.laws.shrinking_core import remaining_radius
from contbed.chemistry.local import Local
from contbed.chemistry.rate_law import RateLaw

R_KINETICS = 8.314e-3  # [kJ/mol/K], with which the constants below were fitted
CM, CM2 = 1e-2, 1e-4  # [m] and [m2]: constants below are in cm/s and cm2/s
# mol of reducing gas per mol Fe in each step
GAS_PER_IRON = (1.0 / 6.0, 1.0 / 3.0, 1.0)
# volume of a layer over that within its outer interface at which its stage has half of
# its rate constant
GUARD = 1e-4
THINNEST = 1e-9  # radius over the pellet's below which an interface counts as gone

Three = tuple[Any, Any, Any]


@dataclass(frozen=True)
class Reduction:
    """Constants of the three steps with one gas, each a pair (a, b) for exp(a + b/T) or
    exp(a - E/(R T)).

    equilibrium : K = c_oxidised/c_reducing; b in K
    rate : forward rate constant per area of the interface [cm/s]; the second number is
        E in kJ/mol
    diffusivity : of the reducing gas in Fe3O4, FeO and Fe [cm2/s]; b in K
    """

    reducing: str
    oxidised: str
    equilibrium: tuple[tuple[float, float], ...]
    rate: tuple[tuple[float, float], ...]
    diffusivity: tuple[tuple[float, float], ...]

    def constants(self, T: Any) -> Constants:
        """Return the constants of the three steps at a temperature [K]."""
        K = tuple(np.exp(a + b / T) for a, b in self.equilibrium)
        k = tuple(CM * np.exp(a - E / (R_KINETICS * T)) for a, E in self.rate)
        D = tuple(CM2 * np.exp(a + b / T) for a, b in self.diffusivity)
        return Constants(_three(K), _three(k), _three(D))


@dataclass(frozen=True)
class Constants:
    """Equilibrium constants [-], rate constants [m/s] and effective
    diffusivities [m2/s] of the three steps.
    """

    K: Three
    k: Three
    D: Three


def _three(values: Sequence[Any]) -> Three:
    return values[0], values[1], values[2]


TAKAHASHI: dict[str, Reduction] = {
    "H2": Reduction(
        "H2", "H2O",
        ((9.083, 1433.37), (7.563, -7393.9), (1.239, -2023.8)),
        ((4.49, 33.4), (6.70, 58.2), (6.97, 57.1)),
        ((3.43, -4200.0), (5.64, -6800.0), (4.77, -5900.0)),
    ),
    "CO": Reduction(
        "CO", "CO2",
        ((5.7, 5128.6), (3.661, -3132.5), (-2.667, 2240.6)),
        ((3.16, 50.2), (2.09, 40.0), (5.42, 61.4)),
        ((8.76, -14100.0), (2.77, -7200.0), (5.09, -8800.0)),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Gas:
    """What surrounds the pellet, per reducing gas: bulk concentrations [mol/m3] and
    the film's coefficient [m/s].
    """

    reducing: Any
    oxidised: Any
    film: Any


def interface_rates(
    X: Three, R: Any, gas: Gas, at: Constants, guard: float = GUARD
) -> Three:
    """Reducing gas taken at each interface per area of the interface,
    v_i/X_i^2 [mol/m2/s]; negative where it oxidises.

    Parameters
    ----------
    X : radii of the three interfaces over the pellet's; they may exceed 1 or each other
        slightly within an iteration
    R : radius of the pellet [m]
    gas : bulk concentrations and film
    at : constants at the temperature of the pellet
    guard : see the module; 0 leaves the stages without it

    Notes
    -----
    d X_i/dt = -(v_i/X_i^2)/(s_i n_Fe R) with s = GAS_PER_IRON and n_Fe [mol/m3 of pellet]: finite down to X_i = 0.
    """
    if guard == 0.0:
        return _solve(X, R, gas, at, (1.0, 1.0, 1.0))
    forward, backward = _available(X, guard)
    # only signs are read from the first solution: it needs no derivatives
    values = Gas(*(plain(each) for each in (gas.reducing, gas.oxidised, gas.film)))
    constants = Constants(
        *(_three([plain(each) for each in three]) for three in (at.K, at.k, at.D))
    )
    first = _solve(
        _three([plain(x) for x in X]),
        R,
        values,
        constants,
        _three([plain(each) for each in forward]),
    )
    chosen = [
        np.where(v >= 0.0, f, b)
        for v, f, b in zip(first, forward, backward, strict=True)
    ]
    return _solve(X, R, gas, at, _three(chosen))


def plain(value: Any) -> Any:
    """Return the value of a dual number, or a number or array as it is."""
    return getattr(value, "value", value)


def _available(X: Three, guard: float) -> tuple[Three, Three]:
    """Return factors of the three rate constants forward and backward by the amounts
    that can react.
    """
    x = [np.maximum(radius, THINNEST) for radius in X]
    ratios = (x[0] / x[1], x[1] / x[2], x[2])
    layers = [np.maximum(1.0 - ratio * ratio * ratio, 0.0) for ratio in ratios]
    has = [layer / (layer + guard) for layer in layers]
    return (1.0, has[0], has[1]), _three(has)


def _solve(X: Three, R: Any, gas: Gas, at: Constants, active: Three) -> Three:
    """Solve for v_i/X_i^2 by elimination from the inside.

    With a_i = X_i^2 h_i, h_i = active_i k_i (1 + 1/K_i), products a b are formed with
    their powers of X cancelled.
    """
    x1, x2, x3 = (np.maximum(x, THINNEST) for x in X)
    total = gas.reducing + gas.oxidised
    e1, e2, e3 = (total / (1.0 + K) for K in at.K)
    h1, h2, h3 = (
        f * k * (1.0 + 1.0 / K) for f, k, K in zip(active, at.k, at.K, strict=True)
    )
    near, far = x1 / x2, x2 / x3  # at most 1, also where a core is gone
    h1 = h1 / (1.0 + h1 * x1 * (1.0 - near) * R / at.D[0])
    s2 = near * near * h1 + h2  # over x2^2, as d2
    d2 = near * near * h1 * e1 + h2 * e2
    past2 = 1.0 + s2 * x2 * (1.0 - far) * R / at.D[1]
    s3 = far * far * s2 / past2 + h3  # over x3^2, as d3
    d3 = far * far * d2 / past2 + h3 * e3
    resistance = x3 * (1.0 - x3) * R / at.D[2] + x3 * x3 / gas.film  # b3 times x3^2
    v = (s3 * gas.reducing - d3) / (1.0 + resistance * s3)  # over x3^2
    c3 = gas.reducing - resistance * v
    c2 = c3 - x2 * (1.0 - far) * R / at.D[1] * (s2 * c3 - d2) / past2
    return h1 * (c2 - e1), h2 * (c2 - e2), h3 * (c3 - e3)


# per mole of the reducing gas
STAGES = (
    "{0} + 3 Fe2O3 -> 2 Fe3O4 + {1}",
    "{0} + Fe3O4 -> 3 FeO + {1}",
    "{0} + FeO -> Fe + {1}",
)
IRON = {"Fe2O3": 2.0, "Fe3O4": 3.0, "FeO": 1.0, "Fe": 1.0}  # atoms of iron


def interface_volumes(n: Mapping[str, Any]) -> Three:
    """Return the shares of the iron inside of the three interfaces."""
    hematite, magnetite, wustite, iron = (
        n[name] * atoms for name, atoms in IRON.items()
    )
    total = hematite + magnetite + wustite + iron
    return (
        hematite / total,
        (hematite + magnetite) / total,
        (hematite + magnetite + wustite) / total,
    )


def _rates(data: Reduction) -> Callable[[Local], list[Any]]:
    """Return the rates of the three steps per volume of particles, which share their
    work.
    """

    def rates(at: Local) -> list[Any]:
        left = interface_volumes(at.n)
        X = _three([remaining_radius(share, at.small.solids) for share in left])
        film = at.films.get(data.reducing, np.inf)
        around = Gas(at.c[data.reducing], at.c[data.oxidised], film)
        guard = max(GUARD, at.small.solids)
        taken = interface_rates(X, at.radius, around, data.constants(at.T), guard)
        area = 3.0 / at.radius
        return [w * x * x * area for w, x in zip(taken, X, strict=True)]

    return rates


def _law(data: Reduction) -> RateLaw:
    return RateLaw(
        lambda case: _rates(data),
        equations=tuple(text.format(data.reducing, data.oxidised) for text in STAGES),
        own_film=True,
        of_solids=True,
    )


LAWS = {f"three_interfaces_{gas}": _law(data) for gas, data in TAKAHASHI.items()}

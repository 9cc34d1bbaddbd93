"""What a solid fuel consists of and what it releases: analyses as amounts of elements,
yields that close each element.

Fixed carbon of the proximate analysis is taken as pure carbon, char; all else of the
dry, ash-free fuel is volatile. N leaves as N2, S as H2S, and C, H, O as CO, CO2, H2O,
H2, CH4 and tar, written C6H6. The first guess of their amounts is a correlation of the
volatile matter; of all amounts that hold the elements, the one of least relative
entropy to it is taken,

    min sum_i y_i (ln(y_i/y_i0) - 1)  with  sum_i a_ei y_i = b_e:    y_i = y_i0 exp(sum_e a_ei m_e),

which is positive and unique wherever a positive one exists; three multipliers m_e by
Newton's method.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from contbed.chemistry.elements import ATOMIC_WEIGHTS, elements_of, molar_mass_of
from contbed.errors import SceneError

BALANCED = ("C", "H", "O")
# Loison, Chauvin 1964, Chim. Ind. 91, 269-275, as quoted by Rajan and Wen 1980
LOISON_CHAUVIN: dict[str, tuple[float, float, float]] = {
    "CH4": (0.201, -0.469, 0.241), "H2": (0.157, -0.868, 1.388), "CO2": (0.135, -0.900, 1.906),
    "CO": (0.428, -2.653, 4.845), "H2O": (0.409, -2.389, 4.554), "C6H6": (-0.325, 7.279, -12.880),
}  # fmt: skip
LOISON_CHAUVIN_RANGE = (0.10, 0.45)
# share of the volatiles' mass that the first guess of a product has at least
LEAST = 1e-3


@dataclass(frozen=True)
class Volatiles:
    """Volatile matter of a fuel."""

    yields: dict[str, float]  # [mol/kg of volatile matter]
    guess: dict[str, float]  # the correlation's, before elements are balanced [mol/kg]
    elements: dict[str, float]  # [mol/kg]


def yields_loison_chauvin(volatile_matter: float) -> dict[str, float]:
    """Shares of the volatiles' mass by the volatile matter of the dry, ash-free fuel,
    polynomials of second degree.

    Fitted to coals of 10 to 45 % volatile matter; beyond, the polynomials are taken at
    that bound.
    """
    low, high = LOISON_CHAUVIN_RANGE
    V = min(max(volatile_matter, low), high)
    return {
        name: max(a + b * V + c * V * V, LEAST)
        for name, (a, b, c) in LOISON_CHAUVIN.items()
    }


def volatiles(ultimate: Mapping[str, float], volatile_matter: float) -> Volatiles:
    """Products per kg of volatile matter, from mass fractions of the dry, ash-free
    fuel.

    Raises
    ------
    SceneError where there is less carbon than fixed carbon, or no positive amounts hold the elements
    """
    if not volatile_matter > 0.0:
        raise SceneError("fuel: there is no volatile matter to release")
    carbon = ultimate["C"] - (1.0 - volatile_matter)
    if carbon < 0.0:
        raise SceneError(
            f"fuel: carbon is {ultimate['C']:.4g} of the dry, ash-free fuel, less than "
            "the fixed carbon "
            f"{1.0 - volatile_matter:.4g}; check ultimate and volatile_matter"
        )
    mass = {**ultimate, "C": carbon}
    elements = {
        name: mass[name] / ATOMIC_WEIGHTS[name] / volatile_matter
        for name in ("C", "H", "O", "N", "S")
    }
    bound = {**elements, "H": elements["H"] - 2.0 * elements["S"]}
    guess = {
        name: share / molar_mass_of(elements_of(name))
        for name, share in yields_loison_chauvin(volatile_matter).items()
    }
    yields = balanced(guess, [bound[name] for name in BALANCED])
    yields |= {
        name: amount
        for name, amount in (("N2", 0.5 * elements["N"]), ("H2S", elements["S"]))
        if amount > 0
    }
    return Volatiles(yields, guess, elements)


def balanced(guess: Mapping[str, float], elements: list[float]) -> dict[str, float]:
    """Return the amounts nearest to the guess that hold the elements C, H, O [mol];
    see the module's docstring.
    """
    A = np.array(
        [
            [elements_of(name).get(element, 0.0) for name in guess]
            for element in BALANCED
        ]
    )
    b, start = np.array(elements), np.array(list(guess.values()))
    m = np.zeros(len(b))

    def value(m: np.ndarray) -> float:
        with np.errstate(over="ignore"):
            return float((start * np.exp(A.T @ m)).sum() - b @ m)

    for _ in range(200):
        y = start * np.exp(A.T @ m)
        gap = A @ y - b
        if np.abs(gap).max() <= 1e-14 * np.abs(b).max():
            break
        step = -np.linalg.lstsq((A * y) @ A.T, gap, rcond=None)[0]
        damping = 1.0
        while damping > 1e-12 and not value(m + damping * step) <= value(
            m
        ) + 1e-15 * abs(value(m)):
            damping /= 2
        m = m + damping * step
        if np.abs(m).max() > 200.0:
            break
    y = start * np.exp(A.T @ m)
    if not np.abs(A @ y - b).max() <= 1e-10 * np.abs(b).max():
        raise SceneError(
            "fuel: no amounts of CO, CO2, H2O, H2, CH4 and C6H6 hold the carbon, "
            "hydrogen and oxygen of its volatile "
            f"matter, {b[0]:.4g}, {b[1]:.4g}, {b[2]:.4g} mol/kg; check ultimate and "
            "volatile_matter"
        )
    return dict(zip(guess, y.tolist(), strict=True))


# range of the formula of Channiwala and Parikh: ash of the dry fuel, J/kg
MOST_ASH, LEAST_HEAT = 0.714, 4.7e6


def heating_value_channiwala(dry: Mapping[str, float], ash: float) -> float:
    """Higher heating value [J/kg] from mass fractions of the dry fuel.

    1e6 (34.91 C + 117.83 H + 10.05 S - 10.34 O - 1.51 N - 2.11 ash); 4.7 to 55 MJ/kg,
    1.5 % mean error. Channiwala, Parikh 2002, Fuel 81, 1051-1063,
    doi:10.1016/S0016-2361(01)00131-4.
    """
    return 1e6 * (
        34.91 * dry["C"]
        + 117.83 * dry["H"]
        + 10.05 * dry["S"]
        - 10.34 * dry["O"]
        - 1.51 * dry["N"]
        - 2.11 * ash
    )

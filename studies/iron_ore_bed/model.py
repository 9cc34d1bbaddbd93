"""Ore of several sizes, mixed, in a bed that gas passes: three interfaces in each
particle, gas limited by equilibrium.

Every size class has interfaces X_1 <= X_2 <= X_3 (`contbed.chemistry.laws.three_interfaces`);
CO and H2 act side by side. Solids are mixed; the gas of the emulsion is mixed too, and
at any moment as much is converted as enters and reacts:

    F (y_in - y) = sum over classes of A v(y),      A the surface of a class [m2], v per surface [mol/m2/s]

for each gas. v is affine in y as long as no stage changes its direction, so that y
follows from two evaluations. A share of the gas may pass in bubbles without contact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from contbed.chemistry.laws import three_interfaces as three

R_GAS = 8.31446261815324  # [J/mol/K]
# [kg/mol]
MOLAR = {"CO": 0.02801, "CO2": 0.04401, "H2": 0.002016, "H2O": 0.018015, "N2": 0.028014}
HEMATITE, IRON_PER_HEMATITE = 0.15969, 2.0  # [kg/mol], mol Fe per mol
PAIRS = {"CO": "CO2", "H2": "H2O"}
SWITCHES = 8  # at most, of stages that turn round between inlet and bed
LAST = 1e-3  # radius over the particle's below which a core's interface slows down
STEP = 0.01  # of the concentration, over which the slope of the rates is taken
AREA_OF_TUBE = np.pi / 4 * 0.068**2  # [m2]


@dataclass(frozen=True)
class Ore:
    """Sizes and kinetics of the ore, as in the published case.

    radii [m] and mass fractions; rate constants (k_0 [m/s], E [J/mol]) of hematite,
    magnetite, wustite by gas; porosity of the layers of magnetite, wustite and iron
    over the tortuosity: share of the molecular diffusivity; film coefficient over that
    of a sphere in gas at rest
    """

    mass: float = 0.365  # [kg]
    density: float = 4300.0  # [kg/m3]
    radii: tuple[float, ...] = (60e-6, 105e-6, 188e-6, 375e-6)
    shares: tuple[float, ...] = (0.154, 0.332, 0.286, 0.228)
    rate: Mapping[str, tuple[tuple[float, float], ...]] = field(
        default_factory=lambda: {
            "CO": ((2700.0, 113.9e3), (25.0, 73.7e3), (17.0, 100.0e3)),
            "H2": ((160.0, 92.1e3), (23.0, 71.2e3), (17.0, 85.0e3)),
        }
    )
    porosity: tuple[float, float, float] = (0.187, 0.318, 0.613)
    tortuosity: float = 4.0
    film: float = 1.0


@dataclass(frozen=True)
class Run:
    """One measured run: temperature [K], mass fractions of the gas, interfaces at
    the start.
    """

    temperature: float
    gas: Mapping[str, float]
    start: tuple[float, float, float]
    pressure: float = 140e3  # [Pa]
    velocity: float = 0.25  # [m/s], superficial


@dataclass(frozen=True)
class Fitted:
    """The two constants that are fitted: a factor of all rate constants, and the
    share of gas that meets the ore.
    """

    rate: float = 1.0
    contact: float = 1.0


def mole_fractions(gas: Mapping[str, float]) -> dict[str, float]:
    """Mole fractions of mass fractions, both by species."""
    moles = {name: share / MOLAR[name] for name, share in gas.items()}
    return {name: n / sum(moles.values()) for name, n in moles.items()}


def diffusivity(name: str, T: float, p: float) -> float:
    """Molecular diffusivity in nitrogen [m2/s] by Fuller, Schettler and Giddings
    (1966).
    """
    volumes = {"CO": 18.0, "H2": 6.12, "N2": 18.5}  # diffusion volumes [cm3/mol]
    masses = {k: 1e3 * MOLAR[k] for k in volumes}
    pair = (1.0 / masses[name] + 1.0 / masses["N2"]) ** 0.5
    return float(
        1e-4
        * 1e-3
        * T**1.75
        * pair
        / (p / 101325.0 * (volumes[name] ** (1 / 3) + volumes["N2"] ** (1 / 3)) ** 2)
    )


def reduce(
    run: Run, ore: Ore, fitted: Fitted, times: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Fractional reduction [-] of the ore at times (n,) [s] after the gas was
    switched.
    """
    T, p = run.temperature, run.pressure
    c_total = p / (R_GAS * T)
    x = mole_fractions(run.gas)
    flow = fitted.contact * c_total * run.velocity * AREA_OF_TUBE  # [mol/s]
    R = np.array(ore.radii)
    n_iron = IRON_PER_HEMATITE * ore.density / HEMATITE  # [mol/m3]
    area = 3.0 / R * np.array(ore.shares) * ore.mass / ore.density  # [m2]
    constants, film = {}, {}
    for name in PAIRS:
        K = three.TAKAHASHI[name].constants(T).K
        k = tuple(
            fitted.rate * k0 * np.exp(-E / (R_GAS * T)) for k0, E in ore.rate[name]
        )
        D = diffusivity(name, T, p)
        inner = tuple(D * porosity / ore.tortuosity for porosity in ore.porosity)
        constants[name] = three.Constants(K, k, inner)  # type: ignore[arg-type]
        film[name] = ore.film * D / R  # Sh = 2 of small particles

    def speeds(t: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        X = tuple(np.maximum(state.reshape(3, -1), 0.0))
        out = np.zeros((3, len(R)))
        for name, oxidised in PAIRS.items():
            both = c_total * (x[name] + x[oxidised])
            inlet = c_total * x[name]
            if both == 0.0:
                continue

            squares, c = np.array(X) ** 2, inlet
            for _ in range(SWITCHES):
                # what is taken per area of each interface, affine in the concentration
                # while no stage turns round
                w = []
                for each in (c, c - STEP * both):
                    gas = three.Gas(each, both - each, film[name])
                    w.append(
                        np.array(three.interface_rates(X, R, gas, constants[name]))
                    )  # type: ignore[arg-type]
                slope = (w[0] - w[1]) / (STEP * both)
                now, change = (
                    float(np.sum(area * each * squares)) for each in (w[0], slope)
                )
                below = (now - flow / c_total * (inlet - c)) / (flow / c_total + change)
                c -= below
                if abs(below) < STEP * both:
                    break
            out -= w[0] - slope * below
        out /= np.array(three.GAS_PER_IRON)[:, None] * n_iron * R
        # a core ends smoothly within the last thousandth of the radius
        out *= np.minimum(np.array(X) / LAST, 1.0)
        return out.ravel()

    start = np.repeat(np.array(run.start), len(R))
    found = solve_ivp(
        speeds,
        (0.0, times[-1]),
        start,
        method="LSODA",
        t_eval=times,
        rtol=1e-5,
        atol=1e-7,
    )
    X = np.maximum(found.y.reshape(3, len(R), -1), 0.0)
    left = np.einsum("i,i...->...", three.GAS_PER_IRON, X * X * X)
    removed = 1.0 - left / sum(three.GAS_PER_IRON)
    share: NDArray[np.float64] = np.array(ore.shares) @ removed
    return share

"""Stagnant effective thermal conductivity of packed beds of spheres [W/m/K]: unit-cell
models.

The printed formulas are 0/0 at one ratio k_solid / k_fluid. They are coded with the
removable part divided out, so that value and slope are exact there too; the remaining
function is the tail of a logarithm series.
"""

from __future__ import annotations

import math

import numpy as np

from contbed.closures.registry import Value, closure

_ZEHNER = (
    "Zehner, Schluender 1970, Chem. Ing. Tech. 42, 933-941, doi:10.1002/cite.330421408"
)
_BAUER = "Bauer, Schluender 1978, Int. Chem. Eng. 18, 189-204"
_KUNII = "Kunii, Smith 1960, AIChE J. 6, 71-78, doi:10.1002/aic.690060115"

_STEFAN_BOLTZMANN = 5.670374419e-8  # [W/m2/K4], CODATA 2018


def _log_tail(q: Value, order: Value) -> Value:
    """(-ln(q) - z - z^2/2 - ... - z^(order-1)/(order-1)) / z^order with z = 1 - q,
    regular at z = 0.

    The series takes over at |z| < 0.1, where 16 terms and the closed form agree to
    better than 1e-12. Each side of the `where` is evaluated at a harmless argument
    where it is not selected, so that no slope turns into nan.
    """
    near = np.abs(1 - q) < 0.1
    far_q = np.where(near, 0.5, q)
    far_z = 1 - far_q
    head = sum(far_z**n / n for n in range(1, order))
    far = (-np.log(far_q) - head) / far_z**order
    near_z = np.where(near, 1 - q, 0.0)
    series = 0.0 * near_z
    for n in reversed(range(order, order + 16)):
        series = series * near_z + 1 / n
    return np.where(near, series, far)


def _zehner_deformation(eps: Value, shape: Value) -> Value:
    return shape * ((1 - eps) / eps) ** (10 / 9)


@closure(
    kind="conductivity",
    ranges={"eps": (0.26, 0.6), "k_solid/k_fluid": (1, 1e3)},
    source=_ZEHNER,
)
def conductivity_zehner_schluender(
    k_fluid: Value, k_solid: Value, eps: Value, shape: float = 1.25
) -> Value:
    """Zehner and Schluender (1970): deformed particles in a cylindrical cell, no
    contact, no radiation.

        k / k_fluid = 1 - sqrt(1 - eps) + sqrt(1 - eps) c
        c = 2 / N (B (kappa - 1) / (N^2 kappa) ln(kappa / B) - (B + 1) / 2 - (B - 1) / N)
        N = 1 - B / kappa,  B = shape ((1 - eps) / eps)^(10/9),  kappa = k_solid / k_fluid

    Fitted to: measurements on packed beds (shape). The authors print no bounds: those
        above are of random packings, and of conductivity ratios where contact
        conduction is still small
    Limits: k_solid = k_fluid: k_fluid. eps -> 1: k_fluid, the slope in eps is infinite
        there. kappa = B is regular. For kappa < 1.05 it falls below the exact series
        bound, by less than 0.005 %.

    >>> round(float(conductivity_zehner_schluender(k_fluid=0.025, k_solid=1.0, eps=0.4)), 6)
    0.163839
    """
    root = (1 - eps) ** 0.5
    B = _zehner_deformation(eps, shape)
    # The floor only serves eps = 1, where B = 0 and the logarithm is multiplied by 0.
    q = np.maximum(B * k_fluid / k_solid, 1e-300)
    cell = 1 + 2 * (B - q) * _log_tail(q, 3)
    return k_fluid * (1 - root + root * cell)


@closure(
    kind="conductivity",
    ranges={"eps": (0.26, 0.6), "T": (100, 2000), "emissivity": (0, 1)},
    source=_BAUER,
    bounds={"contact": "[0, 1)"},
)
def conductivity_zehner_bauer_schluender(
    k_fluid: Value,
    k_solid: Value,
    eps: Value,
    T: Value,
    d_p: Value,
    emissivity: Value,
    shape: float = 1.25,
    contact: float = 0.0,
) -> Value:
    """Zehner, Bauer and Schluender (1978): the Zehner-Schluender cell with radiation
    and contact areas.

        k / k_fluid = (1 - sqrt(1 - eps)) (1 + eps R) + sqrt(1 - eps) (contact kappa + (1 - contact) c)
        c = 2 / N (B (kappa + R - 1) / (N^2 kappa) ln((kappa + R) / B) + (B + 1) / (2 B) (R - B) - (B - 1) / N)
        N = 1 + (R - B) / kappa,  B = shape ((1 - eps) / eps)^(10/9),  kappa = k_solid / k_fluid
        R = 4 sigma T^3 d_p / ((2 / emissivity - 1) k_fluid)

    T : [K] mean temperature of the bed
    contact : [-] relative contact area, e.g. 0.0077 ceramic, 0.0013 steel, 0.0253
        copper spheres

    Fitted to: measurements on packed beds (shape, contact). The authors print no
        bounds: those above are of random packings. The Smoluchowski effect is left out,
        so not for vacuum or very fine powders
    Limits: emissivity -> 0 and contact = 0: conductivity_zehner_schluender. eps -> 1:
        diverges with radiation.
    Source: As given in VDI Heat Atlas 2010, section D6.3,
        doi:10.1007/978-3-540-77877-6.

    >>> k = conductivity_zehner_bauer_schluender(
    ...     k_fluid=0.06, k_solid=1.5, eps=0.4, T=1000.0, d_p=0.01, emissivity=0.8)
    >>> round(float(k), 6)
    1.132924
    """
    kappa = k_solid / k_fluid
    radiation = 4 * _STEFAN_BOLTZMANN * T**3 * d_p / ((2 / emissivity - 1) * k_fluid)
    root = (1 - eps) ** 0.5
    B = _zehner_deformation(eps, shape)
    q = B / (kappa + radiation)
    r = kappa / (kappa + radiation)
    cell = r**2 * (1 + 2 * (B - q) * _log_tail(q, 3)) + r * radiation * (B + 1) / B
    return k_fluid * (
        (1 - root) * (1 + eps * radiation)
        + root * (contact * kappa + (1 - contact) * cell)
    )


def _kunii_resistance(kappa: Value, sine_squared: Value) -> Value:
    """Resistance of fluid film and solid around one contact; 1 at kappa = 1."""
    m = 1 - math.sqrt(1 - sine_squared)
    return (1 - m / 2) / (kappa * (1 - kappa * m * _log_tail(1 + (kappa - 1) * m, 2)))


@closure(
    kind="conductivity",
    ranges={"eps": (0.26, 0.476), "k_solid/k_fluid": (1, 1e4)},
    source=_KUNII,
    bounds={"beta": "(0, inf)"},
)
def conductivity_kunii_smith(
    k_fluid: Value, k_solid: Value, eps: Value, beta: float = 1.0
) -> Value:
    """Kunii and Smith (1960): contacts of spheres between loose and dense packing, no
    radiation.

        k / k_fluid = eps + beta (1 - eps) / (phi + 2 / (3 kappa)),  kappa = k_solid / k_fluid
        phi = phi_2 + (phi_1 - phi_2) (eps - 0.260) / 0.216
        phi_i = 1/2 e^2 S / (ln(kappa - (kappa - 1) C) - e (1 - C)) - 2 / (3 kappa),  e = (kappa - 1) / kappa
        S = sin^2(theta_i) = 1 / n_i,  C = cos(theta_i),  n_1 = 1.5,  n_2 = 4 sqrt(3)

    beta : [-] distance of particle centres over d_p, 1 loose to 0.895 dense

    Fitted to: measurements on beds of spheres and on porous rocks
    Limits: k_solid = k_fluid: k_fluid for beta = 1. eps -> 1: k_fluid. phi is held
        constant beyond the range of eps, which leaves a kink in eps at both ends. For
        kappa < 2 it falls below the exact series bound, by less than 1.6 %.
    Source: Constants quoted from secondary sources.

    >>> round(float(conductivity_kunii_smith(k_fluid=0.025, k_solid=1.0, eps=0.4)), 6)
    0.156325
    """
    kappa = k_solid / k_fluid
    loose = _kunii_resistance(kappa, 1 / 1.5)
    dense = _kunii_resistance(kappa, 1 / (4 * math.sqrt(3)))
    weight = np.minimum(np.maximum((eps - 0.260) / 0.216, 0.0), 1.0)
    # The terms 2 / (3 kappa) of phi and of the equation cancel.
    return k_fluid * (eps + beta * (1 - eps) / (dense + (loose - dense) * weight))

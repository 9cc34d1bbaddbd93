"""Stagnant effective thermal conductivity of a bed [W/m/K]: closed formulas without
contact and radiation.

Bounds are in conductivity_bounds.py, unit-cell models of packed spheres in
conductivity_cell.py.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_HSU = "Hsu, Cheng, Wong 1995, J. Heat Transfer 117, 264-269, doi:10.1115/1.2822515"
_KRUPICZKA = "Krupiczka 1967, Int. Chem. Eng. 7, 122-144"


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_HSU)
def conductivity_hsu(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Hsu, Cheng and Wong (1995): cubes in line that do not touch.

        k / k_fluid = 1 - s^2 + s^2 k_solid / ((1 - s) k_solid + s k_fluid),  s = (1 - eps)^(1/3)

    Fitted to: nothing: a lumped cell without contact conduction
    Limits: eps -> 1: k_fluid, the slope in eps is infinite there. eps -> 0: k_solid.
    Source: As quoted by Pivem and de Lemos 2012, eq. 34.

    >>> round(conductivity_hsu(k_fluid=1.0, k_solid=40.0, eps=0.4), 7)
    4.2929334
    """
    side = (1 - eps) ** (1 / 3)
    return k_fluid * (
        1 - side**2 + side**2 * k_solid / ((1 - side) * k_solid + side * k_fluid)
    )


@closure(kind="tortuosity", ranges={"eps": (0, 1)}, source=_HSU)
def tortuosity_hsu(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Hsu, Cheng and Wong (1995): tortuosity parameter of the two-energy model, with
    the cubes of conductivity_hsu.

        G = (k / k_fluid - eps - (1 - eps) kappa) / (kappa - 1)^2
          = -s^3 (1 - s) / ((1 - s) kappa + s),  s = (1 - eps)^(1/3), kappa = k_solid / k_fluid

    Fitted to: nothing: follows from conductivity_hsu
    Limits: k_solid = k_fluid: -s^3 (1 - s), regular. eps -> 1 and eps -> 0: 0.
    Source: Definition as in Pivem and de Lemos 2012, eq. 33, without the spurious "1"
        of its numerator; the second line is the first with the common factor
        (kappa - 1)^2 divided out.

    >>> round(tortuosity_hsu(k_fluid=1.0, k_solid=40.0, eps=0.4), 8)
    -0.01321964
    """
    side = (1 - eps) ** (1 / 3)
    return -(side**3) * (1 - side) / ((1 - side) * k_solid / k_fluid + side)


@closure(
    kind="conductivity",
    ranges={"eps": (0.215, 0.476), "k_solid/k_fluid": (1, 1e4)},
    source=_KRUPICZKA,
)
def conductivity_krupiczka(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Krupiczka (1967): power law for granular beds.

        k / k_fluid = kappa^(0.280 - 0.757 log10(eps) - 0.057 log10(kappa)),  kappa = k_solid / k_fluid

    Fitted to: numerical solutions for beds of long cylinders and of spheres, adjusted
        to measurements
    Limits: k_solid = k_fluid: k_fluid. eps -> 1: does not return to k_fluid, so not for
        dilute beds. For kappa < 1.4 it falls below the exact series bound, by less than
        0.2 %.
    Source: Constants and range quoted from secondary sources.

    >>> round(float(conductivity_krupiczka(k_fluid=0.025, k_solid=1.0, eps=0.4)), 6)
    0.152344
    """
    log_ratio = np.log(k_solid / k_fluid)
    exponent = 0.280 - (0.757 * np.log(eps) + 0.057 * log_ratio) / np.log(10.0)
    return k_fluid * np.exp(exponent * log_ratio)

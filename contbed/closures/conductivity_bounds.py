"""Bounds of the effective thermal conductivity of any two-phase medium [W/m/K], and
Maxwell's dilute limit.

All return k_fluid where k_solid = k_fluid, and none divides by the difference of the
two.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_WIENER = "Wiener 1912, Abh. Saechs. Ges. Wiss. Math.-Phys. Kl. 32, 509-604"
_MAXWELL = "Maxwell 1873, A Treatise on Electricity and Magnetism, Clarendon Press"
_HASHIN = "Hashin, Shtrikman 1962, J. Appl. Phys. 33, 3125-3131, doi:10.1063/1.1728579"


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_WIENER)
def conductivity_parallel(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Wiener (1912): layers along the heat flux, the upper bound of every medium.

        k = eps k_fluid + (1 - eps) k_solid

    Fitted to: nothing: exact
    Limits: eps -> 1: k_fluid. eps -> 0: k_solid.

    >>> round(conductivity_parallel(k_fluid=0.025, k_solid=1.0, eps=0.4), 6)
    0.61
    """
    return eps * k_fluid + (1 - eps) * k_solid


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_WIENER)
def conductivity_series(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Wiener (1912): layers across the heat flux, the lower bound of every medium.

        k = k_fluid k_solid / (eps k_solid + (1 - eps) k_fluid)

    Fitted to: nothing: exact
    Limits: eps -> 1: k_fluid. eps -> 0: k_solid.

    >>> round(conductivity_series(k_fluid=0.025, k_solid=1.0, eps=0.4), 6)
    0.060241
    """
    return k_fluid * k_solid / (eps * k_solid + (1 - eps) * k_fluid)


def _coated_spheres(k_matrix: Value, k_core: Value, share: Value) -> Value:
    """Space filled with spheres of k_core, each coated with k_matrix; a quotient of
    sums, so no digits are lost.
    """
    return (
        k_matrix
        * (2 * (1 - share) * k_matrix + (1 + 2 * share) * k_core)
        / ((2 + share) * k_matrix + (1 - share) * k_core)
    )


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_MAXWELL)
def conductivity_maxwell(k_fluid: Value, k_solid: Value, eps: Value) -> Value:
    """Maxwell (1873): solid spheres far apart in the fluid.

        k / k_fluid = 1 + 3 (1 - eps) (k_solid - k_fluid) / (3 k_fluid + eps (k_solid - k_fluid))

    Fitted to: nothing: exact to first order in 1 - eps
    Limits: eps -> 1: k_fluid. For k_solid > k_fluid it is the lower Hashin-Shtrikman
        bound, so too low for a packed bed.
    Source: Article 314.

    >>> round(conductivity_maxwell(k_fluid=0.025, k_solid=1.0, eps=0.4), 6)
    0.119355
    """
    return _coated_spheres(k_fluid, k_solid, 1 - eps)


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_HASHIN)
def conductivity_hashin_shtrikman_lower(
    k_fluid: Value, k_solid: Value, eps: Value
) -> Value:
    """Hashin and Shtrikman (1962): lower bound of an isotropic medium.

        k = k_m (1 + 3 s (k_c - k_m) / (3 k_m + (1 - s) (k_c - k_m)))
        with k_m the smaller and k_c the larger conductivity, s the volume share of k_c

    Fitted to: nothing: exact
    Limits: eps -> 1: k_fluid. At k_solid = k_fluid value, slope and curvature are
        continuous.

    >>> round(float(conductivity_hashin_shtrikman_lower(k_fluid=0.025, k_solid=1.0, eps=0.4)), 6)
    0.119355
    """
    return np.minimum(
        _coated_spheres(k_fluid, k_solid, 1 - eps),
        _coated_spheres(k_solid, k_fluid, eps),
    )


@closure(kind="conductivity", ranges={"eps": (0, 1)}, source=_HASHIN)
def conductivity_hashin_shtrikman_upper(
    k_fluid: Value, k_solid: Value, eps: Value
) -> Value:
    """Hashin and Shtrikman (1962): upper bound of an isotropic medium.

        k = k_m (1 + 3 s (k_c - k_m) / (3 k_m + (1 - s) (k_c - k_m)))
        with k_m the larger and k_c the smaller conductivity, s the volume share of k_c

    Fitted to: nothing: exact
    Limits: eps -> 1: k_fluid. At k_solid = k_fluid value, slope and curvature are
        continuous.

    >>> round(float(conductivity_hashin_shtrikman_upper(k_fluid=0.025, k_solid=1.0, eps=0.4)), 6)
    0.515528
    """
    return np.maximum(
        _coated_spheres(k_fluid, k_solid, 1 - eps),
        _coated_spheres(k_solid, k_fluid, eps),
    )

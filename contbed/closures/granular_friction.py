"""Granular flow near packing, where particles rub: frictional pressure and viscosity.

eps_s, eps_max [-] fraction of the particles, at most      eps_min [-] fraction above which particles rub
p_friction [Pa] frictional pressure      angle [rad] of internal friction
shear_rate [1/s] square root of the second invariant of the strain rate, half of du/dy in simple shear
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_JOHNSON = (
    "Johnson, Jackson 1987, J. Fluid Mech. 176, 67-93, doi:10.1017/S0022112087000570"
)
_SCHAEFFER = (
    "Schaeffer 1987, J. Differ. Equ. 66, 19-50, doi:10.1016/0022-0396(87)90038-6"
)
_OPENFOAM = "OpenFOAM v1912, twoPhaseEulerFoam, frictionalStressModel JohnsonJackson"


@closure(
    kind="granular_friction",
    ranges={"eps_s": (0, 0.65)},
    source=_JOHNSON,
    bounds={"strength": "[0, inf)", "gap": "(0, inf)"},
)
def friction_johnson_jackson(
    eps_s: Value,
    eps_max: Value,
    eps_min: float = 0.5,
    strength: float = 0.05,
    gap: float = 0.01,
) -> Value:
    """Johnson and Jackson (1987): pressure of particles that rub, none below eps_min.

    p = strength (eps_s - eps_min)^2/(eps_max - eps_s)^5

    with eps_max - eps_s no smaller than gap.

    strength : [Pa] factor
    gap : [-] smallest eps_max - eps_s that counts

    Fitted to: flow of glass beads down chutes
    Limits: eps_s <= eps_min: 0.

    >>> round(float(friction_johnson_jackson(eps_s=0.6, eps_max=0.63)), 3)
    20576.132
    """
    return (
        strength
        * np.maximum(eps_s - eps_min, 0.0) ** 2
        / np.maximum(eps_max - eps_s, gap) ** 5
    )


@closure(
    kind="granular_friction_viscosity",
    ranges={"p_friction": (0, 1e6)},
    source=_OPENFOAM,
    bounds={"time": "[0, inf)"},
)
def friction_viscosity_newtonian(
    p_friction: Value, angle: Value, time: float = 0.5
) -> Value:
    """OpenFOAM (2019): frictional viscosity that does not depend on the flow.

    mu = time p_friction sin(angle)

    time : [s] of relaxation

    Fitted to: nothing: a heap spreads like honey
    Limits: p_friction = 0: 0.

    >>> round(float(friction_viscosity_newtonian(p_friction=100.0, angle=0.5)), 3)
    23.971
    """
    return time * p_friction * np.sin(angle)


@closure(
    kind="granular_friction_viscosity",
    ranges={"p_friction": (0, 1e6), "shear_rate": (0, 1e4)},
    source=_SCHAEFFER,
    bounds={"rate_min": "(0, inf)"},
)
def friction_viscosity_schaeffer(
    p_friction: Value, angle: Value, shear_rate: Value, rate_min: float = 0.05
) -> Value:
    """Schaeffer (1987): a yield stress p_friction sin(angle) that does not depend on
    the rate of shear.

    mu = p_friction sin(angle)/(2 sqrt(shear_rate^2 + rate_min^2))

    rate_min : [1/s] below which particles creep instead of standing still

    Fitted to: plastic flow of sand, Coulomb's law
    Limits: shear_rate >> rate_min: the stress 2 mu shear_rate is p_friction sin(angle).

    >>> round(float(friction_viscosity_schaeffer(p_friction=100.0, angle=0.5, shear_rate=10.0)), 4)
    2.3971
    """
    return p_friction * np.sin(angle) / (2.0 * np.sqrt(shear_rate**2 + rate_min**2))

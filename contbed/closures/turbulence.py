"""Turbulence of the gas in developed flow along smooth walls: eddy viscosity by a
mixing length.
"""

from __future__ import annotations

import numpy as np

from contbed.closures.registry import Value, closure

_NIKURADSE = (
    "Nikuradse 1932, VDI-Forschungsheft 356 (mixing length); van Driest 1956, J. "
    "Aeronaut. Sci. 23, 1007-1011, "
    "doi:10.2514/8.3713 (damping at the wall); Owen 1969, J. Fluid Mech. 39, 407-432, "
    "doi:10.1017/S0022112069002254 (energy lost to particles)"
)
_A_PLUS = 26.0  # van Driest's thickness of the damped layer [-]
# square of the ratio of shear stress to turbulent energy in a boundary layer (Launder,
# Spalding 1974)
_C_MU = 0.09
_MIN_RATE = 1e-9  # rate [1/s] added below a root, which has no derivative at 0


@closure(
    kind="eddy_viscosity",
    ranges={"y": (0.0, 10.0), "eps_s": (0.0, 0.1)},
    source=_NIKURADSE,
)
def eddy_viscosity_nikuradse(
    y: Value,
    radius: Value,
    u_friction: Value,
    nu: Value,
    shear_rate: Value,
    drag_rate: Value,
    eps_s: Value = 0.0,
) -> Value:
    """Nikuradse (1932): mixing length, damped at the wall after van Driest and by
    particles that do not follow eddies.

    nu_t = l^2 w,  w^2 + B w = (du/dr)^2,  l = l_0 (1 - exp(-y u_friction/(26 nu)))
    l_0/R = 0.14 - 0.08 (1 - y/R)^2 - 0.06 (1 - y/R)^4,  B = 2 drag_rate/sqrt(0.09)

    w l is the velocity of the eddies. Their energy is in local equilibrium: what shear
    produces is dissipated or lost to the drag on particles, whose loss is that of Owen
    (1969) for particles that respond more slowly than eddies turn.

    Fitted to: smooth pipes, Re 4e3 to 3e6
    Limits: y -> 0: vanishes; drag_rate = 0: Prandtl's l^2 |du/dr|; large drag_rate: (l
        du/dr)^2/B -> 0. Particles that follow the eddies (fine ones) damp less than
        this, and wakes behind large ones, which add turbulence, are left out.
    Source: The loss to particles is combined with the mixing length here, by the local
        balance of energy.

    >>> round(float(eddy_viscosity_nikuradse(y=0.05, radius=0.05, u_friction=1.0, nu=1.5e-5, shear_rate=10.0,
    ...     drag_rate=0.0)), 9)
    0.00049
    """
    core = 1.0 - y / radius
    length = radius * (0.14 - 0.08 * core**2 - 0.06 * core**4)
    length = length * (1.0 - np.exp(-y * u_friction / (_A_PLUS * nu)))
    lost = drag_rate / _C_MU**0.5  # half of B
    return (
        length**2
        * shear_rate**2
        / (lost + np.sqrt(lost**2 + shear_rate**2 + _MIN_RATE**2))
    )

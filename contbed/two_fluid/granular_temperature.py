"""Granular temperature of one step.

    3/2 rho_s (d(eps_s theta)/dt + div(F theta)) = -p_s div u_s + P + div(k grad theta) - gamma - 3 beta theta

F [m/s] is the volume flux of the solids that the step moves, P [W/m3] the work of shear without that of friction, which
does not agitate particles. Convection is explicit and limited, the rest implicit but for the heat of compression: near
packing it makes sound up to six times as stiff as at constant theta, and binds the step there. "algebraic" balances
production and dissipation, and neither moves nor conducts (Syamlal, Rogers and O'Brien 1993, MFIX Documentation:
Theory Guide, DOE/METC-94/1004).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contbed.two_fluid import boundary
from contbed.two_fluid import kernels_faces as kf
from contbed.two_fluid import kernels_solid as ks
from contbed.two_fluid.fv import gradient as kc

if TYPE_CHECKING:
    from contbed.two_fluid.step import Stepper

UNDERFLOW = 1e-60  # [m2/s2] that counts as none


def step(bed: Stepper, dt: float) -> None:
    """Sets `bed.theta` [m2/s2] after `dt` [s], its `lag_theta` and the rate `adiabatic` [1/s]."""
    r = bed.rheology
    divergence = np.empty_like(bed.theta)
    kf.expansion(bed.grid.geometry, bed.faces, bed.eps_s, bed.u_solid, divergence)
    made = bed.work / bed.grid.geometry.volume * r.mu / (r.mu + bed.mu_friction + 1e-300) + bed.sources.theta
    if bed.options.theta == "algebraic":
        bed.theta = _balanced(bed, made, divergence)
    else:
        _transport(bed, dt, made, divergence)


def _transport(bed: Stepper, dt: float, made: np.ndarray, divergence: np.ndarray) -> None:
    """Convected with the solids flux, conducted, produced, dissipated."""
    g, edge, r, s, rho_s = bed.grid.geometry, bed.edge, bed.rheology, bed.eps_s, bed.rho[1]
    old = bed.theta
    sink = r.dissipation * np.sqrt(old) + 3.0 * bed.drag * s
    column = old.reshape(-1, 1)
    given = np.where(edge.solid.kind == boundary.GIVEN, edge.theta, old[bed.near]).reshape(-1, 1)
    grad, ahead = np.empty((len(s), 1, bed.grid.dimension)), np.empty_like(column)
    kc.gradient(g, column, given, grad)
    kc.half_ahead(dt, column, grad, bed.u_solid, bed.lag_theta, ahead)
    low = bed.drained.copy()
    while True:
        rhs = np.zeros_like(column)
        kc.convect(g, bed.moved, column, grad, ahead, given, bed.options.limited, low, rhs)
        if not ks.starved(g, dt, s, old, rhs, low):
            break
    bed.counters["theta_upwind_cells"] += int(low.sum()) - int(bed.drained.sum())
    carried = rhs / ((s + ks.EMPTY) * g.volume)[:, None]
    rhs *= 1.5 * rho_s
    coef, content = np.empty((len(g.left), 1)), np.empty_like(column)
    ks.conduct(g, edge.solid, edge, r.conductivity, old, grad, bed.grid.skewed, rhs, coef)
    ks.theta_system(
        g,
        edge,
        edge.solid,
        bed.slip,
        dt,
        rho_s,
        bed.materials.eps_max,
        s,
        old,
        r.g0,
        sink,
        rho_s * r.pressure,
        divergence,
        made,
        bed.u_solid,
        rhs,
        content,
    )
    bed.theta = old + bed.solve(coef, np.zeros_like(column), content, rhs, "theta")[:, 0]
    if (low := bed.theta < UNDERFLOW).any():
        bed.counters["theta_clipped_cells"] += int((bed.theta < 0.0).sum())
        bed.theta[low] = 0.0
    bed.lag_theta = (bed.theta.reshape(-1, 1) - column) / dt - carried
    bed.adiabatic = ks.adiabatic(g, rho_s, s, bed.theta, r.pressure, sink, bed.drag)


def _balanced(bed: Stepper, made: np.ndarray, divergence: np.ndarray) -> np.ndarray:
    """Granular temperature at which production balances dissipation, a quadratic for its square root. Compression
    is left aside: few particles would need theta as 1/eps_s^2 to lose what it gives.
    """
    r, s, rho_s = bed.rheology, bed.eps_s, bed.rho[1]
    root = np.sqrt(bed.theta)
    factor = np.where(root > 0, np.maximum(made, 0.0) / np.maximum(root, 1e-150), 0.0)
    linear = rho_s * r.pressure * np.maximum(divergence, 0.0) + 3.0 * bed.drag * s
    y = 2.0 * factor / (linear + np.sqrt(linear**2 + 4.0 * r.dissipation * factor) + 1e-300)
    return y**2

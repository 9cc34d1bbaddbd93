"""Darcy-Brinkman-Forchheimer flow of a fluid through a bed that rests or moves.

    div G = 0,   G = rho u
    (1/eps) G.grad u = -grad p + div(mu grad u) - eps (mu/K + rho c_F/sqrt(K) |w|) w,      w = u - eps u_solid/(1 - eps)

u        superficial fluid velocity [m/s]          u_solid  superficial solid velocity [m/s], uniform
p        eps times the intrinsic pressure [Pa]     eps      porosity [1]
K        permeability [m2]                         c_F      Forchheimer coefficient [1]
rho, mu  density [kg/m3], viscosity [Pa s]         G        superficial mass flux [kg/m2/s]

w is 0 where the fluid moves with the particles, u/eps = u_solid/(1 - eps). With
packed_bed.relative_velocity = "superficial" it is u - u_solid, as in the source.

The unknown is U = G/rho_in, the velocity at the density of the inlet, which is the
prescribed one there and free of divergence also where the fluid expands; u = s U with
the expansion s = rho_in/rho. Both s and mu are 1 and a number, or finite-element fields
of the temperature. What expansion adds to the viscous stress by div u is left out.

Source: Pivem & de Lemos, Int. J. Heat Mass Transfer 55 (2012) 3358,
    doi:10.1016/j.ijheatmasstransfer.2011.11.047,
Eq. 10, where p stands for phi <p>. Taylor-Hood elements: u of degree 2, p of degree 1,
so the discrete divergence is orthogonal to all piecewise linear functions; the heat
model relies on that for its exact balance.

Good values: air or steam through 1-10 mm particles, eps 0.4-0.9, velocities 0.05-1 m/s,
a channel of ten particles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

FIELDS = {"u": (2, "vector"), "p": (1, "scalar")}

# the drag's |w| is not differentiable where the fluid moves with the bed; this share of
# the velocity scale rounds it
ROUNDING = 1e-9


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of the momentum balance in SI; `comoving_velocity` is that of a
    fluid without drag, with one entry for each dimension.

    `density` is that at the inlet, `expansion` what it is over the local one, 1 for a
    fluid that does not expand.
    """

    density: float
    viscosity: Any
    porosity: float
    permeability: float
    forchheimer: float
    comoving_velocity: Any
    speed: float
    expansion: Any = 1.0


def drag(w: Any, c: Coefficients, o: Any) -> Any:
    """Return the drag on the fluid per volume and relative velocity [Pa s/m2] at
    relative velocity `w` [m/s].
    """
    speed = np.sqrt(o.dot(w, w) + (ROUNDING * c.speed) ** 2)
    return c.porosity * (
        c.viscosity / c.permeability
        + c.density / c.expansion * c.forchheimer / c.permeability**0.5 * speed
    )


def residual(unknowns: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of momentum and continuity, tested with `tests.u` and
    `tests.p`.
    """
    U, p, v, q = unknowns.u, unknowns.p, tests.u, tests.p
    u, slope = _expanded(U, c.expansion, o)
    w = u - c.comoving_velocity
    inertia = (c.density / c.porosity) * o.dot(o.mul(slope, U), v)
    viscous = c.viscosity * o.inner(slope, o.grad(v))
    if o.axisymmetric:
        viscous = viscous + c.viscosity * o.hoop(u) * o.hoop(v)
    return inertia + viscous + drag(w, c, o) * o.dot(w, v) - p * o.div(v) - q * o.div(U)


def _expanded(U: Any, expansion: Any, o: Any) -> tuple[Any, Any]:
    """Return the velocity u = s U and its gradient, a row for each component."""
    gradient = o.grad(U)
    if isinstance(expansion, float):
        return U, gradient
    return U * expansion, gradient * expansion + o.outer(U, o.grad(expansion))


def volume_flow(unknowns: Any, o: Any) -> Any:
    """Return the outward U on a boundary [m/s]; its integral is the mass flow over
    the density of the inlet [m3/s].
    """
    return o.dot(unknowns.u, o.n)

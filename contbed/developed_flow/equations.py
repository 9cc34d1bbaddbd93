"""Fully developed flow of gas and particles up a channel or a pipe: profiles across,
steady, nothing varies along.

    0 = eps_g G + (r^n mu_t u_g')'/r^n - beta (u_g - u_s) - eps_g rho_g g
    0 = eps_s G + (r^n mu_s u_s')'/r^n + beta (u_g - u_s) - eps_s rho_s g
    0 = (r^n k theta')'/r^n + mu_s u_s'^2 + S - gamma - 3 beta theta,       p_s(eps_s, theta) = P over the section
    r = 0:  u_g' = u_s' = theta' = 0
    r = R:  u_g = 0,  mu_s u_s' = -c u_s,  k theta' = c u_s^2 - c_w theta
    mean of eps_g u_g = U_g,  mean of rho_s eps_s u_s = G_s

r        distance from the centre [m]            n        0 in a channel, 1 in a pipe
u        intrinsic velocity upward [m/s]         theta    granular temperature [m2/s2]
eps      fraction [1]                            G        -dp/dz [Pa/m]
P        pressure of the particles [Pa]          beta     drag [kg/m3/s]
mu_s, k, gamma    of the kinetic theory [Pa s, kg/m/s, W/m3]          S    production by slip [W/m3], 0 where not named
c        phi pi sqrt(3) rho_s eps_s g0 sqrt(theta)/(6 eps_max) [kg/m2/s], Johnson and Jackson's slip, specularity phi
c_w      (1 - e_w^2) pi sqrt(3) rho_s eps_s g0 sqrt(theta)/(4 eps_max) [kg/m2/s]

Unknowns are u_g, u_s, the root of theta, and two numbers, G and P; eps_s follows
pointwise from P and theta. Several solutions may belong to one pair of U_g and G_s: the
granular temperature at the centre names the branch.

Source: Sinclair, Jackson 1989, AIChE J. 35, 1473-1486, doi:10.1002/aic.690350908; walls
    after Johnson, Jackson 1987,
J. Fluid Mech. 176, 67-93, doi:10.1017/S0022112087000570; friction of smooth pipes:
Prandtl 1935, in Durand (ed.), Aerodynamic Theory III, Springer, 34-208.

Good values: particles of 0.1-1 mm in 10-100 mm, specularity 0.01-0.5, U_g 3-20 m/s, G_s
10-500 kg/m2/s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.closures.binding import BoundClosure

MAX_FRACTION_ITERATIONS = 60  # of Newton's method for eps_s at a given pressure
FRACTION_TOLERANCE = 1e-13  # residual of ln p [-], relative
# imaginary part of eps_s [-]: Im(p) over it is dp/d eps_s (complex-step derivative)
COMPLEX_STEP = 1e-30
FRICTION_ITERATIONS = 30  # of Prandtl's law, each of which gains a digit at least
# [m2/s2] added to the square of the slip, whose root has no derivative at 0
MIN_SQUARED_SLIP = 1e-12


@dataclass(frozen=True)
class Coefficients:
    """Gas, particles, flow and wall in SI; `closures` holds bound closures by kind."""

    rho_gas: float
    mu_gas: float
    rho_solid: float
    d_p: float
    restitution: float
    eps_max: float
    gravity: float
    velocity: float  # U_g, superficial [m/s]
    solid_flux: float  # G_s [kg/m2/s]
    radius: float
    pipe: bool
    specularity: float
    wall_restitution: float
    closures: Mapping[str, BoundClosure]
    # of the eddy viscosity; below 1 on the way from laminar to turbulent gas
    eddies_share: float = 1.0

    def closure_arguments(self, **state: Any) -> dict[str, Any]:
        """Return the arguments of closures at a state."""
        return {
            "e": self.restitution,
            "eps_max": self.eps_max,
            "d_p": self.d_p,
            "mu": self.mu_gas,
            **state,
        }

    def evaluate(self, kind: str, **state: Any) -> Any:
        """Evaluate a closure at a state."""
        return self.closures[kind](**self.closure_arguments(**state))

    @property
    def friction_velocity(self) -> float:
        """Friction velocity of the gas alone [m/s]."""
        diameter = (2.0 if self.pipe else 4.0) * self.radius
        factor = prandtl_friction(self.rho_gas * self.velocity * diameter / self.mu_gas)
        return float(self.velocity * (factor / 8.0) ** 0.5)

    def eddy_viscosity(self, r: Any, shear: Any, eps_s: Any, beta: Any) -> Any:
        """Return the dynamic eddy viscosity per volume of both phases [Pa s], 0
        where no closure is named.
        """
        if "eddy_viscosity" not in self.closures or not self.eddies_share:
            return 0.0
        kinematic = self.evaluate(
            "eddy_viscosity", **self.eddies(r, shear, eps_s, beta)
        )
        return self.eddies_share * (1.0 - eps_s) * self.rho_gas * kinematic

    def eddies(self, r: Any, shear: Any, eps_s: Any, beta: Any) -> dict[str, Any]:
        """Return the arguments of the eddy viscosity."""
        return {
            "y": self.radius - r,
            "radius": self.radius,
            "u_friction": self.friction_velocity,
            "nu": self.mu_gas / self.rho_gas,
            "shear_rate": abs(shear),
            "drag_rate": beta / ((1.0 - eps_s) * self.rho_gas),
            "eps_s": eps_s,
        }

    def relative_pressure(self, eps_s: Any) -> Any:
        """Return the pressure of the particles over rho_s theta [1]."""
        return self.evaluate(
            "granular_pressure",
            eps_s=eps_s,
            g0=self.evaluate("radial_distribution", eps_s=eps_s),
        )

    def fraction(self, ratio: Any) -> Any:
        """Return the eps_s whose pressure over rho_s theta is `ratio`; nan where
        there is none below packing.
        """
        if not hasattr(ratio, "apply"):
            return self._fraction(ratio)[0]
        eps_s, slope = self._fraction(ratio.value)
        return ratio.apply(lambda _: eps_s, lambda _: 1.0 / slope)

    def _fraction(self, ratio: Any) -> tuple[Any, Any]:
        """Return the solids volume fraction and the slope of its pressure.

        Newton's method for ln p over ln(eps_s/(eps_max - eps_s)), which is nearly
        straight at both ends.
        """
        wanted = np.log(np.asarray(ratio, dtype=float))
        x = wanted - np.log(self.eps_max)
        for _ in range(MAX_FRACTION_ITERATIONS):
            eps_s = self.eps_max / (1.0 + np.exp(-x))
            known = self.relative_pressure(eps_s + 1j * COMPLEX_STEP)
            value, slope = known.real, known.imag / COMPLEX_STEP
            miss = np.log(value) - wanted
            if np.all(np.abs(miss) <= FRACTION_TOLERANCE * (1.0 + np.abs(wanted))):
                break
            with np.errstate(all="ignore"):  # no fraction has the pressure: nan
                x = x - miss * value / (slope * eps_s * (1.0 - eps_s / self.eps_max))
        return np.where(
            np.abs(miss) < 1e3 * FRACTION_TOLERANCE * (1.0 + np.abs(wanted)),
            eps_s,
            np.nan,
        ), slope


@dataclass
class Local:
    """State and closures at the points of one domain."""

    eps_s: Any
    g0: Any
    Re: Any
    beta: Any
    mu: Any
    k: Any
    gamma: Any
    production: Any


def local(u: Any, c: Coefficients) -> Local:
    """Return the state and the closures for the unknowns at the points of a domain."""
    eps_s = c.fraction(u.pressure / (c.rho_solid * u.root**2))
    g0 = c.evaluate("radial_distribution", eps_s=eps_s)
    eps, slip = 1.0 - eps_s, np.sqrt((u.u_gas - u.u_solid) ** 2 + MIN_SQUARED_SLIP)
    Re = eps * c.rho_gas * slip * c.d_p / c.mu_gas
    state, scale = {"eps_s": eps_s, "g0": g0}, c.rho_solid * c.d_p * u.root
    return Local(
        eps_s,
        g0,
        Re,
        c.evaluate("drag", Re=Re, eps=eps),
        scale * c.evaluate("granular_viscosity", **state),
        scale * c.evaluate("granular_conductivity", **state),
        c.rho_solid / c.d_p * u.root**3 * c.evaluate("granular_dissipation", **state),
        _production(u, c, state),
    )


def _production(u: Any, c: Coefficients, state: dict[str, Any]) -> Any:
    """Return the granular energy that the slip produces [W/m3]."""
    if "granular_production" not in c.closures:
        return 0.0
    scale = c.mu_gas**2 * (u.u_gas - u.u_solid) ** 2 / (c.rho_solid * c.d_p**3 * u.root)
    return scale * c.evaluate("granular_production", **state)


def residual(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of both momentum balances, granular energy, and the two
    flow rates.
    """
    at = local(u, c)
    drag, shear = at.beta * (u.u_gas - u.u_solid), o.grad(u.u_solid)[0]
    solid = at.mu * shear * o.grad(tests.u_solid)[0]
    solid = (
        solid
        + (at.eps_s * (c.rho_solid * c.gravity - u.gradient) - drag) * tests.u_solid
    )
    energy = 2.0 * at.k * u.root * o.grad(u.root)[0] * o.grad(tests.root)[0]
    energy = (
        energy
        + (at.gamma + 3.0 * at.beta * u.root**2 - at.mu * shear**2 - at.production)
        * tests.root
    )
    flow = (c.rho_solid * at.eps_s * u.u_solid - c.solid_flux) * tests.pressure
    return (
        gas(u, tests, c, o, at.eps_s, at.beta)
        + drag * tests.u_gas
        + solid
        + energy
        + flow
    )


def gas(
    u: Any, tests: Any, c: Coefficients, o: Any, eps_s: Any = 0.0, beta: Any = 0.0
) -> Any:
    """Return the weak form of the momentum of the gas without drag, and of its flow
    rate.
    """
    eps, shear = 1.0 - eps_s, o.grad(u.u_gas)[0]
    momentum = (
        (c.mu_gas + c.eddy_viscosity(o.x[0], shear, eps_s, beta))
        * shear
        * o.grad(tests.u_gas)[0]
    )
    momentum = momentum + eps * (c.rho_gas * c.gravity - u.gradient) * tests.u_gas
    return momentum + (eps * u.u_gas - c.velocity) * tests.gradient


def wall_stress(u: Any, at: Local, c: Coefficients) -> Any:
    """Return the upward stress of the particles on the wall [Pa]."""
    return c.specularity * _wall_factor(u, at, c) * u.u_solid


def wall(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of slip and granular energy at the wall; u_gas is
    prescribed there.
    """
    at = local(u, c)
    stress = wall_stress(u, at, c)
    lost = 1.5 * (1.0 - c.wall_restitution**2) * _wall_factor(u, at, c) * u.root**2
    return stress * tests.u_solid + (lost - stress * u.u_solid) * tests.root


def _wall_factor(u: Any, at: Local, c: Coefficients) -> Any:
    """Return pi sqrt(3) rho_s eps_s g0 sqrt(theta)/(6 eps_max) [kg/m2/s]."""
    return (
        np.pi * 3.0**0.5 * c.rho_solid / (6.0 * c.eps_max) * at.eps_s * at.g0 * u.root
    )


def content(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the tested granular energy, which relaxes in time; all other unknowns
    follow it without delay.
    """
    return (
        1.5
        * c.rho_solid
        * c.fraction(u.pressure / (c.rho_solid * u.root**2))
        * u.root**2
        * tests.root
    )


def prandtl_friction(Re: float) -> float:
    """Return Darcy's friction factor [-] of a smooth pipe: 1/sqrt(f) = 2 log10(Re
    sqrt(f)) - 0.8 (Prandtl 1935).
    """
    inverse_root = 7.0  # of a friction factor of 0.02
    for _ in range(FRICTION_ITERATIONS):
        inverse_root = 2.0 * np.log10(Re / inverse_root) - 0.8
    return float(inverse_root**-2)


def reach_of_fluctuations(c: Coefficients, theta: float) -> float:
    """Return the distance from a wall [m] over which drag stops fluctuations:
    sqrt(k/(3 beta)), evenly spread.
    """
    eps_s = uniform_fraction(c)
    slip = abs(c.velocity / (1.0 - eps_s) - c.solid_flux / (c.rho_solid * eps_s))
    beta = c.evaluate(
        "drag", Re=(1.0 - eps_s) * c.rho_gas * slip * c.d_p / c.mu_gas, eps=1.0 - eps_s
    )
    g0 = c.evaluate("radial_distribution", eps_s=eps_s)
    k = (
        c.rho_solid
        * c.d_p
        * theta**0.5
        * c.evaluate("granular_conductivity", eps_s=eps_s, g0=g0)
    )
    return float((k / (3.0 * beta)) ** 0.5)


def uniform_fraction(c: Coefficients) -> float:
    """Return the eps_s at which the drag on evenly spread particles comes nearest to
    their weight.
    """
    eps_s = np.geomspace(1e-6, 0.9, 400) * c.eps_max
    eps = 1.0 - eps_s
    rise = c.velocity / (1.0 - eps_s) - c.solid_flux / (c.rho_solid * eps_s)
    drag = (
        c.evaluate(
            "drag", Re=eps * c.rho_gas * np.abs(rise) * c.d_p / c.mu_gas, eps=eps
        )
        * rise
    )
    weight = eps * eps_s * (c.rho_solid - c.rho_gas) * c.gravity
    return float(eps_s[np.argmin(np.abs(drag - weight) / (np.abs(drag) + weight))])

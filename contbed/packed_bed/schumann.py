"""A bed at rest without conduction, heated by a stream of constant temperature: closed
form, which leaves fronts sharp.

    C_f (dT_f/dt + v dT_f/dz) = h a (T_s - T_f)          C_f = eps rho_f c_f,   v = u/eps
    C_s dT_s/dt               = h a (T_f - T_s)          C_s = (1-eps) rho_s c_s

With xi = h a z/(C_f v) and tau = h a (t - z/v)/C_s, behind the first fluid that entered,

    T_f - T_s0 = (T_in - T_s0) J(xi, tau)       + integral of g(eta) K(xi - eta, tau)
    T_s - T_s0 = (T_in - T_s0) (1 - J(tau, xi)) + g e^-tau + integral of g(eta) K_s(xi - eta, tau)

over eta from 0 to xi, where J(x, y) = 1 - integral of K(zeta, y) over zeta from 0 to x,

    K = e^(-zeta - tau) I0(2 sqrt(zeta tau)),   K_s = e^(-zeta - tau) sqrt(tau/zeta) I1(2 sqrt(zeta tau))

and g(xi) = (T_f0 - T_s0) r/(1 + r) (1 - e^(-(1 + r) xi)), r = C_f/C_s, is what the fluid
that filled the bed has left in the solid. Ahead of the first fluid both phases come to
one temperature, the same everywhere. 1 - J is a distribution of non-central chi squares.

Source: Schumann, J. Franklin Inst. 208 (1929) 405, doi:10.1016/S0016-0032(29)91186-8.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad_vec
from scipy.special import chndtr, i1e, ive

Array = Any
POINTS = 64  # of a Gauss rule for a smooth function of some units of eta
REACH = 40.0  # exponent beyond which e^-x is below rounding
DIGITS = 1e-12  # of integrals of heat, relative and over the heat that enters


@dataclass(frozen=True)
class Schumann:
    """Temperatures of a bed from its start.

    length : of the bed [m]; velocity : v > 0 of the fluid between particles [m/s]
    capacity_fluid, capacity_solid : per bed volume [J/m3/K]
    exchange : h a [W/m3/K]
    inlet, fluid, solid : temperatures of the stream and of both phases at the start [K]
    """

    length: float
    velocity: float
    capacity_fluid: float
    capacity_solid: float
    exchange: float
    inlet: float
    fluid: float
    solid: float

    def at(self, z: Array, time: Array) -> tuple[Array, Array]:
        """Return the temperatures [K] of fluid and solid at places [m] and times [s]."""
        fluid, solid = self._above(z, time)
        return self.solid + fluid, self.solid + solid

    def _above(self, z: Array, time: Array) -> tuple[Array, Array]:
        """Return both temperatures above that of the solid at the start."""
        z, time = np.broadcast_arrays(np.atleast_1d(z).astype(float), time)
        entered = z <= self.velocity * time
        xi = self.exchange * z / (self.capacity_fluid * self.velocity)
        tau = self.exchange * (time - z / self.velocity) / self.capacity_solid
        T_fluid, T_solid = self._ahead(time)
        T_fluid, T_solid = T_fluid + 0.0 * z, T_solid + 0.0 * z
        behind = self._behind(xi[entered], tau[entered])
        T_fluid[entered], T_solid[entered] = behind
        return T_fluid, T_solid

    def heat(self, time: float) -> dict[str, float]:
        """Return the heat per cross-section [J/m2] that has entered and left with the
        stream, relative to the fluid at the start, and what is stored.
        """
        flow = self.capacity_fluid * self.velocity
        apart = self.fluid - self.solid
        hot = max(abs(self.inlet - self.solid), abs(apart)) or 1.0
        allowed = DIGITS * hot * flow * time
        arrived = min(self.velocity * time, self.length)
        through = min(self.length / self.velocity, time)

        def held(z: float) -> Any:
            return self._held(*self._above(z, time))

        def leaving(now: float) -> Any:
            return flow * (self._above(self.length, now)[0] - apart)

        first = np.nextafter(through, 0.0)
        parts = [(held, 0.0, arrived), (leaving, 0.0, first), (leaving, through, time)]
        stored, *left = (
            quad_vec(what, low, high, allowed, DIGITS, limit=10**5)[0].item()
            for what, low, high in parts
        )
        return {
            "in": flow * time * (self.inlet - self.fluid),
            "out": sum(left),
            "stored": stored + self._held(*self._ahead(time)) * (self.length - arrived),
        }

    def _held(self, T_fluid: Any, T_solid: Any) -> Any:
        """Return the heat held [J/m3] more than at the start, of such temperatures."""
        gained = T_fluid - (self.fluid - self.solid)
        return self.capacity_fluid * gained + self.capacity_solid * T_solid

    def _ahead(self, time: Array) -> tuple[Array, Array]:
        """Return such temperatures where nothing has arrived that entered."""
        C_f, C_s = self.capacity_fluid, self.capacity_solid
        apart = self.fluid - self.solid
        share = -np.expm1(-self.exchange * (1.0 / C_f + 1.0 / C_s) * time) / (C_f + C_s)
        return (1.0 - C_s * share) * apart, C_f * share * apart

    def _behind(self, xi: Array, tau: Array) -> tuple[Array, Array]:
        """Return such temperatures at both coordinates (n,)."""
        tau = np.maximum(tau, 0.0)
        enters = self.inlet - self.solid
        # 1 - J(xi, tau) and 1 - J(tau, xi)
        of_fluid, of_solid = (
            chndtr(2.0 * xi, 2.0, 2.0 * tau),
            chndtr(2.0 * tau, 2.0, 2.0 * xi),
        )
        T_fluid, T_solid = enters * (1.0 - of_fluid), enters * of_solid
        r = self.capacity_fluid / self.capacity_solid
        left = (self.fluid - self.solid) * r / (1.0 + r)
        if left:
            nodes, weights = np.polynomial.legendre.leggauss(POINTS)
            reach = np.minimum(xi, REACH / (1.0 + r))
            eta = reach[:, None] * 0.5 * (1.0 + nodes)
            zeta = xi[:, None] - eta
            root = np.sqrt(zeta * tau[:, None])
            w = 0.5 * reach[:, None] * weights * np.exp(-(1.0 + r) * eta)
            w = w * np.exp(-((np.sqrt(zeta) - np.sqrt(tau)[:, None]) ** 2))
            fluid = (w * ive(0, 2.0 * root)).sum(axis=1)
            # sqrt(tau/zeta) I1(2 root) = 2 tau I1(2 root)/(2 root), finite at root = 0
            ratio = np.where(
                root > 0.0, i1e(2.0 * root) / np.maximum(root, 1e-300), 1.0
            )
            solid = (w * tau[:, None] * ratio).sum(axis=1)
            # those of g = 1, less those of the exponential
            T_fluid = T_fluid + left * (of_fluid - fluid)
            at_once = np.exp(-(1.0 + r) * xi - tau)
            T_solid = T_solid + left * (1.0 - of_solid - at_once - solid)
        return T_fluid, T_solid

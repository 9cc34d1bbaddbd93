"""Exact radiative transfer in a plane gray slab with isotropic scattering: the integral
equation, solved by panels.

With the optical depth t = 0 ... tau, the albedo omega, radiosities J1, J2 of the walls
and S = pi times the source function, all in W/m2 (Modest and Mazumder, Radiative Heat
Transfer, 2022, doi:10.1016/C2018-0-03206-5, chapter 13):

    S(t) = (1 - omega) sigma T^4 + omega G/4
    G(t) = 2 [J1 E2(t) + J2 E2(tau - t) + int_0^tau S(t') E1(|t - t'|) dt']
    q(t) = 2 [J1 E3(t) - J2 E3(tau - t) + int_0^tau S(t') sgn(t - t') E2(|t - t'|) dt']
    J1 = e1 sigma T1^4 + (1 - e1) (J1 - q(0)),   J2 = e2 sigma T2^4 + (1 - e2) (J2 + q(tau))

S has terms t ln t at the walls: the panels shrink geometrically towards both. Each
carries Gauss nodes; a polynomial through them is integrated against the kernel, on near
panels after a substitution that removes the singularity.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike, NDArray
from scipy.special import exp1, expn

Array = NDArray[np.float64]

_ORDER = 14
_NODES, _WEIGHTS = legendre.leggauss(_ORDER)
_FINE, _FINE_WEIGHTS = legendre.leggauss(48)
_POWER = 5
_SMALLEST, _GROWTH, _LARGEST = 1e-6, 3.0, 4.0


class Slab:
    """Nodes and kernel matrices of a slab of optical thickness `tau` [-]; error about
    1e-12 of the wall powers.

    Attributes: `depth`, the nodes 0 < t < tau; `weights`, their quadrature; `incident`
        and `flux`, the matrices that
    take S at the nodes to the integrals with E1 and with sgn E2; `cumulative`, nodal
    values to the integral from 0.
    """

    def __init__(self, tau: float):
        if not tau > 0.0:
            raise ValueError(
                f"slab: the optical thickness must be positive, got {tau:g}"
            )
        self.tau = tau
        self.edges = _edges(tau)
        half = 0.5 * np.diff(self.edges)
        middle = 0.5 * (self.edges[1:] + self.edges[:-1])
        self.depth = (middle[:, None] + half[:, None] * _NODES).ravel()
        self.weights = (half[:, None] * _WEIGHTS).ravel()
        self.incident, self.flux = self.kernels(self.depth)
        before = np.tril(np.ones((len(half), len(half))), -1)
        self.cumulative = np.kron(before, np.ones((_ORDER, _ORDER))) * self.weights
        for panel, width in enumerate(half):
            part = slice(panel * _ORDER, (panel + 1) * _ORDER)
            self.cumulative[part, part] = width * _antiderivative()

    def kernels(self, at: Array) -> tuple[Array, Array]:
        """Return the rows that integrate S against E1(|t - t'|) and sgn(t - t')
        E2(|t - t'|) for each t in `at`.
        """
        distance = at[:, None] - self.depth
        touching = np.isclose(distance, 0.0, atol=0.0)
        size = np.where(touching, 1.0, np.abs(distance))
        incident, flux = (
            exp1(size) * self.weights,
            np.sign(distance) * expn(2, size) * self.weights,
        )
        for panel, (low, high) in enumerate(
            zip(self.edges[:-1], self.edges[1:], strict=True)
        ):
            reach = high - low
            near = np.flatnonzero((at > low - reach) & (at < high + reach))
            columns = slice(panel * _ORDER, (panel + 1) * _ORDER)
            incident[near, columns], flux[near, columns] = _near(at[near], low, high)
        return incident, flux

    def fluxes(self, S: Array, J1: float, J2: float) -> tuple[float, float]:
        """Return q(0) and q(tau) [W/m2] of a source S at the nodes and of the
        radiosities of the walls.
        """
        toward = 2.0 * expn(2, self.depth) * self.weights
        away = 2.0 * expn(2, self.tau - self.depth) * self.weights
        through = 2.0 * float(expn(3, self.tau))
        return J1 - J2 * through - float(toward @ S), J1 * through - J2 + float(
            away @ S
        )

    def respond(
        self, albedo: float, emissivity: tuple[float, float] = (1.0, 1.0)
    ) -> SlabResponse:
        """Return S, J1 and J2 as linear functions of sigma T^4 at the nodes and at the
        walls.

        Parameters
        ----------
        albedo : omega = Ks/beta [-], 0 ... 1; at 1 the source follows G alone, which is
            radiative equilibrium
        emissivity : e1, e2 of the two walls [-], 0 < e <= 1
        """
        count = len(self.depth)
        first, second = emissivity
        near, far = expn(2, self.depth), expn(2, self.tau - self.depth)
        through = 2.0 * float(expn(3, self.tau))
        system = np.eye(count + 2)
        system[:count, :count] -= 0.5 * albedo * self.incident
        system[:count, count] = -0.5 * albedo * near
        system[:count, count + 1] = -0.5 * albedo * far
        system[count, :count] = -(1.0 - first) * 2.0 * near * self.weights
        system[count, count + 1] = -(1.0 - first) * through
        system[count + 1, :count] = -(1.0 - second) * 2.0 * far * self.weights
        system[count + 1, count] = -(1.0 - second) * through
        given = np.concatenate([np.full(count, 1.0 - albedo), [first, second]])
        return SlabResponse(self, np.asarray(np.linalg.solve(system, np.diag(given))))


class SlabResponse:
    """Solution operator of a slab: powers (sigma T^4 at the nodes, then at the two
    walls) to S, J1, J2, G and q.
    """

    def __init__(self, slab: Slab, operator: Array):
        self.slab, self.operator = slab, operator
        walls = np.stack([expn(3, slab.depth), -expn(3, slab.tau - slab.depth)], axis=1)
        self.flux = 2.0 * np.hstack([slab.flux, walls]) @ operator
        walls = np.stack([expn(2, slab.depth), expn(2, slab.tau - slab.depth)], axis=1)
        self.incident = 2.0 * np.hstack([slab.incident, walls]) @ operator

    def wall_fluxes(self, powers: Array) -> tuple[float, float]:
        """Return q(0) and q(tau) [W/m2]."""
        solved = self.operator @ powers
        return self.slab.fluxes(solved[:-2], float(solved[-2]), float(solved[-1]))


@lru_cache(maxsize=32)
def slab(tau: float) -> Slab:
    """Return the slab of optical thickness `tau`, kept for repeated use."""
    return Slab(tau)


class Equilibrium:
    """Slab without heat sources between two walls, dq/dt = 0, for which sigma T^4 = G/4
    at any albedo.

    Parameters
    ----------
    tau : optical thickness [-], > 0
    emissivity : e1, e2 of the walls [-]

    Attributes: `flux`, Psi = q/(sigma T1^4 - sigma T2^4) [-]; `slip`, 1 - Phi(0) [-].
        `profile(t)` is
    Phi = (T^4 - T2^4)/(T1^4 - T2^4) [-]. Source: Heaslet and Warming, Int. J. Heat Mass
    Transfer 8 (1965) 979, doi:10.1016/0017-9310(65)90083-9.
    """

    def __init__(self, tau: float, emissivity: tuple[float, float] = (1.0, 1.0)):
        self.slab = slab(tau)
        count = len(self.slab.depth)
        powers = np.zeros(count + 2)
        powers[count] = 1.0
        solved = self.slab.respond(1.0, emissivity).operator @ powers
        self.source, self.radiosity = (
            solved[:-2],
            (float(solved[-2]), float(solved[-1])),
        )
        self.flux = self.slab.fluxes(self.source, *self.radiosity)[0]
        self.slip = 1.0 - float(self.profile(0.0))

    def profile(self, at: ArrayLike) -> Array:
        """Return Phi at optical depths 0 ... tau of any shape."""
        depth = np.asarray(at, dtype=float)
        flat = depth.ravel()
        kernel, _ = self.slab.kernels(flat)
        first, second = self.radiosity
        walls = first * expn(2, flat) + second * expn(2, self.slab.tau - flat)
        return np.asarray(0.5 * (walls + kernel @ self.source)).reshape(depth.shape)


def slab_emittance(tau: float, albedo: float) -> float:
    """Return the hemispherical emittance [-] of an isothermal slab of thickness `tau`
    in cold black surroundings.

    With omega = 0 it is 1 - 2 E3(tau).
    """
    medium = slab(tau)
    powers = np.ones(len(medium.depth) + 2)
    powers[-2:] = 0.0
    return medium.respond(albedo).wall_fluxes(powers)[1]


def half_space_emittance(albedo: ArrayLike) -> Array:
    """Return the hemispherical emittance [-] of a thick isothermal bed: e = 2
    sqrt(1 - omega) int_0^1 H(mu) mu dmu.

    H is Chandrasekhar's function, ln H(mu) = -(mu/pi) int_0^(pi/2) ln(1 - omega x cot
    x)/(cos^2 x + mu^2 sin^2 x) dx (Radiative Transfer, 1960, chapter V). Gauss nodes
    cluster where mu or x end. Error below 1e-12 for 0 <= omega <= 0.999, 1e-9 at
    1 - 1e-6; omega = 1 emits nothing.
    """
    omega = np.asarray(albedo, dtype=float)[..., None, None]
    if np.any((omega < 0.0) | (omega >= 1.0)):
        raise ValueError("half space: the albedo must lie in 0 <= omega < 1")
    u, weight = 0.5 * (_FINE + 1.0), 0.5 * _FINE_WEIGHTS
    mu, mu_weight = u**3, 3.0 * u**2 * weight
    x = 0.5 * np.pi * u**3 * (4.0 - 3.0 * u)
    x_weight = 0.5 * np.pi * 12.0 * u**2 * (1.0 - u) * weight
    integrand = np.log1p(-omega * x / np.tan(x)) / (
        np.cos(x) ** 2 + (mu[:, None] * np.sin(x)) ** 2
    )
    H = np.exp(-mu / np.pi * (integrand @ x_weight))
    return np.asarray(2.0 * np.sqrt(1.0 - omega[..., 0, 0]) * (H @ (mu * mu_weight)))


def _edges(tau: float) -> Array:
    """Return the edges of panels on 0 ... tau that grow by _GROWTH from both ends up
    to _LARGEST.
    """
    half = 0.5 * tau
    edges = [0.0, min(_SMALLEST, 0.5 * half)]
    while edges[-1] < half:
        edges.append(edges[-1] + min((_GROWTH - 1.0) * edges[-1], _LARGEST))
    if half - edges[-2] < 0.3 * (edges[-2] - edges[-3] if len(edges) > 2 else 0.0):
        edges.pop()
    edges[-1] = half
    left = np.array(edges)
    return np.concatenate([left, tau - left[-2::-1]])


def _near(at: Array, low: float, high: float) -> tuple[Array, Array]:
    """Integrate each Lagrange polynomial times E1 and sgn E2 over a panel, for points
    in or close to the panel.

    The panel is cut at the point, or at its closest end, and s = a u^5 measures the
    distance from the cut.
    """
    u = 0.5 * (_FINE + 1.0)
    step, step_weight = u**_POWER, 0.5 * _FINE_WEIGHTS * _POWER * u ** (_POWER - 1)
    cut = np.clip(at, low, high)
    incident, flux = np.zeros((len(at), _ORDER)), np.zeros((len(at), _ORDER))
    for side, length in ((-1.0, cut - low), (1.0, high - cut)):
        offset = length[:, None] * step
        point = cut[:, None] + side * offset
        distance = np.abs((at - cut)[:, None] - side * offset)
        sign = np.sign((at - cut)[:, None] - side * offset)
        weight = length[:, None] * step_weight
        basis = _lagrange((2.0 * point - low - high) / (high - low))
        safe = np.maximum(distance, 1e-300)
        incident += np.einsum("iq,iqj->ij", weight * exp1(safe), basis)
        flux += np.einsum("iq,iqj->ij", weight * sign * expn(2, safe), basis)
    return incident, flux


_TO_LEGENDRE = (legendre.legvander(_NODES, _ORDER - 1) * _WEIGHTS[:, None]).T * (
    np.arange(_ORDER) + 0.5
)[:, None]


def _lagrange(at: Array) -> Array:
    """Return the Lagrange polynomials of the Gauss nodes at points of -1 ... 1; the
    last axis counts the nodes.
    """
    return np.asarray(legendre.legvander(at, _ORDER - 1) @ _TO_LEGENDRE)


def _antiderivative() -> Array:
    """Return the matrix from nodal values to the integral from -1 to each Gauss
    node.
    """
    u = 0.5 * (_FINE + 1.0)
    points = -1.0 + np.multiply.outer(_NODES + 1.0, u)
    weights = np.multiply.outer(_NODES + 1.0, 0.5 * _FINE_WEIGHTS)
    matrix: Array = np.einsum("iq,iqj->ij", weights, _lagrange(points))
    return matrix

"""Developed Brinkman-Forchheimer flow between parallel walls around a sliding bed.

Eq. 10 of Pivem and de Lemos (2012), doi:10.1016/j.ijheatmasstransfer.2011.11.047, for
u_D = (u(y), 0), where p stands for phi <p>^i, porosity times pressure, and u_s is the
superficial velocity of the bed:

    0 = -dp/dx + mu u'' - [phi mu/K (u - u_s) + c_F phi rho/sqrt(K) |u - u_s| (u - u_s)],   u(0) = u(H) = 0

All drag is relative to the bed; the walls stand still, and the Brinkman term has the
viscosity of the fluid.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from contbed.errors import ConvergenceError

Array = NDArray[np.float64]

_DEGREE = 24
_POINTS = chebyshev.chebpts1(_DEGREE - 1)
_UNIT = np.eye(_DEGREE + 1)
_VALUE = chebyshev.chebvander(_POINTS, _DEGREE)
_CURVATURE = chebyshev.chebvander(_POINTS, _DEGREE - 2) @ chebyshev.chebder(_UNIT, 2)
_LEFT, _RIGHT = chebyshev.chebvander(np.array([-1.0, 1.0]), _DEGREE)
_SLOPE_LEFT, _SLOPE_RIGHT = chebyshev.chebvander(
    np.array([-1.0, 1.0]), _DEGREE - 1
) @ chebyshev.chebder(_UNIT)
_INTEGRAL = np.array(
    [2.0 / (1.0 - k * k) if k % 2 == 0 else 0.0 for k in range(_DEGREE + 1)]
)


@dataclass(frozen=True)
class ChannelFlow:
    """Profile u(y) [m/s] at the requested y, its maximum [m/s], and d(phi
    <p>)/dx [Pa/m].
    """

    u: Array
    u_max: float
    pressure_gradient: float


def brinkman_forchheimer_channel(
    y: ArrayLike,
    height: float,
    mean_velocity: float,
    bed_velocity: float,
    mu: float,
    rho: float,
    permeability: float,
    forchheimer: float,
    porosity: float,
) -> ChannelFlow:
    """Return the developed flow of given mean velocity through a bed that slides along
    the channel.

    Spectral elements on half the channel, graded towards the wall, with one element
    boundary on the kink u = u_s of the drag law wherever the flow passes it; its
    position is an unknown of Newton's method. With c_F = 0 the closed form is returned:
    u = C (1 - cosh(k (y/H - 1/2))/cosh(k/2)), k^2 = phi H^2/K, dp/dx = phi mu/K
    (u_s - C).

    Parameters
    ----------
    y : distance from one wall [m], 0 ... height
    height : H, distance of the walls [m]
    mean_velocity : mean of u [m/s], > 0
    bed_velocity : superficial velocity u_s of the solid [m/s], either sign
    mu, rho : viscosity [Pa s] and density [kg/m3] of the fluid
    permeability : K [m2]
    forchheimer : c_F [-], >= 0
    porosity : phi [-]

    Returns
    -------
    ChannelFlow; u has the shape of y. Error below 1e-14 of the mean velocity, 1e-11 of the pressure gradient.
    """
    if not (
        mean_velocity > 0
        and height > 0
        and mu > 0
        and permeability > 0
        and forchheimer >= 0
    ):
        raise ValueError(
            "channel flow: need mean_velocity, height, mu, permeability > 0 and "
            "forchheimer >= 0, "
            f"got {mean_velocity:g}, {height:g}, {mu:g}, {permeability:g}, "
            f"{forchheimer:g}"
        )
    eta = np.asarray(y, dtype=float) / height
    eta = np.minimum(eta, 1.0 - eta)
    darcy = porosity * height**2 / permeability
    inertia = (
        forchheimer
        * porosity
        * rho
        * mean_velocity
        * height**2
        / (mu * math.sqrt(permeability))
    )
    slip = bed_velocity / mean_velocity
    if inertia:
        u, u_max, gradient = _solve(eta, slip, darcy, inertia)
    else:
        u, u_max, gradient = _darcy_brinkman(eta, slip, darcy)
    return ChannelFlow(
        mean_velocity * u,
        mean_velocity * u_max,
        gradient * mu * mean_velocity / height**2,
    )


def _darcy_brinkman(
    eta: Array, slip: float, darcy: float
) -> tuple[Array, float, float]:
    """Return profile, maximum and pressure gradient without inertia, in units of H,
    mean velocity and mu.
    """
    k = math.sqrt(darcy)

    def deficit(at: Array | float) -> Array:
        return (np.exp(-k * np.asarray(at)) + np.exp(-k * (1.0 - np.asarray(at)))) / (
            1.0 + math.exp(-k)
        )

    core = 1.0 / (1.0 - 2.0 * math.tanh(0.5 * k) / k)
    return (
        core * (1.0 - deficit(eta)),
        core * (1.0 - float(deficit(0.5))),
        darcy * (slip - core),
    )


def _solve(
    eta: Array, slip: float, darcy: float, inertia: float
) -> tuple[Array, float, float]:
    """Solve w'' = P + m r + n |r| r, r = w - slip, w(0) = 0, w'(1/2) = 0, mean 1.

    Units are H, the mean velocity and mu. First over elements that ignore the kink,
    then, if the flow passes r = 0, with an element boundary on it.
    """
    layer = 1.0 / math.sqrt(darcy + 2.0 * inertia * max(abs(slip), abs(1.0 - slip)))
    core = 1.0 - slip
    profile = _Elements(_graded(0.5, layer), np.zeros(0))
    start = profile.fit(lambda at: -np.expm1(-at / layer))
    gradient = -(darcy + inertia * abs(core)) * core
    profile, gradient = _newton(profile, start, gradient, slip, darcy, inertia)
    if 0.0 < slip < profile(np.array(0.5)):
        kink = brentq(lambda at: float(profile(np.array(at))) - slip, 0.0, 0.5)
        split = _Elements(_graded(kink, layer), _graded(0.5 - kink, layer))
        profile, gradient = _newton(
            split, split.fit(profile), gradient, slip, darcy, inertia
        )
    return profile(eta), float(profile(np.array(0.5))), gradient


def _graded(length: float, first: float) -> Array:
    """Return the widths of elements over `length`, doubling from at most `first`."""
    count = max(1, math.ceil(math.log2(length / first + 1.0)))
    widths: Array = length * np.exp2(np.arange(count, dtype=float)) / (2.0**count - 1.0)
    return widths


class _Elements:
    """Chebyshev elements on 0 ... 1/2: those below the kink, then those above it
    (none if it is not tracked).
    """

    def __init__(self, below: Array, above: Array, coefficients: Array | None = None):
        self.below, self.above = below, above
        self.widths = np.concatenate([below, above])
        self.edges = np.concatenate([[0.0], np.cumsum(self.widths)])
        self.coefficients = (
            np.zeros((len(self.widths), _DEGREE + 1))
            if coefficients is None
            else coefficients
        )

    def fit(self, function: Callable[[Array], Array]) -> Array:
        """Return the coefficients of the interpolant of a function of the position."""
        nodes = chebyshev.chebpts1(_DEGREE + 1)
        at = self.edges[:-1, None] + 0.5 * self.widths[:, None] * (1.0 + nodes)
        return np.asarray(
            np.linalg.solve(chebyshev.chebvander(nodes, _DEGREE), function(at).T).T,
            dtype=float,
        )

    def moved(self, shift: float, coefficients: Array) -> _Elements:
        """Return the elements with the kink moved by `shift`, all stretched in
        proportion, and new coefficients.
        """
        if not len(self.above):
            return _Elements(self.below, self.above, coefficients)
        kink = self.below.sum()
        below, above = (
            self.below * (1.0 + shift / kink),
            self.above * (1.0 - shift / (0.5 - kink)),
        )
        return _Elements(below, above, coefficients)

    def __call__(self, at: Array) -> Array:
        """Return the value of the profile at positions of any shape."""
        index = np.clip(
            np.searchsorted(self.edges, at, side="right") - 1, 0, len(self.widths) - 1
        )
        local = np.clip(
            2.0 * (at - self.edges[index]) / self.widths[index] - 1.0, -1.0, 1.0
        )
        modes = np.cos(np.arange(_DEGREE + 1) * np.arccos(local)[..., None])
        profile: Array = np.sum(modes * self.coefficients[index], axis=-1)
        return profile


def _newton(
    elements: _Elements,
    start: Array,
    gradient: float,
    slip: float,
    darcy: float,
    inertia: float,
) -> tuple[_Elements, float]:
    """Solve for the coefficients, the pressure gradient and, where tracked, the
    position of the kink.
    """
    tracked = len(elements.above) > 0
    elements = elements.moved(0.0, start)
    last = math.inf
    for _ in range(60):
        matrix, residual = _linearise(elements, gradient, slip, darcy, inertia)
        step = splu(csc_array(matrix)).solve(-residual)
        count = elements.coefficients.size
        change = step[:count].reshape(elements.coefficients.shape)
        damping = 1.0
        if tracked:
            kink = elements.below.sum()
            damping = min(1.0, 0.5 * min(kink, 0.5 - kink) / max(abs(step[-1]), 1e-300))
        elements = elements.moved(
            damping * step[-1] if tracked else 0.0,
            elements.coefficients + damping * change,
        )
        gradient += damping * step[count]
        size = np.abs(change).max()
        if size < 1e-15 or (size < 1e-11 and size >= 0.5 * last):
            return elements, float(gradient)
        last = size
    raise ConvergenceError(
        f"Brinkman-Forchheimer channel: last change {last:.1e} of the mean velocity at "
        f"u_s/u = {slip:g}, "
        f"phi H^2/K = {darcy:g}, inertia number {inertia:g}; try a larger K or a "
        "smaller c_F"
    )


def _linearise(
    elements: _Elements, gradient: float, slip: float, darcy: float, inertia: float
) -> tuple[Array, Array]:
    """Return Jacobian and residual: momentum in each element, walls, symmetry,
    smooth joints, kink and mean.
    """
    c, widths = elements.coefficients, elements.widths
    below, count, tracked = len(elements.below), len(widths), len(elements.above) > 0
    parts = [(1.0, elements.below), (-1.0, elements.above)]
    stretch = np.concatenate(
        [side * part / part.sum() for side, part in parts if len(part)]
    )
    size, block = c.size, _DEGREE + 1
    matrix, residual = (
        np.zeros((size + 1 + tracked, size + 1 + tracked)),
        np.zeros(size + 1 + tracked),
    )
    relative = c @ _VALUE.T - slip
    sign = (
        np.where(np.arange(count) < below, -1.0, 1.0)[:, None]
        if tracked
        else np.sign(relative)
    )
    force = gradient + darcy * relative + inertia * sign * relative**2
    force_slope = darcy + 2.0 * inertia * sign * relative
    row = 0
    for e, (width, grow) in enumerate(zip(widths, stretch, strict=True)):
        rows, columns = slice(row, row + _DEGREE - 1), slice(e * block, (e + 1) * block)
        scale = 0.25 * width**2
        matrix[rows, columns] = _CURVATURE - scale * force_slope[e][:, None] * _VALUE
        matrix[rows, size] = -scale
        residual[rows] = _CURVATURE @ c[e] - scale * force[e]
        if tracked:
            matrix[rows, -1] = -0.5 * width * grow * force[e]
        row += _DEGREE - 1
    for e in range(count - 1):
        left, right = (
            slice(e * block, (e + 1) * block),
            slice((e + 1) * block, (e + 2) * block),
        )
        matrix[row, left], matrix[row, right] = _RIGHT, -_LEFT
        matrix[row + 1, left], matrix[row + 1, right] = (
            widths[e + 1] * _SLOPE_RIGHT,
            -widths[e] * _SLOPE_LEFT,
        )
        residual[row : row + 2] = matrix[row : row + 2, :size] @ c.ravel()
        if tracked:
            matrix[row + 1, -1] = stretch[e + 1] * (_SLOPE_RIGHT @ c[e]) - stretch[
                e
            ] * (_SLOPE_LEFT @ c[e + 1])
        row += 2
    matrix[row, :block], residual[row] = _LEFT, _LEFT @ c[0]
    matrix[row + 1, size - block : size], residual[row + 1] = (
        _SLOPE_RIGHT,
        _SLOPE_RIGHT @ c[-1],
    )
    matrix[row + 2, :size] = np.outer(widths, _INTEGRAL).ravel()
    residual[row + 2] = matrix[row + 2, :size] @ c.ravel() - 1.0
    if tracked:
        matrix[row + 2, -1] = stretch @ (c @ _INTEGRAL)
        kink = slice((below - 1) * block, below * block)
        matrix[row + 3, kink], residual[row + 3] = _RIGHT, _RIGHT @ c[below - 1] - slip
    return matrix, residual

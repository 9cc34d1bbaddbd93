"""Boundary conditions: walls, symmetry, inlets, pressure outlets, given fields.

Solids cross only inlets, outlets and given fields. A distributor is an inlet without
solids: its superficial velocity is the flux of gas, and eps_s = 0 there, so that it is
not divided by the porosity; solids slip along it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from contbed.errors import SceneError
from contbed.two_fluid.compiled import SMALLEST, Array, Indices, inner, kernel
from contbed.two_fluid.fv.grid import Geometry, Grid

WALL, GIVEN, OUTLET = 0, 1, 2  # kinds of condition on a face
# cosine between the vertical and a normal above which a face is floor or roof
MIN_UPRIGHT = 0.5
# share of its speed with which a wall may move along its normal: rounding
IN_PLANE = 1e-9


@dataclass(frozen=True)
class WallCondition:
    """A wall; with `velocity` [m/s] in its own plane.

    Johnson and Jackson's law takes `specularity`, `restitution` of collisions, and
    `friction`, Coulomb's coefficient.
    """

    gas: Literal["no_slip", "slip"] = "no_slip"
    solid: Literal["no_slip", "slip", "johnson_jackson"] = "no_slip"
    specularity: float = 0.0
    restitution: float = 1.0
    velocity: tuple[float, ...] = ()
    friction: float = 0.0


def symmetry() -> WallCondition:
    """Return the condition of a plane of symmetry, or of the axis."""
    return WallCondition(gas="slip", solid="slip")


@dataclass(frozen=True)
class InletCondition:
    """Gas and solids that enter.

    Gas enters at a superficial `velocity` [m/s] normal to the boundary, solids of
    fraction `eps_s` either with the mass flux `solid_flux` [kg/m2/s] or with the
    velocity `solid_velocity` [m/s]; `theta` [m2/s2] is what they bring.
    """

    velocity: float = 0.0
    eps_s: float = 0.0
    solid_flux: float = 0.0
    solid_velocity: float = 0.0
    theta: float = 0.0


@dataclass(frozen=True)
class OutletCondition:
    """Gas and solids leave freely against a `pressure` [Pa]; gas may come back,
    solids may not.

    Nothing beyond it holds particles that rub, unless it is a roof.
    """

    pressure: float = 0.0


@dataclass(frozen=True)
class GivenFields:
    """Fields given as functions of the position (n, dim): intrinsic velocities (n,
    dim) [m/s], eps_s, theta.
    """

    u_gas: Callable[[Array], Array]
    u_solid: Callable[[Array], Array]
    eps_s: Callable[[Array], Array]
    theta: Callable[[Array], Array]


Condition = WallCondition | InletCondition | OutletCondition | GivenFields


class Side(NamedTuple):
    """The conditions of one phase on each boundary face, nb of them.

    kind : WALL, GIVEN or OUTLET
    flux [m/s] : superficial velocity that is imposed, positive outwards
    u (nb, dim) [m/s] : velocity of the wall, or of what enters
    pores : 1 where what enters has the intrinsic velocity of the cell, its flux over
        its fraction
    slip : 1 free slip, 0 none; -1 Johnson and Jackson
    """

    kind: Indices
    flux: Array
    u: Array
    pores: Array
    slip: Array


class Edge(NamedTuple):
    """Both phases, and what they share: eps_s and theta of what enters, p outside,
    the wall's law for particles.
    """

    gas: Side
    solid: Side
    eps_s: Array
    theta: Array
    p: Array
    specularity: Array
    restitution: Array
    friction: Array


def assemble(grid: Grid, conditions: Mapping[str, Condition], rho_solid: float) -> Edge:
    """Assemble the conditions by boundary name, face by face.

    Raises
    ------
    SceneError : a boundary without a condition, a condition without a boundary, solids
        that enter without fraction
    """
    known = ", ".join(sorted(grid.boundaries))
    missing, extra = (
        set(grid.boundaries) - set(conditions),
        set(conditions) - set(grid.boundaries),
    )
    problems = [
        f"boundary.{name}: missing; every boundary needs a condition"
        for name in sorted(missing)
    ]
    problems += [
        f"boundary.{name}: no such boundary; the mesh has {known}"
        for name in sorted(extra)
    ]
    for name, c in conditions.items():
        if (
            isinstance(c, InletCondition)
            and (c.solid_flux or c.solid_velocity)
            and not 0 < c.eps_s < 1
        ):
            problems.append(
                f"boundary.{name}: solids enter with eps_s = {c.eps_s}; give 0 < eps_s "
                "< 1"
            )
        if isinstance(c, WallCondition) and c.velocity:
            speed = grid.geometry.normal[grid.boundaries[name]][
                :, : len(c.velocity)
            ] @ np.array(c.velocity)
            if np.abs(speed).max() > IN_PLANE * np.abs(c.velocity).max():
                problems.append(
                    f"boundary.{name}: a wall moves in its own plane only, found "
                    f"velocity {c.velocity}"
                )
    if problems:
        raise SceneError(problems)
    nb, dim = len(grid.geometry.left) - grid.interior, grid.dimension

    def side() -> Side:
        return Side(
            np.zeros(nb, dtype=np.int64),
            np.zeros(nb),
            np.zeros((nb, dim)),
            np.zeros(nb),
            np.zeros(nb),
        )

    edge = Edge(side(), side(), *(np.zeros(nb) for _ in range(6)))
    for name, c in conditions.items():
        faces = grid.boundaries[name]
        _fill(
            edge,
            faces - grid.interior,
            c,
            grid.geometry.normal[faces],
            grid.middles[faces],
            rho_solid,
        )
    return edge


def _fill(
    edge: Edge,
    at: Indices,
    c: Condition,
    normal: Array,
    position: Array,
    rho_solid: float,
) -> None:
    gas, solid = edge.gas, edge.solid
    if isinstance(c, WallCondition):
        velocity = np.zeros(normal.shape[1])
        velocity[: len(c.velocity)] = c.velocity
        gas.u[at] = solid.u[at] = velocity
        gas.slip[at] = c.gas == "slip"
        solid.slip[at] = {"no_slip": 0.0, "slip": 1.0, "johnson_jackson": -1.0}[c.solid]
        edge.specularity[at], edge.restitution[at], edge.friction[at] = (
            c.specularity,
            c.restitution,
            c.friction,
        )
    elif isinstance(c, OutletCondition):
        gas.kind[at] = solid.kind[at] = OUTLET
        edge.p[at] = c.pressure
    elif isinstance(c, InletCondition):
        gas.kind[at], gas.flux[at], gas.pores[at] = GIVEN, -c.velocity, 1.0
        solid.slip[at] = 1.0
        if c.eps_s > 0:
            speed = c.solid_velocity or c.solid_flux / (rho_solid * c.eps_s)
            solid.kind[at], solid.flux[at], solid.u[at] = (
                GIVEN,
                -c.eps_s * speed,
                -speed * normal,
            )
            edge.eps_s[at], edge.theta[at] = c.eps_s, c.theta
    else:
        gas.kind[at] = solid.kind[at] = GIVEN
        gas.u[at], solid.u[at] = c.u_gas(position), c.u_solid(position)
        edge.eps_s[at], edge.theta[at] = c.eps_s(position), c.theta(position)
        gas.flux[at] = (1 - edge.eps_s[at]) * (gas.u[at] * normal).sum(axis=1)
        solid.flux[at] = edge.eps_s[at] * (solid.u[at] * normal).sum(axis=1)


@inner
def speed_through(g: Geometry, side: Side, b: int, u: Array) -> float:
    """Velocity u (nc, dim) of the cell at boundary face b against the wall, along the
    normal.
    """
    f = len(g.right) + b
    found = 0.0
    for k in range(len(g.axes)):
        found += (u[g.left[f], k] - side.u[b, k]) * g.normal[f, k]
    return found


@kernel
def boundary_velocity(
    g: Geometry, side: Side, slip: Array, u: Array, eps: Array, out: Array
) -> None:
    """Velocity `out` (nb, dim) of a phase at the boundary: what walls leave of that u
    (nc, dim) of cells, or given.

    `slip` (nb,) is the share of the tangential velocity that a wall leaves, `eps` (nc,)
    the fraction of the phase.
    """
    ni, dim = len(g.right), len(g.axes)
    for b in range(len(side.kind)):
        f = ni + b
        c = g.left[f]
        if side.kind[b] == WALL:
            away = speed_through(g, side, b, u)
            for k in range(dim):
                along = u[c, k] - side.u[b, k] - away * g.normal[f, k]
                out[b, k] = side.u[b, k] + slip[b] * along
        elif side.kind[b] == GIVEN:
            for k in range(dim):
                out[b, k] = (
                    side.flux[b] / eps[c] * g.normal[f, k]
                    if side.pores[b] > 0
                    else side.u[b, k]
                )
        else:
            for k in range(dim):
                out[b, k] = u[c, k]


class Particles(NamedTuple):
    """Particles in the cells: density [kg/m3], packing limit, fraction, granular
    temperature, radial distribution.
    """

    rho: float
    eps_max: float
    eps_s: Array
    theta: Array
    g0: Array


@kernel
def wall_slip(
    g: Geometry,
    edge: Edge,
    particles: Particles,
    mu: Array,
    p_friction: Array,
    u: Array,
    slip: Array,
) -> None:
    """Share `slip` (nb,) of the cell's tangential velocity u (nc, dim) that particles
    keep at the wall.

    Johnson and Jackson (1987, J. Fluid Mech. 176, 67-93): with the velocity u_w at the
    wall, what particles bring by collisions and by friction, (pi/6) sqrt(3) specularity
    rho_s eps_s g0 sqrt(theta) u_w/eps_max + friction p_friction, equals mu
    (u - u_w)/distance. Where that would turn u_w around they stick, as friction only
    opposes.
    """
    ni, dim = len(g.right), len(g.axes)
    for b in range(len(slip)):
        slip[b] = edge.solid.slip[b]
        if slip[b] < 0.0:
            c = g.left[ni + b]
            agitation = (
                np.pi
                * np.sqrt(3.0 * particles.theta[c])
                * edge.specularity[b]
                * particles.rho
            )
            collisions = (
                agitation
                * particles.eps_s[c]
                * particles.g0[c]
                / (6.0 * particles.eps_max)
            )
            viscous, rubbing = (
                mu[c] / g.distance[ni + b],
                edge.friction[b] * p_friction[c],
            )
            slip[b] = (
                viscous / (viscous + collisions + SMALLEST) if collisions > 0.0 else 1.0
            )
            if rubbing > 0.0:
                away, along = speed_through(g, edge.solid, b, u), 0.0
                for k in range(dim):
                    along += (
                        u[c, k] - edge.solid.u[b, k] - away * g.normal[ni + b, k]
                    ) ** 2
                slip[b] = max(
                    0.0,
                    slip[b]
                    - rubbing / ((viscous + collisions) * np.sqrt(along) + SMALLEST),
                )

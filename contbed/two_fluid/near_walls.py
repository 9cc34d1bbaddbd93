"""Factors near walls on the drag, the pressure and the viscosity of particles in cells
that do not resolve clusters.

Walls are those beside the flow: the ones that gravity is along. The distance of a cell
is that from the plane of the nearest face of such a wall.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from contbed.two_fluid.closures import terminal_velocity
from contbed.two_fluid.rheology import Closures, Rheology

if TYPE_CHECKING:
    from contbed.two_fluid import scene as t
    from contbed.two_fluid.closures import Bound
    from contbed.two_fluid.compiled import Array
    from contbed.two_fluid.fv.grid import Grid

# |n_last| of faces below which a wall is beside the flow, and not below or above it
BESIDE = 0.5


def distances(scene: t.TwoFluidScene, grid: Grid) -> Array:
    """Distance (nc,) [m] of the cells from the walls beside the flow, infinite
    without any.
    """
    from scipy.spatial import cKDTree

    walls = [
        grid.boundaries[name]
        for name, part in scene.boundary.items()
        if part.type == "wall"
    ]
    faces = np.concatenate(walls) if walls else np.empty(0, dtype=np.int64)
    normal = grid.geometry.normal[faces]
    beside = np.abs(normal[:, -1]) < BESIDE
    if grid.dimension == 1 or not beside.any():
        return np.full(len(grid.cells), np.inf)
    normal, middles = normal[beside], grid.middles[faces[beside]]
    _, nearest = cKDTree(middles).query(grid.centres)
    found: Array = np.abs(
        np.einsum("cd,cd->c", grid.centres - middles[nearest], normal[nearest])
    )
    return found


def wall_froude(scene: t.TwoFluidScene, grid: Grid) -> Array:
    """Distance (nc,) from the walls beside the flow times gravity over the square of
    the terminal velocity [-].
    """
    settling = terminal_velocity(scene.two_fluid.gravity, scene.fluid, scene.solid)
    return distances(scene, grid) * scene.two_fluid.gravity / settling**2


def corrected(
    closures: Closures, bound: Bound, scene: t.TwoFluidScene, grid: Grid
) -> Closures:
    """Closures of a step with the factors near walls that the scene chooses; the
    same where it chooses none.
    """
    chosen = any(bound[kind] is not None for kind in KINDS)
    return (
        with_factors(closures, bound, wall_froude(scene, grid)) if chosen else closures
    )


def with_factors(closures: Closures, bound: Bound, at: Array) -> Closures:
    """Closures with the factors of cells at the distances `at` (nc,) of
    `wall_froude`.
    """
    chosen = {kind: closure for kind in KINDS if (closure := bound[kind]) is not None}
    factors = {kind: closure(wall_froude=at) for kind, closure in chosen.items()}
    closures = replace(closures, wall_froude=at)
    if (of_drag := factors.get("wall_drag")) is not None:
        plain = closures.drag
        closures = replace(
            closures, drag=lambda eps_s, slip: of_drag * plain(eps_s, slip)
        )
    of_pressure, of_viscosity = (
        factors.get("wall_pressure", 1.0),
        factors.get("wall_viscosity", 1.0),
    )
    if len(factors) == 1 and of_drag is not None:
        return closures
    theory, packing = closures.granular, closures.packing

    def granular(eps_s: Array, theta: Array, K: Array) -> Rheology:
        """Stress of the particles, its pressure and viscosity with their factors,
        friction as it is.
        """
        r = theory(eps_s, theta, K)
        friction = friction_stiffness(eps_s, packing)
        return r._replace(
            pressure=of_pressure * r.pressure,
            stiffness=of_pressure * (r.stiffness - friction) + friction,
            mu=of_viscosity * r.mu,
        )

    return replace(closures, granular=granular)


def friction_stiffness(eps_s: Array, packing: tuple[float, float, Array]) -> Array:
    """Slope d p_friction/d eps_s/rho_s (nc,) [m2/s2] by the table of a packing, as
    `closure_kernels` has it.
    """
    first, spacing, p = packing
    # fractions that are no numbers are found, with their place, at the end of the step
    number = np.clip(
        ((np.nan_to_num(eps_s) - first) / spacing).astype(np.int64), 0, len(p) - 2
    )
    middle = first + (number + 0.5) * spacing
    return np.where(
        eps_s > first, eps_s * (p[number + 1] - p[number]) / (middle * spacing), 0.0
    )


KINDS = {
    "wall_drag": "drag",
    "wall_pressure": "granular_pressure",
    "wall_viscosity": "granular_viscosity",
}
"""Kinds of the closures, which are their keys in [closures] as well, and what each multiplies."""

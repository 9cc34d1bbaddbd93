"""Velocities at the nodes of an inlet: along its normals, where it is curved, and along
the walls beside it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.arrays import Array, Integers
from contbed.fem.skfem import System
from contbed.packed_bed.equations import porous_flow

PARALLEL = 1e-9  # a wall counts as parallel to a direction below this sine


def inward_normals(system: System, name: str) -> tuple[Integers, Array]:
    """Return the numbers of the unknowns of the velocity on a boundary (dim, n), and
    the inward unit normals there: of each node the mean of the facets around it.
    """
    mesh, space = system.mesh, system.fields["u"][0]
    facets = mesh.boundaries[name]
    nodes = space.on_facets(facets)
    normals = np.zeros((mesh.dim(), len(nodes)))
    for facet, normal in zip(facets, _outward(mesh, facets), strict=True):
        places = np.searchsorted(nodes, space.on_facets(np.array([facet])))
        normals[:, places] -= normal[:, None]
    numbers = np.array([nodes + system.offset["u", k] for k in range(mesh.dim())])
    return numbers, normals / np.linalg.norm(normals, axis=0)


def mean_speed(system: System, names: list[str], velocities: Array) -> float:
    """Return the mean speed into boundaries of velocities at all nodes [m/s]; those
    that are not given are NaN.
    """
    parts = [part for name in names for part in system.boundary(name)]
    if not parts:
        return 0.0
    area = sum(float(np.sum(part.weight)) for part in parts)
    state = np.nan_to_num(velocities)
    return -float(system.integrate(porous_flow.volume_flow, parts, state)) / area


def turn_along(
    system: System, inlets: list[str], walls: list[str], velocities: Array
) -> bool:
    """Turn velocities at nodes of inlets on walls along these, which nothing crosses;
    return whether any crossed.
    """
    crossed = False
    entering = [system.nodes("u", system.mesh.boundaries[name]) for name in inlets]
    for name in walls:
        numbers, normals = inward_normals(system, name)
        shared = np.isin(numbers[0], np.concatenate([[], *entering]))
        numbers, normals = numbers[:, shared], normals[:, shared]
        across = np.sum(velocities[numbers] * normals, axis=0)
        speeds = np.linalg.norm(velocities[numbers], axis=0)
        found = np.abs(across) > PARALLEL * speeds
        velocities[numbers[:, found]] -= (across * normals)[:, found]
        crossed = crossed or bool(found.any())
    return crossed


def _outward(mesh: Any, facets: Any) -> Array:
    """Return the outward normals of facets times their size, one a row."""
    corners = mesh.p[:, mesh.facets[:, facets]]
    first, second = corners[:, 0], corners[:, 1]
    along = second - first
    normals = np.array([along[1], -along[0]])
    if mesh.dim() == 3:
        normals = np.cross(along, corners[:, 2] - first, axis=0)
    cells = mesh.t[:, mesh.f2t[0, facets]]
    inside = mesh.p[:, cells].mean(axis=1) - first
    sign = np.where(np.sum(inside * normals, axis=0) > 0.0, -1.0, 1.0)
    return np.asarray((sign * normals).T)

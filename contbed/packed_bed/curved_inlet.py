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


def inward_normals(system: System, facets: Integers) -> tuple[Integers, Array]:
    """Return the numbers of the unknowns of the velocity on facets (dim, n), and the
    inward unit normals there: of each node the mean of the facets around it.
    """
    mesh, space = system.mesh, system.fields["u"][0]
    nodes = space.on_facets(facets)
    normals = np.zeros((mesh.dim(), len(nodes)))
    for facet, normal in zip(facets, outward_normals(mesh, facets), strict=True):
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
    crossed, mesh = False, system.mesh
    entering = [mesh.boundaries[name] for name in inlets]
    if not entering:
        return False
    inlet = np.concatenate(entering)
    nodes, corners = system.nodes("u", inlet), np.unique(mesh.facets[:, inlet])
    for name in walls:
        facets = mesh.boundaries[name]
        beside = np.isin(mesh.facets[:, facets], corners).any(axis=0)
        numbers, normals = inward_normals(system, facets[beside])
        shared = np.isin(numbers[0], nodes)
        numbers, normals = numbers[:, shared], normals[:, shared]
        across = np.sum(velocities[numbers] * normals, axis=0)
        speeds = np.linalg.norm(velocities[numbers], axis=0)
        found = np.abs(across) > PARALLEL * speeds
        velocities[numbers[:, found]] -= (across * normals)[:, found]
        crossed = crossed or bool(found.any())
    return crossed


def outward_normals(mesh: Any, facets: Integers) -> Array:
    """Return the outward normals of facets times their size, one a row."""
    corners = mesh.p[:, mesh.facets[:, facets]]
    first = corners[:, 0]
    along = corners[:, -1] - first
    normals = np.ones_like(first)
    if mesh.dim() == 2:
        normals = np.array([along[1], -along[0]])
    elif mesh.dim() == 3:
        normals = np.cross(along, corners[:, 1] - first, axis=0)
    cells = mesh.t[:, mesh.f2t[0, facets]]
    inside = mesh.p[:, cells].mean(axis=1) - first
    sign = np.where(np.sum(inside * normals, axis=0) > 0.0, -1.0, 1.0)
    return np.asarray((sign * normals).T)

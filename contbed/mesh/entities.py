"""Facets and edges of meshes of rectangles and bricks, numbered as scikit-fem does, but
without sorting all of them.

Each is known by its node with the smallest number and the axes that it spans;
scikit-fem orders them by their nodes. Sorting takes ten times the memory of the lists.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import skfem
from numpy.typing import NDArray

from contbed.mesh.tensor import CORNERS, ORDERS, places, strides

Numbers = NDArray[np.int32]
LISTS = ("_facets", "_t2f", "_f2t", "_edges", "_t2e")  # where scikit-fem keeps them


def with_lists(mesh: skfem.Mesh) -> skfem.Mesh:
    """Return a mesh as `init_tensor` builds it with its facets and edges, where it
    has rectangles or bricks.
    """
    if isinstance(mesh, skfem.MeshQuad1 | skfem.MeshHex1):
        shape, dim = np.array([len(np.unique(x)) for x in mesh.p]), mesh.dim()
        mesh._facets, mesh._t2f = _entities(
            mesh, shape, dim - 1, mesh.elem.refdom.facets
        )
        mesh._f2t = _cells_of(mesh._t2f, mesh._facets.shape[1])
        if dim == 3:
            mesh._edges, mesh._t2e = _entities(mesh, shape, 1, mesh.elem.refdom.edges)
    return mesh


def renamed(mesh: skfem.Mesh, **names: Any) -> skfem.Mesh:
    """Return a mesh with other names of boundaries or regions and the same facets
    and edges.
    """
    new = replace(mesh, **names)
    for name in LISTS:
        if hasattr(mesh, name):
            setattr(new, name, getattr(mesh, name))
    return new


def _entities(
    mesh: skfem.Mesh, shape: Any, spanned: int, of_cell: Any
) -> tuple[Numbers, Numbers]:
    """Return the nodes of all facets or edges, which span so many axes, and their
    numbers in each cell.
    """
    order = ORDERS[len(shape)]
    step, at = strides(shape, order), places(np.arange(np.prod(shape)), shape, order)
    kinds = [frozenset(axes) for axes in combinations(order, spanned)]
    there = np.stack(
        [(at[:, list(kind)] < shape[list(kind)] - 1).all(axis=1) for kind in kinds],
        axis=1,
    )
    number = np.cumsum(there, dtype=np.int32).reshape(there.shape) - 1
    corners = np.array(CORNERS[len(shape)])
    found = np.empty((len(of_cell), mesh.nelements), dtype=np.int32)
    nodes = np.empty((2**spanned, number[-1, -1] + 1), dtype=np.int32)
    # the first cell that has one gives the order of its nodes
    for i, local in reversed([*enumerate(of_cell)]):
        lowest = min(local, key=lambda c: corners[c] @ step)
        kind = frozenset(np.flatnonzero(np.ptp(corners[local], axis=0)).tolist())
        found[i] = number[mesh.t[lowest], kinds.index(kind)]
        nodes[:, found[i]] = mesh.t[local]
    if spanned == 1:
        nodes.sort(axis=0)
    return nodes, found


def _cells_of(facets: Numbers, count: int) -> Numbers:
    """Return the first and the second cell of each facet (2, count), -1 where there
    is no second one.
    """
    found = np.full((2, count), -1, dtype=np.int32)
    cells = np.arange(facets.shape[1], dtype=np.int32)
    for mine in facets:
        found[1, mine] = cells
    for mine in facets[::-1]:
        found[0, mine] = cells
    found[1, found[0] == found[1]] = -1
    return found

"""A mesh with named boundaries and regions, and its uniform refinement.

Lengths in m. Every exterior facet belongs to exactly one named boundary and every cell
to exactly one region.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import skfem


class MeshEngine(NamedTuple):
    """What assembles and solves on a mesh: a `fem.skfem.System` and a
    `solvers.linear.Policy`, or classes like them.
    """

    system: Callable[..., Any]
    policy: Callable[..., Any]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh, its names and its coordinates; first-order geometry.

    Parameters
    ----------
    skfem : mesh with `boundaries` (exterior facets by name) and `subdomains` (cells by
        region)
    axisymmetric : coordinates are (r, z) with r >= 0
    axis : index of the bed axis coordinate
    engine : what assembles and solves on it; None: scikit-fem on this process
    """

    skfem: skfem.Mesh
    axisymmetric: bool = False
    axis: int = 0
    engine: MeshEngine | None = None

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Names of the boundaries."""
        return tuple(self.skfem.boundaries)

    @property
    def regions(self) -> tuple[str, ...]:
        """Names of the regions."""
        return tuple(self.skfem.subdomains)

    def measure(self, boundary: str | None = None) -> float:
        """Return the size of the mesh, or of one boundary.

        Returns
        -------
        length [m], area [m2] or volume [m3] by dimension, one less for a boundary (1 for the end of a line);
        with the weight 2 pi r when axisymmetric
        """
        # order 4 is exact: a trilinear map has a determinant of degree 2 in each
        # direction, and r adds one in 2-D
        if boundary is None:
            basis = skfem.CellBasis(self.skfem, self.skfem.elem(), intorder=4)
        else:
            facets = self.skfem.boundaries[boundary]
            basis = skfem.FacetBasis(
                self.skfem, self.skfem.elem(), facets=facets, intorder=4
            )
        weight = (
            2 * np.pi * np.asarray(basis.global_coordinates())[0]
            if self.axisymmetric
            else 1.0
        )
        return float(np.sum(basis.dx * weight))


def refine(mesh: Mesh, times: int = 1) -> Mesh:
    """Return the mesh with every cell split `times` times into 2, 4 or 8; boundary
    and region names stay.
    """
    fine = mesh.skfem
    for _ in range(times):
        fine = _refined(fine)
    return replace(mesh, skfem=fine)


def _refined(old: skfem.Mesh) -> skfem.Mesh:
    """Refine uniformly once, with the names that scikit-fem 12 loses or misplaces."""
    # without boundaries scikit-fem does not warn that it loses them in 3-D
    new = old.refined() if old.dim() < 3 else replace(old, _boundaries=None).refined()
    if old.dim() == 1:
        # scikit-fem interleaves the two halves of a line cell but numbers the
        # subdomains as if it did not
        named = {
            name: np.sort(np.hstack((2 * cells, 2 * cells + 1)))
            for name, cells in old.subdomains.items()
        }
        return replace(new, _subdomains=named)
    if old.dim() == 3:
        children = _facet_children(old, new)
        boundaries = {
            name: np.sort(children[:, facets].ravel())
            for name, facets in old.boundaries.items()
        }
        return replace(new, _boundaries=boundaries)
    return new


def _facet_children(old: skfem.Mesh, new: skfem.Mesh) -> np.ndarray:
    """Return the four facets of the refined 3-D mesh in each facet of the old one, (4,
    number of old facets).

    scikit-fem numbers the new nodes: old nodes, middles of edges, and for hexahedra
    middles of facets.
    """
    middle_of_edge = old.p.shape[1] + old.t2e
    middle_of_facet = old.p.shape[1] + old.edges.shape[1] + old.t2f
    triangles = isinstance(old, skfem.MeshTet)
    children = np.empty((4, old.facets.shape[1]), dtype=np.int64)
    for i, corners in enumerate(old.elem.refdom.facets):
        edges = {
            j: set(edge)
            for j, edge in enumerate(old.elem.refdom.edges)
            if set(edge) <= set(corners)
        }
        for k, corner in enumerate(corners):
            nodes = [
                old.t[corner],
                *(middle_of_edge[j] for j, edge in edges.items() if corner in edge),
            ]
            if not triangles:
                nodes.append(middle_of_facet[i])
            children[k, old.t2f[i]] = find_facets(new, np.array(nodes))
        if triangles:
            children[3, old.t2f[i]] = find_facets(new, middle_of_edge[list(edges)])
    return children


def find_facets(mesh: skfem.Mesh, nodes: np.ndarray) -> np.ndarray:
    """Return the index of the facet with these nodes, (nodes of a facet, n) -> (n,);
    -1 where there is none.
    """
    count = mesh.facets.shape[1]
    both = np.hstack((np.sort(mesh.facets, axis=0), np.sort(nodes, axis=0)))
    _, rank = np.unique(both, axis=1, return_inverse=True)
    facet_of_rank = np.full(rank.max() + 1, -1)
    facet_of_rank[rank[:count]] = np.arange(count)
    return facet_of_rank[rank[count:]]

"""Two-level preconditioner of diffusive fields in 3-D: relaxation on the mesh,
correction on its vertices.

A cycle is one Gauss-Seidel sweep forward, a correction by the Galerkin matrix P' A P,
and one sweep backward. The columns of P are the piecewise linear functions of the
vertices, the fields of a vertex side by side, because exchange binds them. The matrix
on the vertices, an eighth in size for elements of degree 2, is replaced by one cycle of
smoothed aggregation (Vanek, Mandel & Brezina, Computing 56 (1996) 179,
doi:10.1007/BF02238511) on these blocks.

With two temperatures of degree 2 on hexahedra the iterations of GMRES stay at 13 to 20
from 30 000 to 200 000 unknowns, and time and memory grow with their number; factors
grow as n^2 and n^(4/3). Cells longer than about ten times their width take more
iterations, 60 and beyond at thirty times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

# a_ij^2 over a_ii a_jj above which two vertices are aggregated; 0.02 and 0.1 take
# longer
STRENGTH = 0.05
COARSEST = 500  # unknowns that are solved by a pseudo-inverse


@dataclass(frozen=True)
class Vertices:
    """Interpolation from the vertices: `matrix` (size, nvertices * fields), fields
    of a vertex side by side.
    """

    matrix: sp.csr_matrix
    fields: int


def two_level(matrix: sp.csr_matrix, vertices: Vertices) -> Callable[[Any], Any]:
    """Return the preconditioner of a matrix (size, size), whose fields follow each
    other, as a function of a vector.

    Rows are multiplied by the inverse of the fields' block at each node, so that the
    sweeps relax all fields of a node at once.
    """
    from pyamg.relaxation.relaxation import gauss_seidel

    up, blocks = vertices.matrix, vertices.fields
    scale, unscale = _blocks(matrix, blocks)
    scaled = (scale @ matrix).tocsr()
    coarse = (up.T @ (matrix @ up)).tobsr((blocks, blocks))
    coarse.sort_indices()
    down = (up.T @ unscale).tocsr()
    constants = np.tile(np.eye(blocks), (coarse.shape[0] // blocks, 1))
    cycle = aggregation_cycle(coarse, "nonsymmetric", "block_gauss_seidel", constants)

    def apply(rhs: Any) -> Any:
        b, x = scale @ rhs, np.zeros_like(rhs)
        gauss_seidel(scaled, x, b, sweep="forward")
        x += up @ cycle.matvec(down @ (b - scaled @ x))
        gauss_seidel(scaled, x, b, sweep="backward")
        return x

    return apply


def aggregation_cycle(
    matrix: Any, symmetry: str, sweep: str, constants: Any = None
) -> Any:
    """Return one cycle of smoothed aggregation as an operator; `constants` are the
    fields that a matrix without boundaries maps to zero, one of ones if not given.
    """
    from pyamg import smoothed_aggregation_solver

    return smoothed_aggregation_solver(
        matrix,
        B=constants,
        symmetry=symmetry,
        strength=("symmetric", {"theta": STRENGTH}),
        # local weights need no spectral radius, whose estimate starts at random
        smooth=("jacobi", {"omega": 4.0 / 3.0, "weighting": "local"}),
        presmoother=(sweep, {"sweep": "forward"}),
        postsmoother=(sweep, {"sweep": "backward"}),
        max_coarse=COARSEST,
        improve_candidates=None,
    ).aspreconditioner()


def _blocks(matrix: sp.csr_matrix, fields: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Return the inverses of the diagonal blocks of all nodes as a matrix, and the
    blocks themselves.
    """
    nodes = matrix.shape[0] // fields
    parts = [
        [
            matrix[i * nodes : (i + 1) * nodes, j * nodes : (j + 1) * nodes].diagonal()
            for j in range(fields)
        ]
        for i in range(fields)
    ]
    inverse = np.moveaxis(np.linalg.inv(np.moveaxis(np.array(parts), -1, 0)), 0, -1)
    diagonals = (
        [[sp.diags(values) for values in row] for row in block]
        for block in (inverse, parts)
    )
    scale, unscale = (sp.bmat(block, format="csr") for block in diagonals)
    return scale, unscale

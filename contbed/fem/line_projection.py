"""Fields on the cells of a line as their least-squares polynomials on other cells."""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.fem.line_dg import Line


def projected(line: Line, values: Array, onto: Line) -> Array:
    """Return fields (..., N, p + 1) on other cells, whose line has the same ends and
    degree.

    The integral over each of these cells is that of the fields; where a cell lies
    within one of those before, so are the values. Where a field is as in most of the
    line it stays to the last bit.
    """
    most = np.median(values, axis=(-2, -1), keepdims=True)
    ends = np.union1d(line.vertices, onto.vertices)
    h, middle = np.diff(ends)[:, None], 0.5 * (ends[1:] + ends[:-1])
    # products with test functions have degree 2 p, for which these are exact
    x = ends[:-1, None] + h * line.nodes
    own, other = (np.searchsorted(each.vertices, middle) - 1 for each in (line, onto))
    basis, test = (
        each.basis(
            ((x - each.vertices[cell, None]) / each.h[cell, None]).ravel()
        ).reshape(*x.shape, -1)
        for each, cell in ((line, own), (onto, other))
    )
    at = np.einsum("...cj,cqj->...cq", (values - most)[..., own, :], basis) * (
        h * line.weights
    )
    parts = np.einsum("...cq,cqk->...ck", at, test)
    total = np.add.reduceat(
        parts, np.searchsorted(other, np.arange(onto.cells)), axis=-2
    )
    found: Array = most + total / (onto.weights * onto.h[:, None])
    return found

"""The inside of a sphere by shells of polynomials that become thin towards its surface,
for reaction in a thin layer.

    (D/R^2) sum_j K_ij c_j = w_i S_i     at points inside,  c given at the surface

Continuous polynomials of degree 4 in each shell at Gauss-Lobatto points, r/R between
the depths of `EDGES` below the surface, tested with themselves and integrated at these
points: w are weights of the mean over the volume, K is symmetric and its rows sum to 0.
First order is exact to 2e-4 of the effectiveness up to a Thiele modulus of 1000.

Source: Canuto, Hussaini, Quarteroni, Zang 2006, Spectral Methods, ch. 2 and 5,
    doi:10.1007/978-3-540-30726-6.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.special import roots_jacobi

from contbed.particle.interior import Interior, differentiation

# depths of the ends of shells below the surface, over R
EDGES = (1.0, 0.4, 0.13, 0.04, 0.012, 0.003, 0.0)
DEGREE = 4


@lru_cache(maxsize=1)
def shells() -> Interior:
    """Return points and matrices.

    >>> points = shells()
    >>> len(points.radii), round(float(points.weights.sum()), 12)
    (25, 1.0)
    """
    legendre = np.polynomial.legendre.Legendre.basis(DEGREE)
    # where the slope of legendre is 0
    nodes = np.concatenate([[-1.0], roots_jacobi(DEGREE - 1, 1.0, 1.0)[0], [1.0]])
    quadrature = 2.0 / (DEGREE * (DEGREE + 1) * legendre(nodes) ** 2)
    at_nodes = differentiation(nodes).T  # (polynomial, node)
    ends = 1.0 - np.array(EDGES)
    size = DEGREE * (len(ends) - 1) + 1
    radii, weights, stiffness = np.zeros(size), np.zeros(size), np.zeros((size, size))
    for k, (low, high) in enumerate(pairwise(ends)):
        here = slice(DEGREE * k, DEGREE * (k + 1) + 1)
        half = 0.5 * (high - low)
        r = low + half * (nodes + 1.0)
        radii[here] = r
        volume = 3.0 * quadrature * r * r
        weights[here] += volume * half
        stiffness[here, here] += (at_nodes * volume) @ at_nodes.T / half
    return Interior(radii, weights / weights.sum(), stiffness, 3)

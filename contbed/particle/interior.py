"""The inside of a sphere, cylinder or slab by even polynomials: few points,
conservative, exact to many digits.

    C dT/dt = k laplacian(T) in the particle,    k dT/dn = q at its surface,    symmetric about the centre

T is a polynomial of degree n in u = (r/R)^2, given by its values at n Jacobi points
inside and at the surface. Tested with the same polynomials and integrated at these
points (Gauss-Radau, exact for all terms),

    C w_i dT_i/dt = -(k/R^2) sum_j K_ij T_j + (s/R) q [i is the surface],    sum w = 1,  sum_i K_ij = 0

so that the mean content sum_i C w_i T_i changes by exactly the flux over the surface,
s/R the surface per volume (s = 3, 2, 1). At the points inside this is orthogonal
collocation.

n = 3 is exact to 3e-7 of a step for Bi = 1, better than 20 equal shells; n = 1 is worse
than one temperature with a corrected film. Source: Villadsen, Stewart, Chem. Eng. Sci.
22 (1967) 1483, doi:10.1016/0009-2509(67)80074-5.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import eigh

from contbed.arrays import Array

# times R, for a slab half of its thickness
SURFACE_OVER_VOLUME = {"sphere": 3, "cylinder": 2, "slab": 1}


@dataclass(frozen=True)
class Interior:
    """Points, weights and conduction matrix of one particle of unit radius, n points
    inside and the surface last: of even polynomials, or of `shells`.

    radii : (n + 1,) r/R in increasing order, the last 1
    weights : (n + 1,) of the mean over the volume; they are positive
    stiffness : (n + 1, n + 1) K of the module, symmetric, rows sum to 0
    surface : R times surface over volume
    """

    radii: Array
    weights: Array
    stiffness: Array
    surface: int

    def modes(self) -> tuple[Array, Array]:
        """Return rates (n + 1,) and modes (n + 1, n + 1) with K V = diag(w) V
        diag(rates), V^T diag(w) V = 1.

        The first rate is 0, the mean; times k/(C R^2) they are rates of decay in a
        particle without film [1/s].
        """
        rates, modes = eigh(self.stiffness, np.diag(self.weights))
        rates[0] = 0.0
        return rates, modes

    def at_centre(self) -> Array:
        """Return the weights (n + 1,) that turn values at the points into the value
        at the centre.
        """
        found: Array = _lagrange(self.radii**2, np.zeros(1))[0]
        return found


@lru_cache(maxsize=16)
def interior(points: int, shape: str = "sphere") -> Interior:
    """Return points and matrices for `points` inside.

    Raises
    ------
    ValueError : fewer than 2 points, an unknown shape

    >>> [round(float(r), 6) for r in interior(2).radii]
    [0.468849, 0.830224, 1.0]
    """
    if points < 2:
        raise ValueError(
            f"{points} point inside of a particle; give 2 or more, or one temperature "
            "per particle"
        )
    if shape not in SURFACE_OVER_VOLUME:
        raise ValueError(
            f"shape {shape!r} of a particle; known: {', '.join(SURFACE_OVER_VOLUME)}"
        )
    # particles without an inside do not wait for its import
    from scipy.special import roots_jacobi

    surface = SURFACE_OVER_VOLUME[shape]
    beta = 0.5 * (surface - 2)  # the volume element is u^beta du surface/2
    roots, _ = roots_jacobi(points, 1.0, beta)
    u = np.append(0.5 * (roots + 1.0), 1.0)
    slope = differentiation(u)
    # products of slopes have degree 2 n - 2 in u besides the factor 4 u of the
    # gradient: n + 1 Gauss points suffice
    gauss, gauss_weights = roots_jacobi(points + 1, 0.0, beta)
    v, share = 0.5 * (gauss + 1.0), gauss_weights / gauss_weights.sum()
    basis = _lagrange(u, v)
    gradient = basis @ slope
    stiffness = gradient.T @ ((4.0 * share * v)[:, None] * gradient)
    weights = share @ basis
    return Interior(np.sqrt(u), weights, 0.5 * (stiffness + stiffness.T), surface)


def _barycentric(x: Array) -> Array:
    differences = x[:, None] - x[None, :]
    np.fill_diagonal(differences, 1.0)
    factors: Array = 1.0 / differences.prod(axis=1)
    return factors


def _lagrange(x: Array, at: Array) -> Array:
    """Return the values (m, n) of the n Lagrange polynomials of the nodes x at other
    places.
    """
    terms = _barycentric(x) / (at[:, None] - x[None, :])
    values: Array = terms / terms.sum(axis=1, keepdims=True)
    return values


def differentiation(x: Array) -> Array:
    """Return the matrix (n, n) that turns values at the nodes x into slopes there;
    rows sum to 0.
    """
    factors = _barycentric(x)
    differences = x[:, None] - x[None, :]
    np.fill_diagonal(differences, 1.0)
    matrix: Array = factors[None, :] / factors[:, None] / differences
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix

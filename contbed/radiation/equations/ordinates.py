"""Radiation through a plane bed by discrete ordinates: gray, isotropic scattering, any
number of directions.

The half range of mu carries `order` Gauss points mu_j with weights w_j, sum w_j = 1
(double Gauss). For each of them u_j = 2 pi (I+ + I-) and f_j = 2 pi mu_j (I+ - I-),
with E the emitted power of the solids, e = sum_m Ka,m sigma T_m^4:

    f_j' + (Ka + Ks) u_j = 4 e + Ks G,   f_j = -mu_j^2/(Ka + Ks) u_j',   G = sum w_j u_j,   q = sum w_j f_j
    z = 0:  f_j = mu_j (4 J - u_j),   z = H:  f_j = mu_j (u_j - 4 J)
    J = [eps E_w + (1 - eps) sum w_j mu_j u_j]/(2 - eps),   which is J = eps E_w + (1 - eps) (incoming flux)

at gray diffuse walls. One ordinate (mu = 1/2) is the two-flux model. Continuous
elements of degree p give a symmetric positive definite system with all directions of an
element coupled, solved directly, so that no albedo and no thickness is slow. f_j at the
nodes is the flux by which the elements balance, the consistent one, and
q[i+1] - q[i] = int (4 e - Ka G) dz holds to round-off in each cell.

Sykes, Mon. Not. R. Astron. Soc. 111 (1951) 377, doi:10.1093/mnras/111.4.377 (double
Gauss); Lewis and Miller, Computational Methods of Neutron Transport, 1984 (even-parity
form).

Good values: order 4, degree 2, first cells 0.05/(Ka + Ks) at the walls and then growing
by a quarter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse import coo_array, csr_array

from contbed.arrays import Array
from contbed.errors import ConvergenceError

Coefficient = ArrayLike | Callable[[Array], ArrayLike]

_REFINEMENTS, _TOLERANCE = 12, 1e-8


@dataclass(frozen=True)
class Wall:
    """A gray diffuse wall: `power` sigma T^4 [W/m2], `emissivity` [-]; if black,
    `power` is a given radiosity.
    """

    power: float
    emissivity: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.emissivity <= 1.0:
            raise ValueError(
                "radiating wall: the emissivity must lie in 0 ... 1, got "
                f"{self.emissivity:g}"
            )


@dataclass(frozen=True)
class OrdinatesSolution:
    """Radiation field of one emission.

    points : positions of the unknowns [m]: the nodes and the inner points of each cell,
        shape (P,)
    G : incident radiation at the points [W/m2], shape (P,)
    z : nodes [m], shape (N,)
    q : radiative flux at the nodes [W/m2], along z, shape (N,)
    mu, weight : cosines and weights of the half range, sum 1, shape (n,)
    I_plus, I_minus : intensities along mu and -mu at the nodes [W/m2/sr], shape (n, N)
    """

    points: Array
    G: Array
    z: Array
    q: Array
    mu: Array
    weight: Array
    I_plus: Array
    I_minus: Array


class Ordinates:
    """Discretised and factorised transport in one bed; the emission is the argument of
    `solve`.

    Parameters
    ----------
    z : nodes [m], increasing, any spacing
    Ka, Ks : absorption and scattering coefficients [1/m], Ka >= 0, Ks >= 0,
        Ka + Ks > 0: a number, a function of z, or values at the nodes (linear between
        them), in the cells (constant in each) or at the `points`
    left, right : walls at z[0] and z[-1]; None is a plane of symmetry
    order : directions per half range, >= 1
    degree : of the elements; at the nodes u_j and q converge with twice this order

    A medium that emits what it absorbs scatters evenly: its absorption is part of Ks.
    """

    def __init__(
        self,
        z: ArrayLike,
        Ka: Coefficient,
        Ks: Coefficient,
        left: Wall | None,
        right: Wall | None,
        order: int = 4,
        degree: int = 2,
    ):
        self.z = np.asarray(z, dtype=float)
        self.width = np.diff(self.z)
        if self.width.size == 0 or not np.all(self.width > 0.0):
            raise ValueError("ordinates: need at least two nodes z in increasing order")
        nodes, weights = legendre.leggauss(order)
        self.mu, self.weight = 0.5 * (nodes + 1.0), 0.5 * weights
        self.element = _Element(degree)
        inner = self.z[:-1, None] + self.width[:, None] * self.element.points[:-1]
        self.points = np.append(inner.ravel(), self.z[-1])
        self.index = degree * np.arange(len(self.width))[:, None] + np.arange(
            degree + 1
        )
        absorption, scattering = (
            self._at_quadrature(Ka, "Ka"),
            self._at_quadrature(Ks, "Ks"),
        )
        extinction = absorption + scattering
        if not (
            np.all(absorption >= 0.0)
            and np.all(scattering >= 0.0)
            and np.all(extinction > 0.0)
        ):
            raise ValueError(
                "ordinates: need Ka >= 0, Ks >= 0 and Ka + Ks > 0 everywhere between "
                "the walls"
            )
        self.stiffness = self.element.stiffness(self.width, 1.0 / extinction)
        self.removal = self.element.mass(self.width, extinction)
        self.absorption = self.element.mass(self.width, absorption)
        self.walls = {0: left, len(self.points) - 1: right}
        if not self.absorption.any() and not any(
            wall and wall.emissivity for wall in (left, right)
        ):
            raise ValueError(
                "ordinates: neither the medium nor a wall absorbs, so that G has no "
                "level"
            )
        self.inverse = self._factorised()

    def solve(self, emission: Coefficient) -> OrdinatesSolution:
        """Return the field of an emission e = sum_m Ka,m sigma T_m^4 [W/m3], given
        in any of the ways of Ka.
        """
        load = 4.0 * self.element.load(
            self.width, self._at_quadrature(emission, "emission")
        )
        u = self._field(load)
        gain = self._gain(u, load).sum(axis=1)
        f = np.cumsum(np.vstack([self._entering(0, u[0]), gain]), axis=0)
        ends = u[:: self.element.degree]
        plus, minus = (
            (ends + sign * f / self.mu).T / (4.0 * np.pi) for sign in (1.0, -1.0)
        )
        G, q = u @ self.weight, f @ self.weight
        return OrdinatesSolution(
            self.points, G, self.z, q, self.mu, self.weight, plus, minus
        )

    def response(self) -> tuple[Array, Array]:
        """Return G at the points as an affine function of the emission at the points:
        G = R e + G0, R [m], G0 [W/m2].

        Dense, P x P, from one factorisation: with e = sum_m Ka,m sigma T_m^4 the
        derivative of the net emission of species m, Ka,m (4 sigma T_m^4 - G), follows
        as 16 Ka,m sigma T_m^3 - 4 Ka,m R Ka,n sigma T_n^3. M R, with M the mass matrix,
        is symmetric (reciprocity).
        """
        size, order = len(self.points), len(self.mu)
        columns = 4.0 * self.mass_matrix().toarray()
        right = (columns[:, None, :] * self.weight[:, None]).reshape(size * order, size)
        solved = self.inverse(right).reshape(size, order, size)
        dark = np.zeros((len(self.width), self.element.degree + 1))
        return np.einsum("j,ijk->ik", self.weight, solved), self._field(
            dark
        ) @ self.weight

    def mass_matrix(self, coefficient: Coefficient = 1.0) -> csr_array:
        """Return the integrals of c v_i v_k for the basis functions v; its rows
        times e are loads [W/m2].
        """
        blocks = self.element.mass(
            self.width, self._at_quadrature(coefficient, "coefficient")
        )
        rows, columns = np.broadcast_arrays(
            self.index[:, :, None], self.index[:, None, :]
        )
        shape = (len(self.points), len(self.points))
        return csr_array(
            coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
        )

    def _at_quadrature(self, given: Coefficient, name: str) -> Array:
        """Return a coefficient at the quadrature points, shape (cells, quadrature)."""
        cells, element = len(self.width), self.element
        at = self.z[:-1, None] + self.width[:, None] * element.quadrature
        values = np.asarray(given(at) if callable(given) else given, dtype=float)
        if not callable(given) and values.ndim:
            linear = np.stack([1.0 - element.quadrature, element.quadrature])
            if values.shape == (cells + 1,):
                values = np.stack([values[:-1], values[1:]], axis=1) @ linear
            elif values.shape == (cells,):
                values = values[:, None]
            elif values.shape == self.points.shape:
                values = values[self.index] @ element.values
            elif values.shape != at.shape:
                raise ValueError(
                    f"ordinates: {name} has the shape {values.shape}; "
                    f"expected {cells + 1} nodes, {cells} cells or {len(self.points)} "
                    "points"
                )
        if not np.all(np.isfinite(values)):
            raise ValueError(f"ordinates: {name} must be finite everywhere")
        return np.broadcast_to(values, at.shape)

    def _factorised(self) -> Callable[[Array], Array]:
        """Return a function that solves by a Cholesky factor of the band."""
        try:
            factor = (cholesky_banded(self._band(), lower=True), True)
        except np.linalg.LinAlgError as error:
            raise self._failure("the matrix is singular in double precision") from error
        return lambda rhs: np.asarray(cho_solve_banded(factor, rhs))

    def _band(self) -> Array:
        """Return the system in LAPACK's lower band storage, unknowns ordered by
        point, then direction.
        """
        order, local = len(self.mu), self.element.degree + 1
        coupled = np.outer(self.weight, self.weight)
        blocks = (self.absorption - self.removal)[:, :, None, :, None] * coupled[
            :, None, :
        ]
        for j, (mu, weight) in enumerate(zip(self.mu, self.weight, strict=True)):
            blocks[:, :, j, :, j] += weight * (mu**2 * self.stiffness + self.removal)
        size = local * order
        row, column = np.tril_indices(size)
        band = np.zeros((size, len(self.points) * order))
        first = self.index[:, :1] * order
        np.add.at(
            band,
            (row - column, first + column),
            blocks.reshape(-1, size, size)[:, row, column],
        )
        row, column = np.tril_indices(order)
        for point, wall in self.walls.items():
            if wall is not None:
                half = self.weight * self.mu
                block = np.diag(half) - 4.0 * (1.0 - wall.emissivity) / (
                    2.0 - wall.emissivity
                ) * np.outer(half, half)
                band[row - column, point * order + column] += block[row, column]
        return band

    def _field(self, load: Array) -> Array:
        """Return u at the points, shape (P, n), of the loads of the cells, by
        refinement.

        Residuals are formed from differences of u within cells and among directions:
        neither thin cells, with large mu^2/(Ka + Ks), nor thick ones then cost digits.
        """
        u = np.zeros((len(self.points), len(self.mu)))
        change = np.inf
        for _ in range(_REFINEMENTS):
            residual = np.zeros_like(u)
            stream = np.einsum(
                "cik,ckj->cij", self.stiffness, u[self.index] - u[self.index[:, :1]]
            )
            np.add.at(residual, self.index, self._gain(u, load) - self.mu**2 * stream)
            for point in self.walls:
                residual[point] += self._entering(point, u[point])
            step = self.inverse((self.weight * residual).ravel()).reshape(u.shape)
            u += step
            last, change = (
                change,
                float(np.abs(step).max() / max(np.abs(u).max(), 1e-300)),
            )
            if change < 1e-13 or (change < _TOLERANCE and change > 0.5 * last):
                return u
        raise self._failure(
            f"the last refinement changed the field by {change:.1e} of its maximum"
        )

    def _failure(self, what: str) -> ConvergenceError:
        optical = self.removal.sum(axis=(1, 2))
        return ConvergenceError(
            f"ordinates: {what}; needed are cells of optical depth above 1e-12 and a "
            "wall of emissivity above 1e-8 or "
            f"an absorbing medium; here the depths are {optical.min():.1e} ... "
            f"{optical.max():.1e}"
        )

    def _gain(self, u: Array, load: Array) -> Array:
        """Return int (4 e + Ks G - (Ka + Ks) u_j) v_i dz of each cell, shape (cells,
        degree+1, directions).

        As int (4 e - Ka G + (Ka + Ks) (G - u_j)) v_i, with the weighted mean of G - u_j
        zero to round-off of itself: thick scattering cells then create no heat.
        """
        local = u[self.index]
        G = local @ self.weight
        apart = G[:, :, None] - local
        apart -= (apart @ self.weight)[:, :, None]
        absorbed = np.einsum("cik,ck->ci", self.absorption, G)
        gain: Array = (load - absorbed)[:, :, None] + np.einsum(
            "cik,ckj->cij", self.removal, apart
        )
        return gain

    def _entering(self, point: int, u: Array) -> Array:
        """Return the flux mu_j (4 J - u_j) that enters through a wall; 0 through a
        plane of symmetry.
        """
        wall = self.walls[point]
        if wall is None:
            return np.zeros_like(u)
        reflected = (1.0 - wall.emissivity) * float(u @ (self.weight * self.mu))
        radiosity = (wall.emissivity * wall.power + reflected) / (2.0 - wall.emissivity)
        return self.mu * (4.0 * radiosity - u)


class _Element:
    """Lagrange polynomials at Lobatto points of 0 ... 1, and their integrals over
    cells with coefficients.
    """

    def __init__(self, degree: int):
        if degree < 1:
            raise ValueError(
                "ordinates: the degree of the elements must be at least 1, got "
                f"{degree}"
            )
        self.degree = degree
        inner = legendre.Legendre.basis(degree).deriv().roots()
        lobatto = np.concatenate([[-1.0], np.sort(inner.real), [1.0]])
        self.points = 0.5 * (lobatto + 1.0)
        nodes, weights = legendre.leggauss(degree + 2)
        self.quadrature, self.weights = 0.5 * (nodes + 1.0), 0.5 * weights
        unit = np.linalg.solve(legendre.legvander(lobatto, degree), np.eye(degree + 1))
        self.values = (legendre.legvander(nodes, degree) @ unit).T
        self.slopes = (
            2.0 * (legendre.legvander(nodes, degree - 1) @ legendre.legder(unit)).T
        )

    def mass(self, width: Array, coefficient: ArrayLike = 1.0) -> Array:
        """Return int c v_i v_k dz, shape (cells, degree+1, degree+1)."""
        weight = (
            np.broadcast_to(coefficient, (len(width), len(self.weights)))
            * self.weights
            * width[:, None]
        )
        integrals: Array = np.einsum("cq,iq,kq->cik", weight, self.values, self.values)
        return integrals

    def stiffness(self, width: Array, coefficient: Array) -> Array:
        """Return int c v_i' v_k' dz, shape (cells, degree+1, degree+1)."""
        weight = coefficient * self.weights / width[:, None]
        integrals: Array = np.einsum("cq,iq,kq->cik", weight, self.slopes, self.slopes)
        return integrals

    def load(self, width: Array, values: Array) -> Array:
        """Return int e v_i dz, shape (cells, degree+1)."""
        return (values * self.weights * width[:, None]) @ self.values.T

"""Matrices of a line whose nodes carry particles with temperatures inside: unknowns
that only their node sees are condensed.

Beside the unknowns b of the bed each node has n modes of its particles, with the heat q
that they give to the fluid:

    m(b)' + S b + B sum_m T_m + vector = 0,      c T_m' = -D_m T_m - g_m q,      q = E (T_solid - T_fluid + sum_m T_m)

In a stage of TR-BDF2 (`course.dirk`) with w = d dt every mode is an explicit
function of q at its node,

    (c + w D_m) T_m = r_m - w g_m q,    sum_m T_m = (P - w E Z (T_solid - T_fluid))/(1 + w E Z)
    P = sum_m r_m/(c + w D_m),  Z = sum_m g_m/(c + w D_m)

so that the bed is solved with a band as narrow as that of particles of one temperature.
This is the solution of the whole system to rounding: all equations of the modes are
tested with one mass matrix, which drops out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp

from contbed.arrays import Array, Integers
from contbed.solvers.banded import Band, Ordering


@dataclass(frozen=True)
class Modes:
    """Modes of the particles at the nodes of a line.

    capacity : c [J/m3/K]; exchange : E [W/m3/K]; decay : D (n, 1) [W/m3/K]; gain : g
        (n, 1)
    fluid, solid : places (nodes,) of both temperatures in the state; n times nodes of
        the modes follow
    """

    capacity: float
    exchange: float
    decay: Array
    gain: Array
    fluid: Integers
    solid: Integers

    def matrices(
        self, mass: Any, stiffness: Any
    ) -> tuple[Ordering, _Mass, _Stiffness] | None:
        """Return the order of all unknowns and both matrices in that order; None where
        the band of the bed is wide.
        """
        nodes = len(self.fluid)
        size = nodes + len(self.solid)
        mass, bed = mass[:size, :size], stiffness[:size, :size]
        ordering = Ordering.of(abs(mass) + abs(bed))
        if ordering is None:
            return None
        # from the sum of all modes at the nodes to the bed
        coupling = sp.csr_matrix(stiffness[:size, size : size + nodes])
        ones = np.ones(nodes)
        places = np.concatenate([self.solid, self.fluid])
        rows = np.tile(np.arange(nodes), 2)
        difference = sp.csr_matrix(
            (np.concatenate([ones, -ones]), (rows, places)), shape=(nodes, size)
        )
        operator = _Stiffness(
            self,
            ordering.band(bed),
            coupling[ordering.order],
            ordering.band(sp.csc_matrix(coupling @ difference)),
            ordering.back[self.fluid],
            ordering.back[self.solid],
        )
        whole = ordering.followed_by(len(self.decay) * nodes)
        return whole, _Mass(self.capacity, ordering.band(mass)), operator


@dataclass(frozen=True)
class _Mass:
    """The matrix of the content: a band, and one capacity for all modes."""

    capacity: float
    bed: Band

    def __matmul__(self, x: Array) -> Array:
        size = self.bed.size
        return np.concatenate([self.bed @ x[:size], self.capacity * x[size:]])

    def plus(self, other: _Stiffness, factor: float) -> _Shifted:
        """Return this matrix plus `factor` times the other."""
        return _Shifted(self, other, factor)


@dataclass(frozen=True)
class _Stiffness:
    """The matrix of the steady residual."""

    modes: Modes
    bed: Band
    coupling: sp.csr_matrix
    exchanged: Band  # the coupling with the difference of both temperatures
    fluid: Integers
    solid: Integers

    def __matmul__(self, x: Array) -> Array:
        bed, inner = self.parts(x)
        total = inner.sum(axis=0)
        given = self.modes.exchange * (self.difference(bed) + total)
        of_modes = self.modes.decay * inner + self.modes.gain * given
        return np.concatenate(
            [self.bed @ bed + self.coupling @ total, of_modes.ravel()]
        )

    def parts(self, x: Array) -> tuple[Array, Array]:
        """Return the unknowns of the bed and those of the modes (n, nodes)."""
        size = self.bed.size
        return x[:size], x[size:].reshape(len(self.modes.decay), -1)

    def difference(self, bed: Array) -> Array:
        """Return the temperature of the solid over that of the fluid at each node."""
        found: Array = bed[self.solid] - bed[self.fluid]
        return found


@dataclass(frozen=True)
class _Shifted:
    """The matrix of a stage: the mass plus w times the stiffness."""

    mass: _Mass
    stiffness: _Stiffness
    w: float

    def solver(self, fixed: Integers) -> Callable[[Array], Array]:
        """Return the solution for a right-hand side; rows and columns of `fixed`
        unknowns of the bed are those of the identity.

        Raises
        ------
        ConvergenceError : the matrix is singular or holds values that are not finite
        """
        w, stiffness, modes = self.w, self.stiffness, self.stiffness.modes
        damping = 1.0 / (self.mass.capacity + w * modes.decay)
        loss = w * modes.exchange * float((modes.gain * damping).sum())  # w E Z
        share = 1.0 / (1.0 + loss)
        matrix = self.mass.bed.plus(stiffness.bed, w)
        solve = matrix.plus(stiffness.exchanged, -w * loss * share).solver(fixed)
        gain = w * modes.exchange * share * modes.gain

        def apply(rhs: Array) -> Array:
            bed, inner = stiffness.parts(rhs)
            remembered = (inner * damping).sum(axis=0)  # P
            reduced = bed - (w * share) * (stiffness.coupling @ remembered)
            reduced[fixed] = bed[fixed]
            found = solve(reduced)
            given = gain * (stiffness.difference(found) + remembered)
            return np.concatenate([found, ((inner - given) * damping).ravel()])

        return apply

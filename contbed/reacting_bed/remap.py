"""States of a run in time on other cells, with the same moles of every species and the
same heat.

What the nodes of a cell hold, C(u), are values of a polynomial. Its least-squares
polynomials on the new cells have the same integrals, and are the same where a cell is
divided. Where amounts are below zero, before or after, all that is stored in a cell is
brought nearer to its means by one share, which changes no integral (limiter of Zhang
and Shu). At each node the method of Newton then finds the unknowns that hold so much;
those that store nothing are projected, as a first guess.

A gas that fills the pores is stored at a pressure that is constant in time. Moles and
heat of all gases fix it at each new node together with the temperature: else one of
both would not stay.

Source: Zhang, Shu 2010, J. Comput. Phys. 229, 3091-3120, doi:10.1016/j.jcp.2009.12.030.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.chemistry.thermo import R_GAS
from contbed.errors import ConvergenceError
from contbed.fem.line_projection import projected
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.unknowns import LEAST_T, Role
from contbed.reacting_bed.least_amounts import nearer_to_means, share_above_zero
from contbed.reacting_bed.problem import Problem
from contbed.reacting_bed.storage import Storage, content, gas_of_rings, stored_rows

ITERATIONS = 40  # of Newton's method at a node
# change of unknowns over their sizes, of which the content changes by rounding
ROUNDED = 1e-14
# such a change where heats of formation round, and its fall that is none of Newton's
# method
ROUGH, SLOW = 1e-10, 0.1
# of an intraparticle concentration in one iteration, as isotherms bend
LARGEST_FALL = 0.9


class _OfMoles(Storage):
    """Content where the gas in the pores has so many moles `gas` [mol/m3 bed] at the
    points of all rings.
    """

    def __init__(self, problem: Problem, held: Array, gas: Array | None):
        super().__init__(problem, held, 1.0)
        self.gas = gas

    def bed_at(self, values: list[Any]) -> Bed:
        """Return the bed whose gas is stored at the pressure of its moles and of
        values of the unknowns.
        """
        bed = self.problem.bed
        if self.gas is None:
            return bed
        T = np.maximum(bed.state(values).T_fluid, LEAST_T)
        return self.problem.with_gas_stored(
            T * (self.gas * (R_GAS / bed.medium.porosity))
        ).bed


def transferred(problem: Problem, u: Array, vertices: Array) -> tuple[Problem, Array]:
    """Return a problem and its state (m, N, p + 1) on other cells, which hold what
    those did.

    Raises
    ------
    ConvergenceError : no state holds so much
    """
    other = problem.on(vertices)
    before = content(problem, u)
    held = _above_zero(
        other, projected(problem.line, _above_zero(problem, before), other.line)
    )
    guess = projected(problem.line, u, other.line)
    rows, gas = stored_rows(other), None
    if other.bed.gas_pressure is not None:
        rings = gas_of_rings(other)
        totals = [held[row].sum(axis=0) for row in rings]
        for row, total in zip(rings, totals, strict=True):
            guess[row] = held[row] / total * guess[row].sum(axis=0)
        gas = np.concatenate([total.ravel() for total in totals])
        rows = np.setdiff1d(rows, np.concatenate(rings))
    storage = _OfMoles(other, held, gas)
    found = _regained(storage, guess, rows)
    if gas is not None:
        other = other.with_gas_stored(
            storage.bed_at(other.at_all_points(found)).gas_pressure * np.ones_like(gas)
        )
    return other, found


def _above_zero(problem: Problem, held: Array) -> Array:
    """Return the content with gases and solids nowhere below zero but for the
    tolerance, with the means of cells.

    Between nodes as well: a cell that is divided would else have parts with less than
    nothing. Particles that adsorb keep what they hold, as their points are not bounded
    in steps either.
    """
    solids = list(problem.rows(Role.SOLID))
    fills = problem.bed.gas_pressure is not None
    gases = list(problem.rows(Role.GAS)) if fills else []
    sizes = np.append(
        problem.sizes[solids], np.full(len(gases), np.abs(held[gases]).max(initial=0.0))
    )
    line, rows = problem.line, [*solids, *gases]
    least = problem.scene.solver.newton_tolerance * sizes
    share = share_above_zero(line, held[rows], least)
    share = np.where(held[rows] @ line.weights > 0.0, share, 1.0)
    share = share.min(axis=0, initial=1.0)
    nearer = nearer_to_means(line, held, share)
    return np.where(share[:, None] < 1.0, nearer, held)


def _regained(storage: Storage, u: Array, rows: NDArray[np.intp]) -> Array:
    """Return the state of which `rows` are such that as much is held as `storage` says;
    `u` is a first guess.

    Raises
    ------
    ConvergenceError : no state holds so much
    """
    problem, shape = storage.problem, u[rows].shape
    sizes = problem.sizes[rows, None, None]
    inner = np.isin(rows, problem.rows(Role.POINT))[:, None, None]
    place = {int(k): at for at, k in enumerate(rows)}
    u, before = u.copy(), np.inf
    if not len(rows):
        return u
    for _ in range(ITERATIONS):
        held, parts = storage.content(u, True)
        slopes = np.zeros((len(rows), len(rows), *shape[1:]))
        for e, k in enumerate(rows):
            for (_, f), tangent in getattr(parts[k], "tangents", {}).items():
                if f in place:
                    slopes[e, place[f]] = np.broadcast_to(
                        tangent, (shape[1] * shape[2],)
                    ).reshape(shape[1:])
        off = (storage.held - held)[rows]
        try:
            du = np.linalg.solve(
                slopes.transpose(2, 3, 0, 1), off.transpose(1, 2, 0)[..., None]
            )[..., 0]
        except np.linalg.LinAlgError:
            break
        step = du.transpose(2, 0, 1)
        step = np.where(
            inner & (u[rows] > 0.0), np.maximum(step, -LARGEST_FALL * u[rows]), step
        )
        u[rows] += step
        change = float(np.abs(step / sizes).max())
        if not np.isfinite(change):
            break
        if change < ROUNDED or (change < ROUGH and change > SLOW * before):
            return u
        before = change
    raise ConvergenceError(
        "the state could not be transferred to the new mesh without a change of "
        "the amounts in the bed; give mesh.cells",
        [],
        u,
    )

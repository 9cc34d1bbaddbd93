"""Time steps of a line whose nodes carry an inside of their own: unknowns that only
their node sees are condensed.

Beside the unknowns b of the bed each node has n modes of its particles, with the heat q
that they give to the fluid:

    m(b)' + S b + B sum_m T_m + vector = 0,      c T_m' = -D_m T_m - g_m q,      q = E (T_solid - T_fluid + sum_m T_m)

In a stage of TR-BDF2 (`solvers.timestep`) with w = d dt every mode is an explicit
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
from numpy.typing import NDArray

from contbed.solvers.banded import Affine, Band, BandedProblem, Ordering

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Inside:
    """Modes of the particles at the nodes of a line.

    bed : the problem with one mode in place of all, whose columns hold B
    capacity : c [J/m3/K]; exchange : E [W/m3/K]; decay : D (n,) [W/m3/K]; gain : g (n,)
    fluid, solid : places (nodes,) of both temperatures in the state; n times nodes of
        the modes follow
    """

    bed: Any
    capacity: float
    exchange: float
    decay: Array
    gain: Array
    fluid: NDArray[np.int64]
    solid: NDArray[np.int64]

    @property
    def size(self) -> int:
        """Number of unknowns of the bed."""
        return len(self.fluid) + len(self.solid)


@dataclass(frozen=True)
class _Factors:
    """What a size of step needs: the solution of the bed, 1/(c + w D), and E/(1 + w
    E Z).
    """

    solve: Callable[[Array], Array]
    damping: Array  # (n, 1)
    exchange: float
    width: float  # w


class CondensedStages(BandedProblem):
    """The two stages of a step of a linear problem on a line with modes at its
    nodes.
    """

    def __init__(
        self,
        problem: Affine,
        ordering: Ordering,
        inside: Inside,
        scheme: tuple[float, float, float, Any],
    ):
        """Take matrices apart; `scheme` are gamma, d, w and the weights of the error
        of TR-BDF2.
        """
        super().__init__(problem, ordering)
        self.inside = inside
        self.gamma, self.d, self.w, self.error = scheme
        size, nodes = inside.size, len(inside.fluid)
        self.mass = ordering.band(sp.csc_matrix(problem.mass[:size, :size]))
        self.stiffness = ordering.band(sp.csc_matrix(problem.stiffness[:size, :size]))
        # from the sum of all modes at the nodes to the bed
        self.coupling = sp.csr_matrix(problem.stiffness[:size, size : size + nodes])[
            self.order
        ]
        apart = sp.csr_matrix(
            (
                np.repeat([1.0, -1.0], nodes),
                (
                    np.tile(np.arange(nodes), 2),
                    np.concatenate([inside.solid, inside.fluid]),
                ),
            ),
            shape=(nodes, size),
        )
        self.exchanged = ordering.band(sp.csc_matrix(self.coupling[self.back] @ apart))
        self.fluid, self.solid = self.back[inside.fluid], self.back[inside.solid]
        self.decay, self.gain = inside.decay[:, None], inside.gain[:, None]
        self.factors: dict[int, _Factors] = {}
        self.last: tuple[Any, ...] | None = None

    def _take_apart(self, state: Array) -> tuple[Array, Array]:
        size = self.inside.size
        modes = (state[size:] - self.problem.origin[size:]).reshape(len(self.decay), -1)
        return (state[:size] - self.problem.origin[:size])[self.order], modes

    def _rates(self, bed: Array, modes: Array, vector: Array) -> tuple[Array, Array]:
        """Return the steady residuals of the bed and of the modes, these per bed
        volume.
        """
        total = modes.sum(axis=0)
        given = self.inside.exchange * (bed[self.solid] - bed[self.fluid] + total)
        return (
            self.stiffness @ bed + self.coupling @ total + vector,
            self.decay * modes + self.gain * given,
        )

    def take(
        self, state: Any, moments: tuple[float, float], dt: float, level: int
    ) -> tuple[Any, Any, Any, Any]:
        """Return states, residuals, gain of content and error of one step, as all
        stages do.
        """
        start, end = moments
        if self.last is None or self.last[0] is not state:
            begin, modes = self._take_apart(state)
            self.last = (
                state,
                begin,
                modes,
                self.mass @ begin,
                *self._rates(begin, modes, self.vector(start)),
            )
        _, begin, modes, content, steady, inner = self.last
        factors = self._factors(dt, level)
        c, w = self.inside.capacity, self.w * dt
        first = self._stage(
            begin,
            content - factors.width * steady,
            c * modes - factors.width * inner,
            start + self.gamma * dt,
            factors,
        )
        last = self._stage(
            first[1],
            content - w * (steady + first[3]),
            c * modes - w * (inner + first[4]),
            end,
            factors,
        )
        a, b, e = (-dt * share for share in self.error)
        defect = a * steady + b * first[3] + e * last[3]
        defect[self.fixed] = 0.0
        wrong, wrong_modes = self._solve(
            np.zeros_like(begin),
            defect,
            a * inner + b * first[4] + e * last[4],
            factors,
        )
        error = np.concatenate([wrong[self.back], wrong_modes.ravel()])
        content_last = self.mass @ last[1]
        if np.isfinite(error).all():
            self.last = (last[0], last[1], last[2], content_last, last[3], last[4])
        none = np.zeros(modes.size)
        rates = tuple(
            np.concatenate([rate[self.back], none])
            for rate in (steady, first[3], last[3])
        )
        gain = np.concatenate([(content_last - content)[self.back], none])
        return (state, first[0], last[0]), rates, gain, error

    def _stage(
        self, guess: Array, rhs: Array, rhs_modes: Array, time: float, factors: _Factors
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Return the state of a stage, its parts, and their residuals."""
        vector = self.vector(time)
        guess = self.prescribed(guess)
        bed, modes = self._solve(
            guess, rhs - factors.width * vector, rhs_modes, factors
        )
        state = np.concatenate([bed[self.back], modes.ravel()]) + self.problem.origin
        # as a restart from this state finds it, to the last bit
        bed, modes = self._take_apart(state)
        return (state, bed, modes, *self._rates(bed, modes, vector))

    def _solve(
        self, guess: Array, rhs: Array, rhs_modes: Array, factors: _Factors
    ) -> tuple[Array, Array]:
        """Solve for bed and modes; prescribed temperatures of the bed keep those of
        the guess.
        """
        w = factors.width
        remembered = (rhs_modes * factors.damping).sum(axis=0)  # P
        share = factors.exchange / self.inside.exchange  # 1/(1 + w E Z)
        residual = rhs - w * share * (self.coupling @ remembered) - self.mass @ guess
        residual -= w * (
            self.stiffness @ guess - (1.0 - share) * (self.exchanged @ guess)
        )
        residual[self.fixed] = 0.0
        bed = guess + factors.solve(residual)
        given = factors.exchange * (bed[self.solid] - bed[self.fluid] + remembered)
        return bed, (rhs_modes - (w * self.gain) * given) * factors.damping

    def _factors(self, dt: float, level: int) -> _Factors:
        if level not in self.factors:
            w = self.d * dt
            damping = 1.0 / (self.inside.capacity + w * self.decay)
            # w E Z
            loss = w * self.inside.exchange * float((self.gain * damping).sum())
            matrix: Band = self.mass.plus(self.stiffness, w).plus(
                self.exchanged, -w * loss / (1.0 + loss)
            )
            self.factors[level] = _Factors(
                matrix.solver(self.fixed),
                damping,
                self.inside.exchange / (1.0 + loss),
                w,
            )
        return self.factors[level]

"""Catalyst pellets whose inside is resolved: rates as means over a sphere in which
gases diffuse and react.

    D_k laplacian(c_k) = -sum_j nu_kj r_j(c, T, p) inside,    c_k that of the gas at the surface

As all sources come from a few independent reactions, their extents xi_b are the
unknowns, 0 at the surface:

    c_k = c_k,surface + sum_b nu_kb xi_b/D_k,    (1/R^2) sum_l K_il xi_b,l = w_i sum_j a_bj r_j,i

with the points and matrices of `particle.shells`. Pellets of all points of the bed are
solved at once by Newton's method and condensed: the bed sees mean rates and, by the
theorem of implicit functions, their derivatives. The pellet has one temperature and one
pressure.

Source: Aris 1975, The Mathematical Theory of Diffusion and Reaction in Permeable
    Catalysts, vol. 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.chemistry.kinetics import Reaction, rates_of
from contbed.chemistry.local import Local
from contbed.chemistry.thermo import R_GAS
from contbed.errors import ConvergenceError
from contbed.fem.ad.dual import Dual
from contbed.materials.pointwise import with_slopes
from contbed.particle.shells import shells

Array = NDArray[np.float64]
ITERATIONS = 60  # of Newton's method from pellets that are known
# pseudo time over R^2/D of a gas from pellets without gradients, and how it grows
FIRST_STEP, LAST_STEP, GROWTH = 1e-9, 1e9, 3.0
MARCHED = 600  # iterations in pseudo time
LEAST_TAKEN = 0.3  # share of a step below which it is taken again in a shorter time
LARGEST_FALL = 0.8  # of a concentration in one iteration
LEAST_SHARE = 1e-4  # of the molecules, below which a fall is not held up
# change of concentrations over that of all molecules at which an iteration ends
EXACT = 1e-11
# singular value over the largest below which reactions are sums of others
INDEPENDENT = 1e-9


@dataclass(frozen=True, eq=False)
class Pellets:
    """Catalytic reactions and the pellets in which they run.

    gases : of the reactions; moles : (gases, reactions) made per mole; diffusivities :
        (gases,) [m2/s]
    solids : volume of pellets per volume of bed
    """

    reactions: tuple[Reaction, ...]
    gases: tuple[str, ...]
    moles: Array
    diffusivities: Array
    solids: float
    # last extents by number of pellets, for first guesses alone
    known: dict[int, Array] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        reactions: Sequence[Reaction],
        diffusivities: Mapping[str, float],
        solids: float,
    ) -> Pellets:
        """Return the pellets of reactions whose species are gases."""
        gases = tuple(
            dict.fromkeys(
                name for reaction in reactions for name in reaction.stoichiometry
            )
        )
        moles = np.array(
            [
                [reaction.stoichiometry.get(name, 0.0) for reaction in reactions]
                for name in gases
            ]
        )
        D = np.array([diffusivities[name] for name in gases])
        return cls(tuple(reactions), gases, moles, D, solids)

    def resolved(self) -> list[Reaction]:
        """Return the reactions with rates that are means over pellets; they share
        their work.
        """
        return [
            replace(reaction, rate=self, step=k)
            for k, reaction in enumerate(self.reactions)
        ]

    def __call__(self, at: Local) -> list[Any]:
        """Return the mean rates of all reactions [mol/m3 bed/s].

        Raises
        ------
        ConvergenceError : the inside of a pellet is not found
        """
        inputs = [at.T, at.p, *(at.c[name] for name in self.gases)]
        return with_slopes(lambda values: self.means(values, at), inputs)

    @cached_property
    def basis(self) -> tuple[Array, Array]:
        """Moles of independent reactions (gases, b), and all reactions as sums of
        them, a (b, reactions).
        """
        u, size, vt = np.linalg.svd(self.moles, full_matrices=False)
        rank = int((size > INDEPENDENT * size[0]).sum())
        return u[:, :rank] * size[:rank], vt[:rank]

    def means(self, values: Array, at: Local) -> tuple[Array, Array]:
        """Return mean rates (reactions, N) and their derivatives (reactions, inputs,
        N).

        Parameters
        ----------
        values : (2 + gases, N) temperature, pressure and concentrations at the surface
        """
        points = shells()
        made, shares = self.basis
        xi = self._solved(values, at)
        r, slopes = self._rates(values, xi, at)
        matrix, by_extent = self._matrix(r, slopes, at)
        N, inputs = values.shape[1], len(values)
        w = points.weights
        # F = K xi/R^2 - w a r: derivatives to the inputs at given extents, then of the
        # extents
        direct = -np.einsum(
            "i,bj,jsni->nbis", w[:-1], shares, slopes[..., :-1]
        ).reshape(N, -1, inputs)
        along = -np.linalg.solve(matrix, direct).reshape(N, made.shape[1], -1, inputs)
        mean = np.einsum("i,jni->jn", w, r)
        total = np.einsum("i,jsni->jsn", w, slopes)
        total += np.einsum("i,jbni,nbis->jsn", w[:-1], by_extent[..., :-1], along)
        return self.solids * mean, self.solids * total

    def _rates(self, values: Array, xi: Array, at: Local) -> tuple[Array, Array]:
        """Return rates per volume of pellets (reactions, N, points) and derivatives
        (reactions, inputs, N, points).
        """
        N, inputs, count = values.shape[1], len(values), xi.shape[-1]
        step = np.einsum("kb,nbi->kni", self.scale, xi)
        flat = [np.repeat(row, count) for row in values]
        for k in range(len(self.gases)):
            flat[2 + k] = flat[2 + k] + step[k].ravel()
        one = np.ones(N * count)
        duals = [Dual(z, {k: one}) for k, z in enumerate(flat)]
        T, p = duals[:2]
        c = dict(zip(self.gases, duals[2:], strict=True))
        others = {
            name: np.repeat(np.broadcast_to(getattr(z, "value", z), (N,)), count)
            for name, z in at.c.items()
            if name not in c
        }
        molar = p / (R_GAS * T)
        inside = {**others, **c}
        local = replace(
            at,
            T=T,
            p=p,
            c=inside,
            x={name: z / molar for name, z in inside.items()},
            films={},
        )
        rates = np.zeros((len(self.reactions), N, count))
        slopes = np.zeros((len(self.reactions), inputs, N, count))
        for j, found in enumerate(rates_of(self.reactions, lambda _: local)):
            value = getattr(found, "value", found)
            rates[j] = np.broadcast_to(value, N * count).reshape(N, count)
            # a constant has none
            for k, tangent in getattr(found, "tangents", {}).items():
                slopes[j, k] = np.broadcast_to(tangent, N * count).reshape(N, count)
        return rates / self.solids, slopes / self.solids

    def _matrix(self, r: Array, slopes: Array, at: Local) -> tuple[Array, Array]:
        """Return dF/dxi (N, b n, b n) of points inside, and dr/dxi (reactions, b, N,
        points).
        """
        points, (made, shares) = shells(), self.basis
        N, n, b = r.shape[1], len(points.weights) - 1, made.shape[1]
        by_extent = np.einsum("jkni,kb->jbni", slopes[:, 2:], self.scale)
        local = np.einsum(
            "i,cj,jbni->ncbi",
            points.weights[:-1],
            shares,
            by_extent[..., :-1],
        )
        matrix = np.zeros((N, b, n, b, n))
        inner = points.stiffness[:-1, :-1] / at.radius**2
        every = np.arange(n)
        for c in range(b):
            matrix[:, c, :, c, :] += inner
            for d in range(b):
                matrix[:, c, every, d, every] -= local[:, c, d]
        return matrix.reshape(N, b * n, b * n), by_extent

    @cached_property
    def scale(self) -> Array:
        """Concentrations per extent (gases, b)."""
        return self.basis[0] / self.diffusivities[:, None]

    def _solved(self, values: Array, at: Local) -> Array:
        """Return the extents (N, b, points) of all pellets."""
        N, count = values.shape[1], len(shells().weights)
        if N in self.known:
            found = self._newton(self.known[N], values, at, np.inf)
            if found is not None:
                self.known[N] = found
                return found
        xi = np.zeros((N, self.scale.shape[1], count))
        found = self._newton(xi, values, at, FIRST_STEP)
        if found is None:
            raise ConvergenceError(
                "diffusion and reaction inside of the pellets are not found"
            )
        self.known[N] = found
        return found

    def _newton(
        self,
        xi: Array,
        values: Array,
        at: Local,
        first_step: float,
    ) -> Array | None:
        """Return the extents by Newton's method, with a pseudo time step that grows
        where the first is not infinite; None where it does not converge.
        """
        points, (made, shares) = shells(), self.basis
        dt = np.full(len(xi), first_step)
        N, molar = len(xi), values[1] / (R_GAS * values[0])
        inner = points.stiffness[:-1] / at.radius**2
        inside = np.tile(points.weights[:-1], made.shape[1]) / at.radius**2
        every = np.arange(len(inside))
        for _ in range(ITERATIONS if np.isinf(first_step) else MARCHED):
            r, slopes = self._rates(values, xi, at)
            residual = np.einsum("il,nbl->nbi", inner, xi)
            residual -= np.einsum(
                "i,bj,jni->nbi", points.weights[:-1], shares, r[..., :-1]
            )
            matrix, _ = self._matrix(r, slopes, at)
            matrix[:, every, every] += inside / dt[:, None]
            if not (np.isfinite(matrix).all() and np.isfinite(residual).all()):
                return None
            step = -np.linalg.solve(matrix, residual.reshape(N, -1, 1)).reshape(
                residual.shape
            )
            change = np.einsum("kb,nbi->nki", self.scale, step)
            here = np.einsum("kb,nbi->nki", self.scale, xi[..., :-1])
            c = values[2:].T[:, :, None] + here
            floor = LEAST_SHARE * molar[:, None, None]
            with np.errstate(divide="ignore"):
                share = np.where(
                    change < 0.0, LARGEST_FALL * np.maximum(c, floor) / -change, 1.0
                )
            taken = np.minimum(share.min(axis=(1, 2)), 1.0)
            again = np.isfinite(dt) & (taken < LEAST_TAKEN)
            taken[again] = 0.0
            dt *= np.where(again, 1.0 / GROWTH**2, GROWTH)
            dt[dt > LAST_STEP] = np.inf
            xi = xi.copy()
            xi[..., :-1] += taken[:, None, None] * step
            if (
                np.all(taken == 1.0)
                and np.isinf(dt).all()
                and np.abs(change / molar[:, None, None]).max() < EXACT
            ):
                return xi
        return None


def in_pellets(
    reactions: Sequence[Reaction],
    gases: Mapping[str, Any],
    diffusivities: Mapping[str, float],
    solids: float,
) -> list[Reaction]:
    """Return reactions of a solid phase with those of gases in particles as means over
    resolved pellets.

    Parameters
    ----------
    diffusivities : of the gases that react in the pellets [m2/s]
    solids : volume of pellets per volume of bed
    """
    chosen = [
        each
        for each in reactions
        if runs_in_pellets(each.site, each.own_film, each.stoichiometry, gases)
    ]
    if not chosen:
        return list(reactions)
    pellets = Pellets.of(chosen, diffusivities, solids)
    resolved = {each.name: each for each in pellets.resolved()}
    return [resolved.get(each.name, each) for each in reactions]


def runs_in_pellets(
    site: str, own_film: bool, species: Mapping[str, float], gases: Mapping[str, Any]
) -> bool:
    """Return whether a reaction is one of gases alone in particles."""
    return site != "gas" and not own_film and all(name in gases for name in species)

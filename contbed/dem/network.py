"""Steady conduction through an assembly as a network of resistors: effective
conductivity and what each part adds.

Two ways: between two layers of particles held at temperatures, which is how a bed is
measured, and in a periodic cell under a mean gradient, which gives the full tensor
without end effects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from contbed.arrays import Array
from contbed.dem.heat import Pairs, total
from contbed.errors import ConvergenceError, SceneError
from contbed.solvers.multigrid import aggregation_cycle

# unknowns up to which factors are made: of 10,000 they take 1.1 s, of 40,000 25 s and
# 1.1 GB
DIRECT = 5_000
# residual over load of the iteration; balances of heat close to about 1e-14 then
TOLERANCE = 1e-13
MOST_ITERATIONS = 200  # 15 to 22 are needed from 10,000 to 1,000,000 particles
MIDDLE = 0.8  # share of the height between the layers in which the slope is taken

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Layers:
    """Steady heat between two layers.

    Attributes
    ----------
    conductivity : heat flux over the slope of temperature in the middle of the
        bed [W/m/K]
    between : heat flux times the distance of the layers over their difference, the
        paper's q H_b/(T_b - T_t) [W/m/K]: 4 to 8 % lower, because heat runs on inside
        the layers
    heat : from the hot to the cold layer [W]
    T : of each particle [K], nan where nothing connects it to a layer
    shares : part of each mechanism in the dissipation, sum 1
    imbalance : (what leaves the hot less what enters the cold layer) over the heat
    isolated : number of particles that nothing connects
    """

    conductivity: float
    between: float
    heat: float
    T: Array
    shares: dict[str, float]
    imbalance: float
    isolated: int

    @property
    def mean(self) -> float:
        """Effective conductivity along the heat flux [W/m/K]."""
        return self.conductivity


@dataclass(frozen=True)
class Cell:
    """Conductivity tensor of a periodic cell [W/m/K], and the tensors of the
    mechanisms, which sum to it.
    """

    conductivity: Array
    parts: dict[str, Array]

    @property
    def mean(self) -> float:
        """Effective conductivity, the mean of the axes [W/m/K]."""
        return float(np.trace(self.conductivity)) / 3.0


def between_layers(
    x: Array,
    pairs: Pairs,
    parts: Mapping[str, Array],
    hot: Mask,
    cold: Mask,
    area: float,
    T_layers: tuple[float, float] = (398.15, 298.15),
    axis: int = 2,
) -> Layers:
    """Solve for the temperatures between two layers of particles.

    Parameters
    ----------
    x : centres [m], (n, 3)
    pairs, parts : from `heat.near_pairs` and `heat.conductances`
    hot, cold : masks of the particles of the layers, whose temperatures are `T_layers` [K]
    area : cross-section of the bed [m2]
    axis : along which heat flows

    Raises
    ------
    SceneError : a layer is empty, a particle is in both, or nothing connects them
    """
    T_hot, T_cold = T_layers
    if not hot.any() or not cold.any() or (hot & cold).any():
        raise SceneError(
            f"layers of {hot.sum()} hot and {cold.sum()} cold particles, "
            f"{(hot & cold).sum()} in both; "
            "each needs particles of its own"
        )
    G = total(parts)
    n = len(x)
    matrix = _laplacian(n, pairs, G)
    fixed = hot | cold
    _, label = connected_components(_adjacency(n, pairs, G), directed=False)
    if not set(label[hot]) & set(label[cold]):
        raise SceneError("no chain of particles connects the hot and the cold layer")
    tied = np.isin(label, label[fixed])
    free = tied & ~fixed
    T = np.where(hot, T_hot, np.where(cold, T_cold, np.nan))
    # measured from the cold layer, so that rounding is relative to the difference
    lift = np.where(hot, T_hot - T_cold, 0.0)
    if free.any():
        lift[free] = _solve(
            matrix[free][:, free], -(matrix[free][:, fixed] @ lift[fixed])
        )
        T[free] = T_cold + lift[free]
    flow = matrix @ lift
    heat = float(flow[hot].sum())
    z = x[:, axis]
    ends = sorted((_edge(z, hot, cold), _edge(z, cold, hot)))
    rim = 0.5 * (1.0 - MIDDLE) * (ends[1] - ends[0])
    core = tied & (z >= ends[0] + rim) & (z <= ends[1] - rim)
    slope = float(np.polyfit(z[core], lift[core], 1)[0])
    difference = lift[pairs.i] - lift[pairs.j]
    shares = {
        name: float(part @ difference**2) / (heat * (T_hot - T_cold))
        for name, part in parts.items()
    }
    return Layers(
        conductivity=heat / area / abs(slope),
        between=heat / area * (ends[1] - ends[0]) / abs(T_hot - T_cold),
        heat=heat,
        T=T,
        shares=shares,
        imbalance=float(flow[hot].sum() + flow[cold].sum()) / heat,
        isolated=int(n - tied.sum()),
    )


def periodic_cell(
    count: int, pairs: Pairs, parts: Mapping[str, Array], volume: float
) -> Cell:
    """Solve for the conductivity tensor of a periodic cell with `count` particles in
    `volume` [m3].

    T_i = E.x_i + theta_i; with v the vector from i to j and
    D_a = v_a + theta_j - theta_i for E along a,

        k_ab = sum over pairs of G D_a D_b/volume
    """
    G = total(parts)
    v = pairs.vector
    matrix = _laplacian(count, pairs, G)
    # one particle of each connected part is held: theta is known up to a constant there
    _, label = connected_components(_adjacency(count, pairs, G), directed=False)
    free = np.ones(count, dtype=bool)
    free[np.unique(label, return_index=True)[1]] = False
    theta = np.zeros((count, 3))
    if free.any():
        load = np.stack(
            [
                np.bincount(pairs.i, G * v[:, a], count)
                - np.bincount(pairs.j, G * v[:, a], count)
                for a in range(3)
            ],
            1,
        )
        theta[free] = _solve(matrix[free][:, free], load[free])
    D = v + theta[pairs.j] - theta[pairs.i]
    tensors = {
        name: np.einsum("p,pa,pb->ab", part, D, D) / volume
        for name, part in parts.items()
    }
    return Cell(np.sum(list(tensors.values()), axis=0), tensors)


def _edge(z: Array, layer: Mask, other: Mask) -> float:
    """Find where a layer ends towards the other one [m]."""
    return float(
        z[layer].max() if z[layer].mean() < z[other].mean() else z[layer].min()
    )


def _adjacency(n: int, pairs: Pairs, G: Array) -> csr_matrix:
    return coo_matrix((G, (pairs.i, pairs.j)), (n, n)).tocsr()


def _laplacian(n: int, pairs: Pairs, G: Array) -> csr_matrix:
    i, j = pairs.i, pairs.j
    rows, columns = np.concatenate([i, j, i, j]), np.concatenate([i, j, j, i])
    return coo_matrix((np.concatenate([G, G, -G, -G]), (rows, columns)), (n, n)).tocsr()


def _solve(matrix: csr_matrix, load: Array) -> Array:
    """Solve directly with one step of iterative refinement, or by multigrid where
    factors would be large.
    """
    if matrix.shape[0] > DIRECT:
        return _solve_by_multigrid(matrix.tocsr(), load)
    factors = splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
    )
    first = factors.solve(load)
    return np.asarray(first + factors.solve(load - matrix @ first))


def _solve_by_multigrid(matrix: csr_matrix, load: Array) -> Array:
    """Solve by conjugate gradients with a cycle of smoothed aggregation, in time and
    memory that grow with the size.

    Source: Vanek, Mandel and Brezina, Computing 56 (1996) 179, doi:10.1007/BF02238511.
    """
    from pyamg.krylov import cg

    cycle = aggregation_cycle(matrix, "hermitian", "gauss_seidel")
    columns = []
    for column in load.reshape(len(load), -1).T:
        found, status = cg(
            matrix, column, tol=TOLERANCE, maxiter=MOST_ITERATIONS, M=cycle
        )
        if status != 0:
            left = float(
                np.linalg.norm(column - matrix @ found) / np.linalg.norm(column)
            )
            raise ConvergenceError(
                f"network: temperatures of {len(load)} particles are not found in "
                f"{MOST_ITERATIONS} iterations, "
                f"residual {left:.2g} of the heat, {TOLERANCE:g} is wanted; leave out "
                "contacts that hardly conduct"
            )
        columns.append(found)
    return np.stack(columns, axis=1).reshape(load.shape)

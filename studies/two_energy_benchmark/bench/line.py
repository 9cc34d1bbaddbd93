"""The slip row of Pivem & de Lemos: user time and largest error of contbed and of
upwind finite volumes.

line.py automatic TOLERANCE...      contbed as it comes
line.py uniform DEGREE CELLS...     its engine on uniform square cells in 2-D
line.py volumes CELLS...            first-order upwind finite volumes on the same cells
"""

import sys

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from common import LINE, coefficients, largest_error, report, timed

import contbed


def solve_scene(**changes: float) -> None:
    """Time contbed on the slip row with some settings replaced."""
    from contbed.loading import load

    scene = load(
        LINE, {name.replace("__", "."): value for name, value in changes.items()}
    )
    seconds, result = timed(lambda: contbed.run(scene))
    x, fluid, solid = (
        result.profiles[name]
        for name in ("x [m]", "theta_fluid [1]", "theta_solid [1]")
    )
    report(
        result.plan.unknowns()["heat"],
        largest_error(x, fluid, solid, coefficients()),
        seconds,
    )


def cells_across(along: int, c: dict[str, float]) -> int:
    """Number of cells across the channel that makes them square."""
    return max(1, round(along * c["height"] / c["length"]))


def volumes(
    along: int, c: dict[str, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres and both temperatures on the middle row of cells."""
    across = cells_across(along, c)
    dx, dy = c["length"] / along, c["height"] / across

    def balance(flux: float, d: float) -> tuple[sp.spmatrix, np.ndarray]:
        """Matrix of convection and conduction per volume, and the weight of the
        inlet value in the first cells.
        """
        convection = sp.diags(
            [np.full(along, flux / dx), np.full(along - 1, -flux / dx)], [0, -1]
        )
        near = np.full(along, 2.0)
        near[0], near[-1] = 3.0, 1.0
        conduction = sp.diags(
            [near, -np.ones(along - 1), -np.ones(along - 1)], [0, 1, -1]
        ) * (d / dx**2)
        sides = np.full(across, 2.0)
        sides[[0, -1]] = 1.0 if across > 1 else 0.0
        lateral = sp.diags(
            [sides, -np.ones(across - 1), -np.ones(across - 1)], [0, 1, -1]
        ) * (d / dy**2)
        inlet = np.zeros((along, across))
        inlet[0] = flux / dx + 2.0 * d / dx**2
        one = sp.eye(across)
        return sp.kron(convection + conduction, one) + sp.kron(
            sp.eye(along), lateral
        ), inlet.ravel()

    fluid, _ = balance(c["flux_fluid"], c["d_fluid"])
    solid, inlet = balance(c["flux_solid"], c["d_solid"])
    exchange = c["ha"] * sp.eye(along * across)
    # both temperatures of a cell are neighbours in the numbering
    pair = sp.kron(fluid + exchange, [[1, 0], [0, 0]]) + sp.kron(
        solid + exchange, [[0, 0], [0, 1]]
    )
    matrix = (pair - sp.kron(exchange, [[0, 1], [1, 0]])).tocsc()
    options = {
        "permc_spec": "MMD_AT_PLUS_A",
        "diag_pivot_thresh": 0.0,
        "options": {"SymmetricMode": True},
    }
    both = spla.splu(matrix, **options).solve(np.kron(inlet, [0.0, 1.0]))
    middle = both.reshape(along, across, 2)[:, across // 2]
    return (np.arange(along) + 0.5) * dx, middle[:, 0], middle[:, 1]


def main() -> None:
    kind, *arguments = sys.argv[1:]
    c = coefficients()
    if kind == "automatic":
        for tolerance in arguments:
            solve_scene(solver__tolerance=float(tolerance))
    elif kind == "uniform":
        degree, *sizes = map(int, arguments)
        for along in sizes:
            cells = [along, cells_across(along, c)]
            solve_scene(
                mesh__cells=cells,
                solver__degree=degree,
                solver__reduce=False,
                solver__adapt=0,
            )
    else:
        for along in map(int, arguments):
            seconds, (x, fluid, solid) = timed(lambda along=along: volumes(along, c))
            report(
                2 * along * cells_across(along, c),
                largest_error(x, fluid, solid, c),
                seconds,
            )


main()

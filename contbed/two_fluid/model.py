"""What a two-fluid step needs besides the state: grid, materials, closures, boundary
conditions, options, solver.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from contbed.two_fluid import boundary
from contbed.two_fluid.compiled import Array, Flags, Indices
from contbed.two_fluid.end_pressure import EndPressure, end_pressure
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.kernels import Kernels, kernels_of
from contbed.two_fluid.linear.pressure_solver import PressureSolver, SolvesPressure
from contbed.two_fluid.rheology import Closures
from contbed.two_fluid.timing import Timer

if TYPE_CHECKING:
    from contbed.two_fluid.heat.model import HeatModel


@dataclass(frozen=True)
class Materials:
    """Densities [kg/m3], gas viscosity [Pa s], particle diameter [m], packing limit,
    gravity [m/s2].
    """

    rho_gas: float
    mu_gas: float
    rho_solid: float
    d_p: float
    eps_max: float
    gravity: tuple[float, ...]


@dataclass(frozen=True)
class Options:
    """How to step.

    courant : largest share of a cell that particles cross in a step, and gas in a
        sub-cycle of its temperature
    dt_max, dt_first [s] : largest and first step; growth : of the step at most
    dt [s] : fixed step, instead of the Courant number
    limited : limit reconstructions; off keeps full order for smooth fields
    theta : "pde", "algebraic" (production balances dissipation) or "frozen"
    """

    courant: float = 0.5
    dt_max: float = 1e-2
    dt_first: float = 1e-5
    growth: float = 1.1
    dt: float | None = None
    limited: bool = True
    theta: Literal["pde", "algebraic", "frozen"] = "pde"


class Sources(NamedTuple):
    """Sources per volume, zero unless set.

    Of solids and gas volume (nc,) [1/s], accelerations (nc, dim) [m/s2] of both phases,
    and granular energy (nc,) [W/m3].
    """

    solid: Array
    gas: Array
    force_gas: Array
    force_solid: Array
    theta: Array


@dataclass(frozen=True, eq=False)
class Model:
    """A bed without its state.

    edge : boundary conditions of each face
    pressure_solver : of the pressure equation, with its workspace
    closed : nothing flows through and gravity acts along the walls, so that at rest the
        volume flux is zero
    heat : None for an isothermal bed
    timer : wall time of the phases of the step
    """

    grid: Grid
    materials: Materials
    closures: Closures
    edge: boundary.Edge
    options: Options
    sources: Sources
    pressure_solver: SolvesPressure
    closed: bool
    heat: HeatModel | None
    timer: Timer

    @cached_property
    def kernels(self) -> Kernels:
        """Kernels that suit the grid."""
        return kernels_of(self.grid)

    @cached_property
    def gravity(self) -> Array:
        """Gravity (dim,) [m/s2]."""
        return np.array(self.materials.gravity, dtype=float)

    @cached_property
    def boundary_cells(self) -> Indices:
        """Cell (nb,) of each boundary face."""
        cells: Indices = self.grid.geometry.left[self.grid.interior :]
        return cells

    @cached_property
    def open_faces(self) -> Array:
        """1 at boundary faces (nb,) beyond which nothing holds particles that rub:
        outlets, but for those in a roof.
        """
        up = -self.grid.geometry.normal[self.grid.interior :] @ self.gravity
        roof = up > boundary.MIN_UPRIGHT * np.linalg.norm(self.gravity)
        return np.where(roof, 0.0, self.edge.solid.kind == boundary.OUTLET)

    @cached_property
    def ends(self) -> tuple[EndPressure, EndPressure]:
        """Pressure of floor and roof."""
        return end_pressure(self.grid, self.edge, -1), end_pressure(
            self.grid, self.edge, 1
        )

    @cached_property
    def no_cells(self) -> Flags:
        """Marks no cell (nc,)."""
        return np.zeros(len(self.grid.cells), dtype=np.bool_)

    @cached_property
    def gas_viscosity(self) -> Array:
        """Viscosity (nc,) [Pa s] of the gas."""
        return np.full(len(self.grid.cells), self.materials.mu_gas)

    @cached_property
    def gas_bulk_viscosity(self) -> Array:
        """Bulk viscosity (nc,) [Pa s] of the gas, zero."""
        return np.zeros(len(self.grid.cells))


def build_model(
    grid: Grid,
    materials: Materials,
    closures: Closures,
    boundaries: Mapping[str, boundary.Condition],
    options: Options | None = None,
    heat: HeatModel | None = None,
) -> Model:
    """Model of a bed.

    Raises
    ------
    SceneError : conditions and boundaries do not match; a mesh that the pressure solver
        cannot use
    """
    edge = boundary.assemble(grid, boundaries, materials.rho_solid)
    nc, dim = len(grid.cells), grid.dimension
    across = grid.geometry.normal[grid.interior :] @ np.array(
        materials.gravity, dtype=float
    )
    return Model(
        grid,
        materials,
        closures,
        edge,
        options if options is not None else Options(),
        Sources(
            np.zeros(nc),
            np.zeros(nc),
            np.zeros((nc, dim), order=grid.order),
            np.zeros((nc, dim), order=grid.order),
            np.zeros(nc),
        ),
        PressureSolver(grid, not (edge.gas.kind == boundary.OUTLET).any()),
        bool(across.any() and (edge.gas.kind == boundary.WALL).all()),
        heat,
        Timer(),
    )

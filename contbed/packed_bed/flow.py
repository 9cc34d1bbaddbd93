"""Solution of the porous flow of a scene on its mesh: boundary values, Newton,
volume-flow balance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.fem import system as make_system
from contbed.fem.ad.dual import Components
from contbed.fem.skfem import System
from contbed.fem.tensor_error import TensorGrid
from contbed.mesh.mesh import Mesh
from contbed.packed_bed.curved_inlet import (
    PARALLEL,
    inward_normals,
    mean_speed,
    outward_normals,
    turn_along,
)
from contbed.packed_bed.equations import porous_flow
from contbed.result import Result
from contbed.solvers.newton import Options, newton

# sine to a wall of triangles whose corners lie on a curved one: that of 12 triangles
# around a tube, of irregular shape
LARGEST_TILT = 0.15
# share of the flow that may pass through all such triangles, and through those up to a
# place, which divides some of them
THROUGH_ALL, THROUGH_SOME = 0.005, 0.02
AT_REST = 1.0  # velocity scale [m/s] where nothing moves; any rounds the drag


@dataclass(frozen=True)
class LocalProperties:
    """Properties of the fluid at the temperature of each node of a space: arrays
    (size,).
    """

    space: Any
    expansion: Any  # density of the inlet over that at the node [1]
    viscosity: Any  # [Pa s]


@dataclass(frozen=True)
class Flow:
    """The flow of the fluid: `state` and `system` of the form, and the properties that
    it was solved with.

    `velocity` (dim, size) on quadratic elements is the mass flux over the density of
    the medium, and so free of divergence; `expanded` is the velocity. `share` is the
    mass flux that it was solved for over that at this density.
    """

    system: System
    state: Any
    porosity: float
    local: LocalProperties | None = None
    share: float = 1.0

    @property
    def velocity(self) -> Any:
        """Nodal mass flux over the density of the inlet (dim, size) [m/s]."""
        return self.system.part(self.state, "u")

    @property
    def expanded(self) -> Any:
        """Nodal superficial velocity (dim, size) [m/s]."""
        if self.local is None:
            return self.velocity
        return self.velocity * self.local.space.interpolated(
            self.local.expansion, self.system.fields["u"][0]
        )

    @property
    def pressure(self) -> Any:
        """Nodal pressure of the fluid over that at the outlet [Pa] (size,); the form
        solves for porosity times this.
        """
        return self.system.part(self.state, "p") / self.porosity

    def outflow(self, boundary: str) -> float:
        """Return the volume flow out of a boundary [m3/s]."""
        return self.system.integrate(
            porous_flow.volume_flow, self.system.boundary(boundary), self.state
        )


def constant_normal(mesh: Mesh, boundary: str) -> Any:
    """Return the outward unit normal of a plane boundary; None if it is not plane."""
    normals = unit_normals(mesh, boundary)
    return normals[0] if np.abs(normals - normals[0]).max() < PARALLEL else None


def unit_normals(mesh: Mesh, boundary: str) -> Any:
    """Return the outward unit normals of the facets of a boundary, one a row."""
    normals = outward_normals(mesh.skfem, mesh.skfem.boundaries[boundary])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def is_across(mesh: Mesh, boundary: str, direction: Any) -> bool:
    """Return whether a boundary is a plane across a direction."""
    normal, length = constant_normal(mesh, boundary), float(np.linalg.norm(direction))
    return normal is not None and abs(normal @ direction) > (1.0 - PARALLEL) * length


def passes_along(mesh: Mesh, boundary: str, velocity: Any) -> bool:
    """Return whether a uniform velocity passes along a boundary everywhere, but for the
    tilts of triangles with corners on a curved wall.

    These cancel. What flows through all triangles, and its moments with their normals,
    which a duct that leads aside has, is then little of what flows through the bed, and
    so is that up to any place along the flow.
    """
    direction = np.asarray(velocity) / max(float(np.linalg.norm(velocity)), 1e-300)
    areas = outward_normals(mesh.skfem, mesh.skfem.boundaries[boundary])
    sizes = np.linalg.norm(areas, axis=1)
    normals = areas / sizes[:, None]
    tilts = normals @ direction
    if np.abs(tilts).max() <= PARALLEL:
        return True
    if mesh.skfem.dim() < 3 or np.abs(tilts).max() > LARGEST_TILT:
        return False
    grid = mesh.skfem
    corners = grid.p[:, grid.facets[:, grid.boundaries[boundary]]]
    order = np.argsort(direction @ corners.mean(axis=1))
    across = normals - np.outer(tilts, direction)
    through = (tilts * sizes)[:, None] * np.column_stack((np.ones(len(sizes)), across))
    exterior = outward_normals(grid, grid.boundary_facets())
    section = 0.5 * float(np.abs(exterior @ direction).sum())
    passed = np.abs(np.cumsum(through[order], axis=0)) / section
    return bool(passed[-1].max() <= THROUGH_ALL and passed.max() <= THROUGH_SOME)


def is_along(mesh: Mesh, boundary: str, velocity: Any) -> bool:
    """Return whether a uniform velocity passes along a boundary everywhere.

    Raises
    ------
    SceneError : it does not, and the boundary does not consist of planes along the
        coordinate axes, where flow with slip is solved
    """
    if passes_along(mesh, boundary, velocity):
        return True
    slip_axes(mesh, boundary)
    return False


def slip_axes(mesh: Mesh, boundary: str) -> Any:
    """Return the axis across each facet of a slip wall.

    Raises
    ------
    SceneError : not all of it lies in planes along the coordinate axes
    """
    if not has_axial_planes(mesh, boundary):
        raise SceneError(
            f"boundary.{boundary}: a slip wall that the flow meets must consist of "
            "planes along the coordinate axes; give other parts names of their own with "
            'type = "no_slip"'
        )
    return np.abs(unit_normals(mesh, boundary)).argmax(axis=1)


def has_axial_planes(mesh: Mesh, boundary: str) -> bool:
    """Return whether a boundary consists of planes along the coordinate axes."""
    normals = np.sort(np.abs(unit_normals(mesh, boundary)), axis=1)
    return bool(normals[:, :-1].max(initial=0.0) <= PARALLEL)


def solved_flow(
    plan: Any,
    before: Flow | None,
    result: Result,
    local: LocalProperties | None = None,
    share: float = 1.0,
) -> Flow:
    """Newton from uniform flow, or from the flow `before` on this or another mesh of
    the same bed.

    `local` are properties that vary in the bed; for `share` see `Flow`.

    Inlet nodes keep the inlet velocity also where a no-slip wall begins, so that the
    volume flow is the prescribed one.
    """
    equations = equations_of(plan, local, None, share)
    system = equations.system
    state = np.zeros(system.size)
    system.part(state, "u")[:] = share * plan.velocity[:, None]
    if before is not None:
        _carry(before, system, state)
    state, history = newton(
        equations.residual,
        equations.with_given(state),
        equations.fixed,
        system.ordered(plan.policy),
        Options.of(plan.scene, what="flow"),
    )
    result.history += history
    return Flow(system, state, plan.scene.packed_bed.porosity, local, share)


def equations_of(
    plan: Any,
    local: LocalProperties | None,
    system: System | None = None,
    share: float = 1.0,
) -> FlowEquations:
    """Return the discrete equations of the flow of a plan; see `flow_equations`."""
    c, inlet = coefficients(plan), share * plan.velocity
    if plan.curved_inlet:
        inlet = float(np.linalg.norm(inlet))
    return flow_equations(plan.mesh, c, inlet, plan.roles, local, system)


@dataclass(frozen=True)
class FlowEquations:
    """The discrete equations of the flow: the form on its system, and the nodes that
    are given.

    `given` are the numbers of the prescribed velocities and `values` these
    velocities [m/s]; `fixed` holds the numbers of all unknowns that stay as they are, a
    pressure between walls included.
    """

    system: System
    form: list[Any]
    given: Any
    values: Any
    fixed: Any

    def with_given(self, state: Any) -> Any:
        """Return a state with the prescribed velocities in place."""
        state = state.copy()
        state[self.given] = self.values
        return state

    def residual(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual and its Jacobian."""
        return self.system.assemble(self.form, state, jacobian)


def flow_equations(
    mesh: Mesh,
    c: porous_flow.Coefficients,
    inlet: Any,
    roles: dict[str, str],
    local: LocalProperties | None = None,
    system: System | None = None,
) -> FlowEquations:
    """Return the discrete equations of a flow; see `solved_flow`.

    `inlet` is a vector, or the speed along the normals of a curved inlet [m/s];
    `roles` maps each boundary to inlet, outlet, no_slip or slip; `system` is that of an
    earlier flow on this mesh.
    """
    dim = mesh.skfem.dim()
    # of the drag where the fluid moves with the bed
    kink = c.forchheimer > 0 and any(c.comoving_velocity.items)
    if system is None:
        system = make_system(mesh, {"u": (2, dim), "p": (1, 0)}, 9 if kink else 5)
    velocities = np.full(system.size, np.nan)
    curved = np.ndim(inlet) == 0
    of_kind = {
        kind: [name for name, role in roles.items() if role == kind]
        for kind in ("slip", "no_slip", "inlet")
    }
    for kind, names in of_kind.items():
        for name in names:
            if kind == "inlet" and curved:
                numbers, normals = inward_normals(system, mesh.skfem.boundaries[name])
                velocities[numbers] = normals
                continue
            facets = mesh.skfem.boundaries[name]
            axes = slip_axes(mesh, name) if kind == "slip" else None
            for k in range(dim):
                met = facets if axes is None else facets[axes == k]
                value = float(inlet[k]) if kind == "inlet" else 0.0
                velocities[system.nodes("u", met, k)] = value
    inlets, walls = of_kind["inlet"], [*of_kind["slip"], *of_kind["no_slip"]]
    wanted = inlet if curved else mean_speed(system, inlets, velocities)
    if turn_along(system, inlets, walls, velocities) or curved:
        velocities *= wanted / mean_speed(system, inlets, velocities)
    given = np.flatnonzero(np.isfinite(velocities))
    fixed = given
    # between walls the pressure is known but for a constant
    if "outlet" not in roles.values():
        pinned = system.nodes("p", next(iter(mesh.skfem.boundaries.values())))[:1]
        fixed = np.unique(np.concatenate([given, pinned]))
    if local is not None:
        expansion, viscosity = (
            system.known(system.cells, local.space, x)
            for x in (local.expansion, local.viscosity)
        )
        c = replace(c, expansion=expansion, viscosity=viscosity)
    return FlowEquations(
        system,
        [(porous_flow.residual, system.cells, c)],
        given,
        velocities[given],
        fixed,
    )


def _carry(before: Flow, system: System, state: Any) -> None:
    """Interpolate a flow on a tensor-product mesh to another one, or take it as it
    is on the same mesh.
    """
    old, new = before.system, system
    if old.mesh is new.mesh:
        state[:] = before.state
        return
    for name in new.fields:
        former, grid = (TensorGrid.of(one.fields[name][0]) for one in (old, new))
        if former is None or grid is None:
            return
        for row, values in zip(
            _rows(new, state, name), _rows(old, before.state, name), strict=True
        ):
            row[:] = grid.nodal(
                former.interpolated(former.values(values), grid.coordinates)
            )


def _rows(system: System, state: Any, name: str) -> Any:
    return np.atleast_2d(system.part(state, name))


def coefficients(plan: Any) -> porous_flow.Coefficients:
    """Return the momentum coefficients of a plan at the fluid's inlet temperature."""
    medium = plan.medium
    return porous_flow.Coefficients(
        density=medium.mass_flux_scale(),
        viscosity=float(medium.fluid.viscosity(medium.T_fluid_in)),
        porosity=plan.scene.packed_bed.porosity,
        permeability=medium.packing("permeability"),
        forchheimer=medium.packing("forchheimer"),
        comoving_velocity=Components(
            float(v) for v in medium.comoving(plan.velocity_solid)
        ),
        speed=plan.speed or AT_REST,
    )

"""Accuracy of a steady bed on a tensor-product mesh: estimated errors of theta and
velocity, and the next mesh.

The error in each direction is estimated from the next derivative along lines of nodes;
see `fem.tensor_error`. Once the mesh has changed, the difference of the two solutions
is the error of the former one to leading order: where it exceeds the estimate of that
mesh, as it does where errors are carried along the bed, the new estimate is raised as
much.

Where prescribed temperatures jump between two sides, or a no-slip wall begins at an
inlet, the solution has no value at the corner. Errors within `JUMP_RADIUS` of it count
by their distance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from contbed.fem.tensor_error import TensorGrid, balanced
from contbed.fields import distinct
from contbed.packed_bed.corners import Side, adjacent_sides, unlike_temperatures
from contbed.packed_bed.schedule import PHASES

# share of the smallest extent of the bed around a corner where temperatures jump
JUMP_RADIUS = 0.01
# error of the velocity over that at the inlet, largest that an automatic mesh leaves
FLOW_TOLERANCE = 1e-3
# error of the velocity over that of theta: layers at walls carry little of the stream
FLOW_RATIO = 100.0
GIVEN_THETA = 1e-3  # error of theta above which a mesh of given cells gets a warning
GIVEN_VELOCITY = 1e-2  # the same for the velocity over that at the inlet
# factor by which cells grow until few enough, and its limit
RELAXATION, MOST_RELAXED = 1.1, 100.0
MOST_CELLS_TOLD = 10**9  # where only the number of cells needed is reported
# share of the largest number of cells from which a mesh cannot be much better
FULL = 0.8
# share of the tolerance aimed at in each direction, as those of all directions add up
SHARE = 0.3


@dataclass(frozen=True)
class Field:
    """Nodal values on a grid over their scale, the tolerance and the estimated
    errors by direction and interval.
    """

    grid: TensorGrid
    values: Any
    weight: Any
    tolerance: float
    errors: tuple[Any, ...]
    raised: float = 1.0

    @property
    def interpolation_error(self) -> float:
        """Return the largest error of interpolation, all directions together."""
        return sum(float(error.max()) for error in self.errors)

    @property
    def error(self) -> float:
        """Return the estimate of the largest error."""
        return self.raised * self.interpolation_error

    def difference(self, before: Field) -> float:
        """Return the largest difference from the same field on another grid."""
        former = before.grid.interpolated(before.values, self.grid.coordinates)
        return float((self.weight * np.abs(self.values - former)).max())


Estimate = dict[str, Field]


def estimated(
    plan: Any, flow: Any, problem: Any, state: Any, before: Estimate | None
) -> Estimate:
    """Estimate the errors of all fields of a plan; none where its mesh is no tensor
    product.

    Parameters
    ----------
    flow, problem, state : the computed flow, the heat problem and its solution; each
        None where there is none
    before : the estimate on the former mesh
    """
    found: Estimate = {}
    tolerance = plan.scene.solver.tolerance
    if flow is not None:
        space = flow.system.fields["u"][0]
        scale = float(np.linalg.norm(plan.velocity)) or 1.0
        corners = _corners(
            plan,
            lambda a, b: {plan.roles[a], plan.roles[b]} == {"inlet", "no_slip"},
        )
        limit = min(FLOW_TOLERANCE, FLOW_RATIO * tolerance)
        for k, values in enumerate(flow.velocity):
            found[f"u{k}"] = _field(space, values / scale, corners, limit)
    if problem is not None:
        space, span = problem.system.fields["T_fluid"][0], problem.span_of(state)
        for phase in PHASES:
            corners = _corners(
                plan, partial(unlike_temperatures, plan.solved.boundary, phase)
            )
            values = problem.system.part(state, f"T_{phase}") / span
            found[f"T_{phase}"] = _field(space, values, corners, tolerance)
    if None in found.values():
        return {}
    return _raised(found, before) if before else found


def _field(space: Any, values: Any, corners: Any, tolerance: float) -> Any:
    grid = TensorGrid.of(space)
    if grid is None:
        return None
    weight = _weight(grid, corners)
    shaped = grid.values(values)
    return Field(grid, shaped, weight, tolerance, tuple(grid.errors(shaped, weight)))


def _raised(found: Estimate, before: Estimate) -> Estimate:
    """Return the fields with their estimates raised by how much the former ones were
    too small.

    Both temperatures are raised alike, as each carries the error of the other.
    """
    out = dict(found)
    for group in (
        [n for n in found if n.startswith("T")],
        [n for n in found if not n.startswith("T")],
    ):
        former = max((before[name].interpolation_error for name in group), default=1.0)
        raised = max(
            (
                found[name].difference(before[name]) / max(former, 1e-300)
                for name in group
            ),
            default=1.0,
        )
        out |= {name: replace(found[name], raised=max(1.0, raised)) for name in group}
    return out


def _corners(plan: Any, apart: Callable[[str, str], Any]) -> list[tuple[Side, Side]]:
    """Return the corners of a built-in mesh between sides that `apart(name, name)`
    calls incompatible.
    """
    return [
        (a, b)
        for (name, a), (other, b) in adjacent_sides(plan.solved.mesh)
        if apart(name, other)
    ]


def _weight(grid: TensorGrid, corners: list[tuple[Side, Side]]) -> Any:
    """Return factors on errors at the nodes: 1, or the distance from a corner over
    its radius.
    """
    coordinates = grid.coordinates
    weight = np.ones([len(x) for x in coordinates])
    radius = JUMP_RADIUS * min(float(x[-1] - x[0]) for x in coordinates)
    for corner in corners:
        square: Any = 0.0
        for k, position in corner:
            shape = [-1 if axis == k else 1 for axis in range(len(coordinates))]
            square = square + ((coordinates[k] - position) ** 2).reshape(shape)
        weight = np.minimum(weight, np.sqrt(square) / radius)
    return weight


def exceeded(estimate: Estimate) -> bool:
    """Return whether the estimate of a field is above its tolerance."""
    return any(field.error > field.tolerance for field in estimate.values())


def full(estimate: Estimate, before: Estimate | None, limit: int) -> bool:
    """Return whether this mesh and the former one have nearly as many cells as
    `limit` allows.
    """
    grids = [next(iter(each.values())).grid for each in (estimate, before) if each]
    return len(grids) == 2 and all(grid.cells >= FULL * limit for grid in grids)


def next_vertices(estimate: Estimate, limit: int) -> list[Any]:
    """Return coordinates in each direction [m] on which all intervals have equal
    errors.

    These are within the tolerances if that takes at most `limit` cells, else as small
    as the limit allows.
    """
    first = next(iter(estimate.values()))
    factors = [np.full(len(ends) - 1, np.inf) for ends in first.grid.vertices]
    tips = [np.full(2, np.inf) for _ in factors]
    for field in estimate.values():
        power = 1.0 / (field.grid.degree + 1)
        for k, error in enumerate(field.errors):
            wanted = SHARE * field.tolerance / field.raised / np.maximum(error, 1e-300)
            factors[k] = np.minimum(factors[k], wanted**power)
            # in corners of the bed the error is proportional to h
            tips[k] = np.minimum(tips[k], wanted[[0, -1]])
    relaxed = 1.0
    while True:
        lines = zip(first.grid.vertices, factors, tips, strict=True)
        vertices = [
            balanced(ends, relaxed * factor, relaxed * tip)
            for ends, factor, tip in lines
        ]
        if np.prod([len(x) - 1 for x in vertices]) <= limit or relaxed > MOST_RELAXED:
            return vertices
        relaxed *= RELAXATION


def _worst(field: Field, axisymmetric: bool) -> str:
    """Say in which cells of one direction the estimate is largest."""
    k = int(np.argmax([float(error.max()) for error in field.errors]))
    ends, cell = field.grid.vertices[k], int(np.argmax(field.errors[k]))
    return (
        f"{('r', 'z')[k] if axisymmetric else 'xyz'[k]} = "
        f"{0.5 * (ends[cell] + ends[cell + 1]):.4g} m"
    )


def report(plan: Any, estimate: Estimate, result: Any) -> None:
    """Report the estimated errors, with a warning and its remedy where they are
    above what the scene asks for.
    """
    if not estimate:
        return
    given = not plan.balanced
    for name, group, allowed in (
        ("temperature", "T", GIVEN_THETA),
        ("velocity", "u", GIVEN_VELOCITY),
    ):
        fields = [field for key, field in estimate.items() if key.startswith(group)]
        if not fields:
            continue
        error = max(field.error for field in fields)
        result.qoi[
            "estimated_error" if group == "T" else "estimated_error_velocity"
        ] = error
        limit = max(allowed, fields[0].tolerance) if given else fields[0].tolerance
        if error <= limit:
            continue
        wanted = " x ".join(
            str(len(x) - 1) for x in next_vertices(estimate, MOST_CELLS_TOLD)
        )
        over = "of the span of temperatures" if group == "T" else "of that at the inlet"
        where = _worst(
            max(fields, key=lambda field: field.error), plan.mesh.axisymmetric
        )
        wrong, asked = distinct(error, limit)
        text = (
            f"the {name} is wrong by up to about {wrong} {over}, by its "
            f"estimate, most at {where}; "
        )
        if given:
            text += "layers are not resolved by the given cells: leave out mesh.cells"
        else:
            text += (
                f"solver.tolerance asks for {asked}, and an automatic mesh has "
                f"{plan.most_cells} cells at most: "
                "raise solver.tolerance, or give mesh.cells with mesh.graded = true"
            )
        result.warnings.append(f"{text}; graded cells needed are about {wanted}")

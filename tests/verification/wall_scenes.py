"""Random planes and round beds whose walls conduct or exchange heat, and their true
errors from far finer meshes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from moving_beds import moving

from contbed.fem.tensor_error import TensorGrid
from contbed.loading import from_dict
from contbed.mesh.build import build
from contbed.packed_bed import direction_errors
from contbed.packed_bed.corners import unlike_temperatures
from contbed.packed_bed.flow import solved_flow
from contbed.packed_bed.heat import HeatProblem
from contbed.result import Result
from tests.scene_text import scene_of

# smallest cell of a reference mesh over the extent of the bed, at every side
FINEST = 1e-5
RATIO = 2.0  # growth of its cells towards the inside
# smallest cell of a reference mesh over the first cell of the mesh that it judges, at
# most
TIP = 0.25
# distance between vertices over that from the side, below which a further one adds
# nothing
CLOSE = 0.2


def scene(seed: int, **solver: Any) -> Any:
    """Return a bed with one to three walls that conduct or exchange heat.

    Peclet numbers of the bed from 1 to 1e5, Biot numbers of walls from 0.1 to 100,
    exchange layers from a thousandth of the width of the bed to its width.
    """
    rng = np.random.default_rng(seed)

    def spread(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    width, round_bed = spread(0.05, 0.5), bool(rng.integers(2))
    length = width * spread(0.5, 6.0)
    k_fluid, k_solid = spread(0.02, 0.6), spread(0.2, 20.0)
    velocity = spread(0.02, 1.0)
    solid = {0: 0.0, 1: spread(1e-5, 1e-3), 2: -spread(1e-5, 1e-3)}[
        int(rng.integers(3))
    ]
    start, end, walls = (
        ("bottom", "top", ["wall"])
        if round_bed
        else ("left", "right", ["bottom", "top"])
    )

    def wall() -> dict[str, Any]:
        ambient = float(rng.uniform(300.0, 900.0))
        biot = spread(0.1, 100.0)
        kind = int(rng.integers(5))
        if kind == 0:
            return {
                "solids": {"particles": {"fixed_temperature": ambient}},
                "gas": {"fixed_temperature": ambient},
            }
        if kind == 1:
            return {"solids": {"particles": {"fixed_temperature": ambient}}}
        if kind == 2:
            return {"gas": {"coefficient": biot * k_fluid / width, "ambient": ambient}}
        if kind == 3:
            return {
                "solids": {
                    "particles": {
                        "coefficient": biot * k_solid / width,
                        "ambient": ambient,
                    }
                }
            }
        return {
            "solids": {
                "particles": {
                    "heat_flux": float(rng.uniform(0.0, 300.0)) * k_solid / width
                }
            }
        }

    boundary: dict[str, Any] = {name: wall() for name in walls if rng.random() < 0.8}
    boundary = boundary or {walls[0]: wall()}
    boundary[start] = {"gas": {"temperature": 300.0}}
    if solid:
        entrance = start if solid > 0 else end
        boundary.setdefault(entrance, {})["solids"] = {
            "particles": {
                "temperature" if rng.random() < 0.5 else "fixed_temperature": 900.0
            }
        }
    mesh = (
        {"type": "axisymmetric", "radius": width}
        if round_bed
        else {"type": "rectangle", "height": width}
    )
    return from_dict(
        scene_of(
            """
                packed_bed = { porosity = 0.4 }
                heat = {}
                output = { plots = false, fields = false }

                [gas]
                density = 1.0
                heat_capacity = 1000.0
                viscosity = 2e-5

                [solids.particles]
                density = 2000.0
                heat_capacity = 900.0
                diameter = 0.01
            """,
            {
                "mesh": mesh | {"length": length},
                "gas.conductivity": k_fluid,
                "solids.particles.conductivity": k_solid,
                "closures.nusselt": spread(0.02, 200.0),
                "boundary": moving(mesh, boundary, velocity, solid),
                "solver": solver,
            },
        )
    )


def solved(plan: Any) -> tuple[Any, HeatProblem, Any]:
    """Return flow, problem and temperatures of a plan on its mesh."""
    flow = None if plan.plug else solved_flow(plan, None, Result(plan))
    problem = HeatProblem(plan, flow)
    return flow, problem, problem.solve(plan.policy)[0]


def reference(plan: Any, split: int = 2) -> Any:
    """Return the plan on a mesh that keeps the vertices of this one, with `split` cells
    in each of its cells, cells at all sides that are finer than its own, and elements
    of degree 3.
    """
    space = HeatProblem(plan).system
    grid = TensorGrid.of(space.fields["T_fluid"][0])
    vertices = [_finer(ends, split) for ends in grid.vertices]
    scene = plan.solved.model_copy(
        update={"solver": plan.solved.solver.model_copy(update={"degree": 3})}
    )
    return replace(
        plan,
        solved=scene,
        mesh=replace(plan.mesh, skfem=build(scene.mesh, vertices).skfem),
    )


def _finer(ends: Any, split: int) -> Any:
    """Return the vertices `ends` of a line, those of `split` cells in each interval,
    and layers at both sides.

    A vertex of a layer is left out where another one is closer than `CLOSE` times its
    distance from the side. No vertex of `ends` is: at a corner where a stream enters
    beside a wall of fixed temperature the error is proportional to the size of the
    cells, and a reference with larger ones would be wrong by more than the mesh that it
    judges.
    """
    extent = ends[-1] - ends[0]
    inner = [ends[:-1] + np.diff(ends) * part / split for part in range(split)]
    found = np.sort(np.concatenate((*inner, ends[-1:])))
    for side, sign, cell in (
        (ends[0], 1.0, ends[1] - ends[0]),
        (ends[-1], -1.0, ends[-1] - ends[-2]),
    ):
        first = min(FINEST * extent, TIP * cell)
        away = first * RATIO ** np.arange(np.log(0.3 * extent / first) / np.log(RATIO))
        near = side + sign * away
        gap = np.abs(near[:, None] - found).min(axis=1)
        found = np.sort(np.concatenate((found, near[gap > CLOSE * away])))
    return found


def true_errors(
    plan: Any, problem: HeatProblem, state: Any, exact: tuple[HeatProblem, Any]
) -> tuple[float, float]:
    """Return the largest errors of theta and of the heat through a boundary over the
    largest, against a reference.
    """
    span, worst = problem.span_of(state), 0.0
    for phase in ("fluid", "solid"):
        name = f"T_{phase}"
        coarse, fine = (
            (TensorGrid.of(p.system.fields[name][0]), p.system.part(x, name))
            for p, x in ((problem, state), exact)
        )
        corners = direction_errors._corners(
            plan, partial(unlike_temperatures, plan.solved.boundary, phase)
        )
        found = fine[0].interpolated(fine[0].values(fine[1]), coarse[0].coordinates)
        difference = direction_errors._weight(coarse[0], corners) * np.abs(
            found - coarse[0].values(coarse[1])
        )
        worst = max(worst, float(difference.max()) / span)
    one, other = heats(problem, state), heats(*exact)
    scale = max(abs(value) for value in other.values())
    return worst, max(abs(one[name] - other[name]) for name in other) / scale


def heats(problem: HeatProblem, state: Any) -> dict[str, float]:
    """Return the heat into the bed through each boundary [W]."""
    fluxes, reactions = (
        problem.fluxes(state),
        problem.conducted_in(problem.steady(state, False)[0]),
    )
    return {name: reactions[name] + sum(fluxes[name].values()) for name in reactions}

"""What a scene leaves out costs nothing: no import, no unknown, no block of a
matrix, no step.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contbed as cb
from contbed.loading import from_dict
from contbed.packed_bed.heat import HeatProblem
from tests.cases import each_case
from tests.imported import modules_after
from tests.scene_text import scene_of

BED: dict[str, Any] = scene_of(
    """
[mesh]
type = "rectangle"
length = 1.0
height = 0.2
[gas]
density = 1.0
heat_capacity = 1000.0
conductivity = 0.05
viscosity = 2e-5
[solids.particles]
density = 2000.0
heat_capacity = 900.0
conductivity = 1.0
diameter = 0.01
[packed_bed]
porosity = 0.4
[closures]
nusselt = "wakao_kaguei"
[heat]
[boundary.left]
gas.velocity = 0.3
gas.temperature = 300.0
[boundary.right]
solids.particles.velocity = 1e-4
solids.particles.temperature = 500.0
[output]
plots = false
fields = false
"""
)
# one mesh: cells that follow errors are another part, which this scene does not need
COARSE = {**BED, "solver": {"tolerance": 1e-3}}
RADIATING = {"particles": {**BED["solids"]["particles"], "emissivity": 0.8}}


def bed(**tables: Any) -> dict[str, Any]:
    """The bed with tables replaced."""
    return {**BED, **tables}


def plan(**tables: Any) -> Any:
    return cb.plan(from_dict(bed(**tables)))


def problem(made: Any) -> HeatProblem:
    return HeatProblem(made)


def after_run(scene: dict[str, Any], out: Path | None = None) -> set[str]:
    place = None if out is None else str(out)
    code = (
        "import contbed as cb\nfrom contbed.loading import from_dict\n"
        f"cb.run(from_dict({scene!r}), out={place!r})"
    )
    return modules_after(code)


def test_importing_contbed_imports_nothing_heavy():
    found = modules_after("import contbed")
    own = {name for name in found if name.startswith("contbed")}
    assert own == {"contbed", "contbed.compiled", "contbed.compiled.cache"}
    heavy = "scipy skfem pydantic matplotlib meshio gmsh numba pint cantera CoolProp"
    assert not {*heavy.split(), "typer", "rich"} & found


# of other libraries; parts of scipy that take longer to import than the run takes
UNWANTED = """
    cantera CoolProp pint gmsh meshio matplotlib rich numba joblib typer
    scipy.integrate scipy.optimize
"""
NOT_SOLVED = """
    packed_bed.flow packed_bed.time_steps packed_bed.equations.porous_flow
    packed_bed.schumann radiation.problem radiation.results
    radiation.ordinates radiation.rosseland radiation.equations.p1
    radiation.equations.ordinates course.dirk solvers.continuation mesh.gmsh
    scene.units output sweep bubbling_bed reacting_bed two_fluid dem cfd_dem cli
    fem.line_dg closures.formula chemistry
"""


def test_a_bare_run_imports_only_what_it_solves_with(tmp_path):
    unwanted = {*UNWANTED.split()}
    found = after_run(COARSE)
    assert not unwanted & found
    assert not {f"contbed.{name}" for name in NOT_SOLVED.split()} & found
    written = after_run(BED, tmp_path)
    assert not unwanted & written
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "profiles.csv",
        "summary.json",
    ]


@pytest.mark.parametrize(
    ("change", "module"),
    [
        ({"mesh": {**BED["mesh"], "length": "1 m"}}, "pint"),
        ({"gas": {"model": "cantera", "composition": "N2:1"}}, "cantera"),
        ({"solids": RADIATING, "radiation": {}}, "contbed.radiation.problem"),
        (
            {
                "initial": {
                    "gas": {"temperature": 300.0},
                    "solids": {"particles": {"temperature": 300.0}},
                },
                "time": {"end": 1.0, "step": 1.0},
            },
            "contbed.course.dirk",
        ),
        (
            {
                "boundary": {**BED["boundary"], "top": {"type": "no_slip"}},
                "mesh": {**BED["mesh"], "cells": [4, 4]},
            },
            "contbed.packed_bed.flow",
        ),
    ],
    ids=["units", "cantera", "radiation", "time", "flow"],
)
def test_what_is_named_is_imported(change, module):
    assert module in after_run(bed(**change))


def test_plug_flow_has_no_momentum():
    made = plan()
    assert made.plug and "flow" not in made.unknowns()
    assert (
        "porous flow",
        "plug flow: all walls along the flow, uniform inlet",
    ) in made.skipped
    walls = plan(boundary={**BED["boundary"], "top": {"type": "no_slip"}})
    assert not walls.plug and walls.unknowns()["flow"] > 0
    result = cb.run(made.scene)
    assert (
        "flow" not in result.timings
        and np.ptp(result.profiles["u [m/s]"]) == 0.0
        and "fluid volume" not in result.balances
    )


@pytest.mark.parametrize(
    "mesh",
    [
        {"type": "rectangle", "length": 1.0, "height": 0.2},
        {"type": "axisymmetric", "length": 1.0, "radius": 0.2},
        {"type": "box", "length": 1.0, "width": 0.2, "height": 0.1},
    ],
    ids=lambda mesh: mesh["type"],
)
def test_adiabatic_walls_leave_one_dimension(mesh):
    low, high = (
        ("bottom", "top") if mesh["type"] == "axisymmetric" else ("left", "right")
    )
    entering = {"velocity": 1e-4, "temperature": 500.0}
    boundary = {
        low: {"gas": {"velocity": 0.3, "temperature": 300.0}},
        high: {"solids": {"particles": entering}},
    }
    made = plan(mesh=mesh, boundary=boundary)
    assert made.mesh.skfem.dim() == 1
    # two temperatures at the ends and in the middle of each cell
    assert (
        problem(made).system.size
        == made.unknowns()["heat"]
        == 2 * (2 * made.mesh.skfem.nelements + 1)
    )
    wall = "wall" if mesh["type"] == "axisymmetric" else "top"
    if mesh["type"] != "box":
        warm = plan(
            mesh=mesh,
            boundary={
                **boundary,
                wall: {
                    "solids": {"particles": {"coefficient": 10.0, "ambient": 300.0}}
                },
            },
        )
        assert warm.mesh.skfem.dim() == 2


def test_constant_properties_take_one_linear_solve():
    result = cb.run(from_dict(COARSE))
    assert result.history == [1.0]
    assert (
        "Newton for temperatures",
        "constant properties: linear",
    ) in result.plan.skipped
    warm = cb.run(
        from_dict(
            bed(
                solids={
                    "particles": {
                        **BED["solids"]["particles"],
                        "heat_capacity": [600.0, 0.5],
                    }
                }
            )
        )
    )
    assert len(warm.history) > 1


def test_a_linear_problem_assembles_its_matrix_once(monkeypatch):
    made = plan(mesh={"type": "line", "length": 1.0, "cells": 20})
    posed, matrices = problem(made), []
    steady = posed.steady

    def counted(state: Any, jacobian: bool) -> Any:
        matrices.append(jacobian)
        return steady(state, jacobian)

    monkeypatch.setattr(posed, "steady", counted)
    posed.solve(made.policy)
    assert matrices == [True]


def test_absent_terms_are_not_evaluated():
    plain = problem(plan(solver={"stabilisation": False})).coefficients
    assert plain.cross is None
    for phase in (plain.fluid, plain.solid):
        assert (
            phase.tau is None and phase.dispersion is None and phase.divergence is None
        )
        assert isinstance(phase.source, float) and phase.source == 0.0
    full = problem(
        plan(
            closures={
                **BED["closures"],
                "dispersion": {"axial": 1.0},
                "tortuosity": -0.01,
            },
            region={"bed": {"solids": {"heat_source": 1.0}}},
        )
    ).coefficients
    assert (
        full.cross is not None
        and full.fluid.tau is not None
        and full.fluid.dispersion is not None
    )
    assert np.all(full.solid.source == 1.0)


def test_a_phase_at_rest_has_no_stream():
    posed = problem(
        plan(boundary={"left": {"gas": {"velocity": 0.3, "temperature": 300.0}}})
    )
    assert (
        posed.coefficients.solid.mass_flux is None
        and posed.coefficients.solid.tau is None
    )
    # the fluid enters and leaves, and no wall of the solid carries a term
    assert [wall.name for _, _, wall in posed._balances[1:]] == ["T_fluid", "T_fluid"]


def test_adiabatic_ends_have_no_boundary_term():
    posed = problem(plan(boundary={"left": {"gas": {"fixed_temperature": 300.0}}}))
    assert posed._balances[1:] == []


def test_without_radiation_there_is_no_incident_radiation():
    made = plan()
    posed = problem(made)
    assert ("radiation", "no [radiation] table") in made.skipped and set(
        made.unknowns()
    ) == {"heat"}
    assert posed.radiation is None and posed.coefficients.radiated is None
    assert set(posed.system.fields) == {"T_fluid", "T_solid"}
    assert posed.begin(made.policy).tobytes() == posed.initial().tobytes()
    result = cb.run(made.scene)
    assert (
        not {"G [W/m2]", "q_radiation [W/m2]"} & set(result.profiles)
        and "G" not in result.nodal
    )
    # the Rosseland limit is a conductivity: no unknown either
    thick = plan(solids=RADIATING, radiation={"level": "rosseland"})
    assert set(thick.unknowns()) == {"heat"} and "G" not in problem(thick).system.fields


def test_with_radiation_there_is():
    boundary = {
        "left": {
            "gas": {"velocity": 0.3, "temperature": 300.0},
            "radiation": {"temperature": 600.0},
        }
    }
    made = plan(boundary=boundary, solids=RADIATING, radiation={})
    result = cb.run(made.scene)
    assert result.plan.unknowns()["radiation"] == result.nodal["G"][0].size
    x, G, q = (
        result.profiles[name] for name in ("x [m]", "G [W/m2]", "q_radiation [W/m2]")
    )
    assert len(x) == len(G) == len(q) and G.min() > 0
    heat = result.qoi["heat_left_W"]
    # the fluid enters with the lowest temperature, from which heat counts: what is left
    # comes from the radiating wall
    assert heat == pytest.approx(q[0] * 0.2, rel=1e-3)


def test_no_heat_table_has_no_temperatures():
    values = bed(
        mesh={**BED["mesh"], "cells": [4, 4]},
        boundary={"left": {"gas": {"velocity": 0.3}}, "top": {"type": "no_slip"}},
    )
    del values["heat"], values["closures"]
    result = cb.run(from_dict(values))
    assert set(result.plan.unknowns()) == {"flow"}
    assert not any(
        "T_" in name for name in [*result.profiles, *result.nodal, *result.qoi]
    )


@each_case(__file__, "the_plan_tells_what_belongs_to_a_nusselt_number")
def test_the_plan_tells_what_belongs_to_a_nusselt_number(closures, why):
    assert dict(plan(closures=closures).skipped).get("dispersion") == why

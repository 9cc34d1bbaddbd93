"""Heat of walls of two fluids: on any mesh that of a layer which the cells need not
resolve.
"""

import numpy as np
import pytest
from core_closures import bed, closures, line, rectangle, shaken_mesh
from pytest import approx
from scipy.special import erf, erfcx

import contbed as cb
from contbed import closures as closure
from contbed.loading import from_dict
from contbed.mesh import build as meshing
from contbed.models import plan
from contbed.scene.mesh import MeshAxisymmetric, MeshBox
from contbed.two_fluid import run as study
from contbed.two_fluid.boundary import (
    GivenFields,
    InletCondition,
    OutletCondition,
    symmetry,
)
from contbed.two_fluid.fv import grid
from contbed.two_fluid.heat.equations import stored_heat
from contbed.two_fluid.heat.model import Physics, Thermal, build_heat
from contbed.two_fluid.model import Options
from tests.cases import each_case
from tests.refusals import refused
from tests.restarts import interrupt, same_run
from tests.scene_text import changed, scene_of

SLIP = symmetry()
CP_GAS, CP_SOLID, RHO_GAS, RHO_SOLID, EPS_S = 1000.0, 800.0, 1.2, 2500.0, 0.5
K_GAS, K_SOLID = 0.02, 0.18
K = K_GAS + K_SOLID
# heat capacity [J/m3/K] of gas and particles
C = RHO_GAS * (1 - EPS_S) * CP_GAS + RHO_SOLID * EPS_S * CP_SOLID
BOX = {"type": "box", "length": 0.02, "width": 0.03, "height": 0.04}
# what a second of conduction is off on any mesh at most
AT_REST = 0.03


def heated(on, sides, thermal, conductivity=(K_GAS, K_SOLID), **given):
    """A bed that conducts, with so much exchange that both phases are equally warm."""

    def conduct(eps_s, *_):
        flat = np.ones_like(eps_s)
        return conductivity[0] * flat, conductivity[1] * flat

    physics = Physics(CP_GAS, CP_SOLID, lambda s, *_: np.full_like(s, 1e4), conduct)
    heat = build_heat(on, physics, thermal)
    options = given.pop("options", Options(dt_max=0.01))
    still = {"gravity": (0.0,) * on.dimension, "options": options} | given
    return bed(on, closures(), sides, heat=heat, rho_solid=RHO_SOLID, **still)


def at_rest(on, thermal, T=300.0, **given):
    """The same, at rest and at one temperature."""
    made = heated(on, dict.fromkeys(on.boundaries, SLIP), thermal, **given)
    made.start(eps_s=EPS_S, T_gas=T, T_solid=T)
    return made


def conducted(t, difference=1.0):
    """Heat [J/m2] into half a space after t [s]."""
    return 2.0 * K * difference * np.sqrt(t * C / (np.pi * K))


def scene(cells, **changes):
    """Particles at rest beside a hot wall, 1 s."""
    made = scene_of(
        """
        model = "two_fluid"
        [mesh]
        type = "line"
        length = 0.1
        [two_fluid]
        gravity = 0.0
        [gas]
        density = 1.2
        viscosity = 1.8e-5
        heat_capacity = 1005.0
        conductivity = 0.026
        [solids.beads]
        diameter = 5e-4
        density = 2600.0
        heat_capacity = 800.0
        conductivity = 1.0
        [closures]
        conductivity_bed = "zehner_schluender"
        [initial]
        gas.temperature = 300.0
        solids.beads.volume_fraction = 0.58
        solids.beads.granular_temperature = 1e-8
        [boundary.left]
        type = "wall"
        temperature = 380.0
        [boundary.right]
        type = "wall"
        [heat]
        [time]
        end = 1.0
        [output]
        plots = false
        fields = false
        """,
        {"mesh.cells": cells},
    )
    return made | changes


@pytest.mark.parametrize("cells", [10, 40, 160, 640])
def test_heat_into_particles_at_rest(cells):
    """Exact: 2 k dT sqrt(t C/(pi k)), whether a cell is 16 times as deep as the layer
    or a quarter of it.
    """
    run = study.Run(plan(from_dict(scene(cells))))
    run.bed.advance(1.0)
    assert run.bed.state.energy.account.walls == approx(39430.0, rel=AT_REST)


GRIDS = {
    "line": lambda: line(0.1, 10),
    "rectangle": lambda: rectangle(0.1, 0.05, (10, 8)),
    "triangles": lambda: rectangle(0.1, 0.05, (10, 8), shape="triangle"),
    "box": lambda: grid.build(meshing.build(MeshBox(**BOX, cells=(4, 5, 6)))),
    "tetrahedra": lambda: grid.build(
        meshing.build(MeshBox(**BOX, cells=(2, 3, 4), shape="tetrahedron"))
    ),
    "axisymmetric": lambda: grid.build(
        meshing.build(
            MeshAxisymmetric(
                type="axisymmetric", length=0.3, radius=0.2, cells=(12, 10)
            )
        )
    ),
}


@pytest.mark.parametrize("name", GRIDS)
def test_each_wall_heats_and_cools_alike(name):
    """All walls of all meshes, each alone: the same heat per area, to rounding the
    opposite with the opposite difference.
    """
    on = GRIDS[name]()
    for side in on.boundaries:
        if side == "axis":
            continue
        area = on.geometry.area[on.boundaries[side]].sum()
        found = []
        for wall in (350.0, 250.0):
            made = at_rest(on, {side: Thermal(wall=wall)})
            start = stored_heat(made.state, made.model)
            made.advance(0.3)
            energy = made.state.energy
            heat = energy.account.walls
            gained = stored_heat(made.state, made.model) - start
            assert gained == approx(heat, rel=1e-9)
            of_faces = energy.walls.heat[on.boundaries[side]].sum()
            assert of_faces == approx(heat, rel=1e-9)
            assert np.count_nonzero(energy.walls.heat) == len(on.boundaries[side])
            found.append(heat / area)
        assert found[0] == approx(-found[1], rel=1e-9)
        # corners of round beds give more than half a space
        assert found[0] == approx(conducted(0.3, 50.0), rel=AT_REST)


def test_a_resolved_layer_is_that_of_the_mesh():
    """Cells much thinner than the layer: T = T_wall - dT erf(x/sqrt(4 k t/C))."""
    on = line(0.01, 200)
    made = at_rest(on, {"left": Thermal(wall=400.0)}, options=Options(dt_max=2e-3))
    made.advance(4.0)
    x = on.centres[:, 0]
    exact = 400.0 - 100.0 * erf(x / np.sqrt(4.0 * K * 4.0 / C))
    np.testing.assert_allclose(made.state.energy.T_solid, exact, atol=0.2)


@pytest.mark.parametrize(
    ("on", "off"),
    [
        (lambda: line(0.1, 7), 1e-7),
        # along adiabatic sides temperatures follow their gradient
        (lambda: rectangle(0.1, 0.02, (4, 2), shape="triangle"), 2e-3),
        (lambda: rectangle(0.1, 0.02, (40, 8), shape="triangle"), 2e-5),
    ],
)
def test_steady_heat_is_linear(on, off):
    """Two walls: the temperature is linear and the heat k dT/L, to the iteration."""
    on = on()
    made = at_rest(
        on,
        {"left": Thermal(wall=300.0), "right": Thermal(wall=400.0)},
        options=Options(dt=1e4),
    )
    for _ in range(30):
        made.step(1e4)
    before = made.state.energy.walls.heat
    made.step(1e4)
    energy = made.state.energy
    if on.dimension == 1:
        exact = 300.0 + 1e3 * on.centres[:, 0]
        np.testing.assert_allclose(energy.T_solid, exact, rtol=1e-8)
    faces = on.boundaries["right"]
    rate = (energy.walls.heat - before)[faces].sum() / 1e4
    area = on.geometry.area[faces].sum()
    assert rate / area == approx(K * 100.0 / 0.1, rel=off)


def sliding(cells, u, height=0.1, options=None, wall=400.0):
    """Particles and gas that slide upwards along a hot wall on the left."""
    on = rectangle(0.05, height, cells)
    sides = {"left": SLIP, "right": SLIP, "top": OutletCondition()}
    sides["bottom"] = InletCondition(u * (1 - EPS_S), EPS_S, solid_velocity=u)
    thermal = {"bottom": Thermal(300.0, 300.0), "left": Thermal(wall=wall)}
    options = options or Options(dt_max=0.01, theta="frozen")
    made = heated(on, sides, thermal, options=options)
    made.start(
        eps_s=EPS_S, u_gas=[0.0, u], u_solid=[0.0, u], T_gas=300.0, T_solid=300.0
    )
    return made


@pytest.mark.parametrize("cells", [(5, 10), (10, 20), (40, 20)])
def test_packets_of_one_time_of_contact(cells):
    """Particles that slide past a wall for tau take sqrt(4 k C/(pi tau)), as Mickley
    and Fairbanks have it.
    """
    u, height = 0.1, 0.1
    made = sliding(cells, u)
    made.advance(2.0)
    before = made.state.energy.account.walls
    made.advance(2.5)
    h = (made.state.energy.account.walls - before) / 0.5 / height / 100.0
    # upwind along the wall mixes the ages of ten cells
    assert h == approx(np.sqrt(4 * K * C / (np.pi * height / u)), rel=0.06)


def test_gas_alone_conducts_as_gas():
    """No particles: half a space of gas."""
    on = line(0.2, 10)
    made = at_rest(on, {"left": Thermal(wall=310.0)}, conductivity=(0.026, 0.0))
    made.start(eps_s=0.0, T_gas=300.0, T_solid=300.0)
    made.advance(2.0)
    exact = 20.0 * 0.026 * np.sqrt(2.0 * 1.2 * CP_GAS / (np.pi * 0.026))
    assert made.state.energy.account.walls == approx(exact, rel=AT_REST)


def test_shaken_meshes_conduct_alike():
    """A wall beside triangles and quadrilaterals of any form."""
    for shape in ("triangle", "quadrilateral"):
        on = grid.build(shaken_mesh(shape, (8, 8)))
        made = at_rest(on, {"left": Thermal(wall=400.0)})
        made.advance(1.0)
        heat = made.state.energy.account.walls
        assert heat == approx(conducted(1.0, 100.0), rel=AT_REST)


def in_scene(cells=10, **changes):
    """Named results of the scene of a hot wall with some keys changed, by dotted
    names.
    """
    keys = {path.replace("__", "."): value for path, value in changes.items()}
    return changed(scene(cells), keys)


def test_results_of_a_wall():
    """Heat in the mean, the coefficient on it, and what the mesh leaves uncertain:
    nothing, at rest.
    """
    result = cb.run(from_dict(scene(20)))
    found = result.qoi
    assert found["heat_left_W"] == approx(39430.0, rel=AT_REST)
    assert result.units["heat_left_W"] == "W/m2"
    assert result.profiles["heat_left [J]"][-1] == approx(found["heat_left_W"])
    warm = np.trapezoid(result.profiles["T_solid_mean [K]"], result.profiles["t [s]"])
    expected = found["heat_left_W"] / (380.0 - warm)
    assert found["coefficient_left_W_m2K"] == approx(expected, rel=1e-9)
    assert found["heat_left_error"] < 1e-3
    assert not result.warnings
    assert "heat_right_W" not in found


def own_law(law):
    """Changes that give the hot wall a law of its own."""
    wall = {"type": "wall", "coefficient": law, "ambient": 380.0}
    return {"boundary__left": wall}


@pytest.mark.parametrize(
    "changes", [{"closures__wall_heat": 200.0}, own_law(200.0)], ids=["all", "own"]
)
def test_a_coefficient_is_between_wall_and_cell(changes):
    """A number: heat h (T_wall - T) of the cell, exact with its capacity alone."""
    made = in_scene(2, **changes)
    del made["closures"]["conductivity_bed"]
    found = cb.run(from_dict(made))
    # the cell of 0.05 m alone: gas and particles follow each other
    capacity = 0.05 * (0.42 * 1.2 * 1005.0 + 0.58 * 2600.0 * 800.0)
    exact = capacity * 80.0 * -np.expm1(-200.0 / capacity)
    assert found.qoi["heat_left_W"] == approx(exact, rel=1e-3)
    assert found.balances["heat"]["relative_residual"] < 1e-12


def test_closures_of_walls_by_name():
    """Packets: the coefficient that the function gives; a file gives its own."""
    packets = {"name": "kunii_levenspiel_packet", "contact_time": 0.5}
    result = cb.run(from_dict(in_scene(4, closures__wall_heat=packets)))
    k = closure.conductivity_zehner_schluender(k_fluid=0.026, k_solid=1.0, eps=0.42)
    h = closure.bed_tube_kunii_levenspiel_packet(
        k_stagnant=k,
        eps=0.42,
        d_p=5e-4,
        rho_gas=1.2,
        cp_gas=1005.0,
        k_gas=0.026,
        rho_solid=2600.0,
        cp_solid=800.0,
        contact_time=0.5,
    )
    assert result.qoi["coefficient_left_W_m2K"] == approx(float(h), rel=0.02)
    assert "bed_tube_kunii_levenspiel_packet" in {c["name"] for c in result.closures}
    martin = {"name": "martin", "molar_mass": 0.029}
    changes = own_law(martin) | {"two_fluid__gravity": 9.81}
    loose = in_scene(4, **changes, initial__solids__beads__volume_fraction=0.45)
    assert cb.run(from_dict(loose)).qoi["coefficient_left_W_m2K"] > 40.0


def test_a_closure_file_of_a_wall(tmp_path):
    """h = 300 (eps/0.42) W/m2/K from particles."""
    (tmp_path / "wall.toml").write_text(
        """
format = 1
kind = "bed_tube"
form = "log_polynomial"
variables.eps = { scale = "log", reference = 0.42 }
terms = [
    { powers = [0], value = 5.703782, interval = [5.7, 5.8] },
    { powers = [1], value = 1.0, interval = [0.9, 1.1] },
]
range.eps = [0.3, 0.6]
residuals.points = 3
provenance.scene = "a wall of spheres"
"""
    )
    made = in_scene(2, closures__wall_heat={"file": "wall.toml"})
    found = cb.run(from_dict(made, base=tmp_path)).qoi
    assert found["coefficient_left_W_m2K"] == approx(300.0, rel=0.02)


BED_OF_A_PACKING = """
format = 1
kind = "conductivity"
form = "log_polynomial"
variables.eps = { scale = "log", reference = 0.42 }
terms = [
    { powers = [0], value = 2.7333680, interval = [2.7, 2.8] },
    { powers = [1], value = 0.0, interval = [-0.1, 0.1] },
]
range.eps = [0.3, 0.6]
residuals.points = 3
provenance.scene = "a packing of spheres"
"""


def test_a_closure_file_of_the_conductivity_of_the_bed(tmp_path):
    """A file of 0.4/0.026 times the gas's conductivity: the heat of a half space."""
    (tmp_path / "bed.toml").write_text(BED_OF_A_PACKING)
    made = in_scene(20, closures__conductivity_bed={"file": "bed.toml"})
    del made["solids"]["beads"]["conductivity"]
    found = cb.run(from_dict(made, base=tmp_path)).qoi
    capacity = 0.42 * 1.2 * 1005.0 + 0.58 * 2600.0 * 800.0
    exact = 2.0 * 80.0 * np.sqrt(0.4 * capacity / np.pi)
    assert found["heat_left_W"] == approx(exact, rel=AT_REST)


def test_cells_that_do_not_suit_a_coefficient_warn():
    """A closure of about 300 W/m2/K stands for a layer of k/h = 0.5 mm, in which thin
    cells resist as well. A number acts on the middle of cells: those of 2.5 mm leave out 60 %
    of the resistance of a bed at rest, those of 0.1 mm 6 %.
    """
    law = {"name": "kunii_levenspiel_packet", "contact_time": 0.5}
    thin, coarse = "thinner than the layer", "of the resistance, is left out"
    for coefficient, cells, text, warns in (
        (law, 10, thin, False),
        (law, 1000, thin, True),
        (200.0, 40, coarse, True),
        (200.0, 1000, coarse, False),
        (200.0, 1000, thin, False),
    ):
        found = cb.run(from_dict(in_scene(cells, closures__wall_heat=coefficient)))
        assert any(text in warning for warning in found.warnings) == warns


def test_a_gap_resists():
    """Half a space behind a resistance: q = h dT exp(a2) erfc(a), a = h sqrt(t/(k C))."""
    gap = {"name": "penetration", "gap": 0.2}
    thin = cb.run(from_dict(in_scene(10, closures__wall_heat=gap))).qoi["heat_left_W"]
    fraction = 0.58 / 0.63  # of a packed bed
    h, kC = 0.026 / (0.2 * 5e-4 * fraction), (39430.0 * np.sqrt(np.pi) / 160.0) ** 2
    a = h / np.sqrt(kC)
    exact = 80.0 * kC / h * (erfcx(a) - 1.0 + 2.0 * a / np.sqrt(np.pi))
    assert thin == approx(exact, rel=AT_REST)


def test_radiation_to_particles():
    """Without conduction and with a coefficient of zero: sigma eps (T_wall^4 - T^4)."""
    made = in_scene(
        2,
        closures__wall_heat=0.0,
        boundary__left__temperature=1000.0,
        boundary__left__emissivity=0.9,
        solids__beads__emissivity=0.64,
        time={"end": 0.1},
    )
    del made["closures"]["conductivity_bed"]
    bed_emissivity = 2 * 0.8 / 1.8
    both = 1.0 / (1.0 / 0.9 + 1.0 / bed_emissivity - 1.0)
    exact = 5.670374419e-8 * both * (1000.0**4 - 300.0**4)
    found = cb.run(from_dict(made)).qoi
    assert found["heat_left_W"] == approx(exact, rel=1e-3)


@pytest.mark.parametrize("eps", [0.01, 1e-6])
def test_radiation_to_few_particles(eps):
    """Spheres of geometric optics within ten diameters intercept 1 - exp(-15 eps) of
    it, so that a suspension without heat capacity stays as it is.
    """
    made = in_scene(
        2,
        closures__wall_heat=0.0,
        boundary__left__temperature=1000.0,
        boundary__left__emissivity=0.9,
        solids__beads__emissivity=0.64,
        initial__solids__beads__volume_fraction=eps,
        time={"end": 1e-3},
    )
    del made["closures"]["conductivity_bed"]
    bed_emissivity = 2 * 0.8 / 1.8
    both = 1.0 / (1.0 / 0.9 + 1.0 / bed_emissivity - 1.0)
    exact = 5.670374419e-8 * both * (1000.0**4 - 300.0**4) * -np.expm1(-15.0 * eps)
    found = cb.run(from_dict(made)).qoi
    assert found["heat_left_W"] == approx(exact, rel=1e-2)
    assert np.nan_to_num(found["T_solid_max [K]"]) < 305.0  # none of so few counts


def test_radiation_and_conduction_on_any_mesh():
    """A hot wall that also radiates: the same heat from coarse and fine cells."""
    hot = {
        "boundary__left__temperature": 1300.0,
        "boundary__left__emissivity": 0.9,
        "solids__beads__emissivity": 0.8,
    }
    found = [
        cb.run(from_dict(in_scene(cells, **hot))).qoi["heat_left_W"]
        for cells in (10, 160)
    ]
    assert found[0] == approx(found[1], rel=AT_REST)
    cold = cb.run(from_dict(in_scene(10, boundary__left__temperature=1300.0))).qoi
    assert found[0] > 1.05 * cold["heat_left_W"]


def test_uncertain_mesh_warns():
    """Particles that pass through the cell beside a wall: two ideas of how they renew
    the layer differ where the cell is much deeper than it.
    """
    (coarse, heat), (fine, _) = (towards_the_wall(cells) for cells in (4, 128))
    assert coarse > 0.1 > 0.03 > fine
    # upwind within the layer
    assert heat == approx(1.0, abs=0.07)


def towards_the_wall(cells, rate=1.0, depth=0.02):
    """Estimate of the error beside a wall to which particles flow at a rate [1/s], and
    along which they leave; and the heat over the exact one, dT sqrt(2 rate k C/pi).
    """
    on = rectangle(depth, 0.02, (cells, 2))

    def u(x):
        return rate * np.stack((-x[:, 0], x[:, 1]), axis=1)

    given = GivenFields(
        u, u, lambda x: np.full(len(x), EPS_S), lambda x: np.zeros(len(x))
    )
    sides = dict.fromkeys(("right", "top", "bottom"), given) | {"left": SLIP}
    thermal = {"right": Thermal(300.0, 300.0), "left": Thermal(wall=400.0)}
    thermal["bottom"] = Thermal(300.0, 300.0)
    options = Options(dt_max=0.005, theta="frozen")
    made = heated(on, sides, thermal, options=options)
    velocity = u(on.centres)
    made.start(
        eps_s=EPS_S, u_gas=velocity, u_solid=velocity, T_gas=300.0, T_solid=300.0
    )
    made.advance(2.0)
    before = made.state.energy.walls
    made.advance(3.0)
    walls = made.state.energy.walls
    heat, if_mixed = (
        (getattr(walls, key) - getattr(before, key)).sum()
        for key in ("heat", "heat_if_mixed")
    )
    exact = 100.0 * 0.02 * K * np.sqrt(2.0 * rate * C / (np.pi * K))
    return (if_mixed - heat) / heat, heat / exact


@each_case(__file__, "mistakes_about_walls")
def test_mistakes_about_walls(changes, text):
    refused(text, lambda: from_dict(in_scene(4, **changes)))


def test_restart_with_layers_is_bit_for_bit(tmp_path):
    """Stopped on the way: layers and heat of walls are in the checkpoint."""
    made = in_scene(10, time={"end": 0.2, "sample": 0.05})
    made["boundary"]["right"]["heat_flux"] = 1e3
    made = from_dict(made)
    interrupt(made, tmp_path, study, "_keep", 3)
    rest = cb.run(made, tmp_path, restart=tmp_path)
    same_run(rest, cb.run(made))
    assert rest.qoi["heat_right_W"] == approx(1e3, rel=1e-12)


def test_a_closure_of_heat_out_of_its_range_is_a_warning(tmp_path):
    (tmp_path / "bed.toml").write_text(
        BED_OF_A_PACKING.replace("[0.3, 0.6]", "[0.3, 0.4]")
    )
    made = in_scene(4, closures__conductivity_bed={"file": "bed.toml"})
    found = cb.run(from_dict(made, base=tmp_path))
    assert any(
        "eps 0.42" in text and "declared 0.3 to 0.4" in text for text in found.warnings
    )

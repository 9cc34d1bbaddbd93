"""Heat of the two-fluid model against closed forms; heat and gas that are neither
made nor lost.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from core_closures import bed, closures, line, rectangle
from numpy.testing import assert_allclose
from pytest import approx
from scipy.linalg import expm

import contbed as cb
from contbed import closures as closure
from contbed.closures.file import closure_of
from contbed.loading import from_dict
from contbed.models import plan
from contbed.two_fluid import run as study
from contbed.two_fluid.boundary import InletCondition, OutletCondition, symmetry
from contbed.two_fluid.closures import bound
from contbed.two_fluid.heat import plan as heat_planning
from contbed.two_fluid.heat.equations import density_times_T, stored_heat
from contbed.two_fluid.heat.model import Physics, Thermal, build_heat
from contbed.two_fluid.model import Options
from studies._exact.packed_bed import schumann
from tests.balances import assert_closed
from tests.cases import each_case
from tests.imported import modules_after
from tests.refusals import refusal, refused
from tests.restarts import interrupt, same_run
from tests.scene_text import changed, scene_of

SLIP = symmetry()
CP_GAS, CP_SOLID = 1000.0, 800.0


def heated(
    on,
    sides,
    thermal=None,
    h=60.0,
    laws=None,
    conductivity=None,
    ideal=False,
    options=None,
    **materials,
):
    """A bed with heat; h and the conductivities [W/m2/K, W/m/K] are numbers."""

    def conduct(eps_s, *_):
        return conductivity[0] * (1 - eps_s), conductivity[1] * eps_s

    density = "ideal_gas" if ideal else "constant"
    physics = Physics(
        CP_GAS,
        CP_SOLID,
        lambda s, *_: np.full_like(s, h),
        conductivity and conduct,
        density,
        300.0,
    )
    heat = build_heat(on, physics, thermal or {})
    return bed(on, laws or closures(), sides, options=options, heat=heat, **materials)


def stored(b):
    """Heat [J] in a bed."""
    return stored_heat(b.state, b.model)


def open_heat(made, start):
    """Heat that is not accounted for, over what the bed held at the start and took
    in.
    """
    a = made.state.energy.account
    return (stored(made) - start - a.heat_in + a.heat_out - a.walls) / (
        start + a.heat_in
    )


@pytest.mark.parametrize("dt", [0.05, 1e-3])
def test_closed_suspension_is_exact_at_any_step(dt):
    """Two ordinary equations: rates of heat 1.7 and 9.6e2 1/s, so that the longer step
    is 48 times too long for an explicit one.
    """
    s, h = 0.3, 60.0
    b = heated(line(0.1, 4, True), {}, h=h, options=Options(dt=dt), gravity=(0.0,))
    b.start(eps_s=s, T_gas=300.0, T_solid=500.0)
    b.advance(0.1)
    H = 6 * h * s / 275e-6
    rate = (
        np.array([[-1, 1], [1, -1]])
        * H
        / np.array([[1.2 * (1 - s) * CP_GAS], [2500 * s * CP_SOLID]])
    )
    exact = expm(0.1 * rate) @ [300.0, 500.0]
    assert_allclose(b.state.energy.T_gas, exact[0], rtol=1e-12)
    assert_allclose(b.state.energy.T_solid, exact[1], rtol=1e-12)


def test_gas_that_warms_in_a_closed_box():
    """Hot particles and an ideal gas in a fixed volume: heat goes by c_p - R, the
    pressure follows the temperature.
    """
    s, R = 0.1, 101325.0 / (1.2 * 300.0)
    b = heated(
        line(0.1, 4, True),
        {},
        h=500.0,
        ideal=True,
        options=Options(dt=0.01),
        gravity=(0.0,),
    )
    b.start(eps_s=s, T_gas=300.0, T_solid=500.0)
    start = stored(b)
    b.advance(1.0)
    gas, solid = 1.2 * (1 - s) * (CP_GAS - R), 2500 * s * CP_SOLID
    T = (gas * 300.0 + solid * 500.0) / (gas + solid)
    assert_allclose(b.state.energy.T_gas, T, rtol=1e-12)
    assert_allclose(b.state.energy.T_solid, T, rtol=1e-12)
    assert b.state.energy.p0 == approx(101325.0 * T / 300.0, rel=1e-12)
    assert abs(open_heat(b, start)) < 1e-14
    assert np.abs(b.state.u_gas).max() < 1e-10


def drag(eps_s, slip):
    return (
        150 * eps_s / (1 - eps_s) ** 2 * 1.8e-5 / 1e-3**2
        + 1.75 * 1.2 * slip / (1 - eps_s) / 1e-3
    )


def bubbling(shape, ideal):
    """A bed of 1 mm that hot gas blows up, with conduction in both phases and a warm
    wall.
    """
    grid = rectangle(0.04, 0.08, (8, 16), shape=shape)
    sides = {
        "left": SLIP,
        "right": SLIP,
        "bottom": InletCondition(1.5),
        "top": OutletCondition(),
    }
    thermal = {
        "bottom": Thermal(T_gas=600.0),
        "left": Thermal(wall=400.0),
        "right": Thermal(flux=1e3),
    }
    laws = closures(drag, pressure=1.0, friction=100.0)
    b = heated(
        grid,
        sides,
        thermal,
        200.0,
        laws,
        (0.05, 1.0),
        ideal,
        Options(courant=0.3),
        gravity=(0.0, -9.81),
        d_p=1e-3,
    )
    x, z = grid.centres.T
    bed = z < 0.04
    b.start(
        eps_s=np.where(bed, 0.5 + 0.02 * np.sin(300 * x), 0.0),
        u_gas=np.stack((0 * z, np.where(bed, 3.0, 1.5)), 1),
        theta=1e-3,
        T_gas=300.0,
        T_solid=300.0,
    )
    return b


@pytest.mark.parametrize("ideal", [False, True])
@pytest.mark.parametrize("shape", ["quadrilateral", "triangle"])
def test_moving_bed_keeps_heat_and_gas(shape, ideal):
    b = bubbling(shape, ideal)
    volume = b.model.grid.geometry.volume
    heat, gas = stored(b), b.state.energy.mass @ volume
    for _ in range(300):
        b.step(b.next_step())
    assert abs(open_heat(b, heat)) < 1e-12
    a = b.state.energy.account
    assert abs(b.state.energy.mass @ volume - gas - a.gas_in + a.gas_out) < 1e-12 * (
        gas + a.gas_in
    )
    # mass, temperature and volume fit: what a step leaves open is second order in it
    energy, rho_T = (
        b.state.energy,
        density_times_T(b.state.energy.p0, b.model.heat, b.model),
    )
    filled = energy.mass * energy.T_gas / rho_T if ideal else energy.mass / 1.2
    assert_allclose(filled, 1 - b.state.eps_s, atol=2e-3 if ideal else 1e-12)
    # the limiter knows no value upstream of a triangle
    beyond = 0.01 * 300.0 if shape == "triangle" else 1e-9
    for T in (b.state.energy.T_gas, b.state.energy.T_solid):
        assert 300.0 - beyond < T.min() < T.max() < 600.0 + beyond
    assert np.abs(b.state.u_solid).max() > 0.05


def test_isothermal_beds_know_nothing_of_heat():
    found = modules_after("import contbed.two_fluid.run")
    assert "contbed.two_fluid.step" in found
    heat = {"contbed.two_fluid.heat.equations", "contbed.two_fluid.heat.plan"}
    assert not heat & found


def test_constant_density_leaves_the_flow_alone():
    with_heat, without = (
        bubbling("quadrilateral", False),
        bubbling("quadrilateral", False),
    )
    isothermal = replace(without.state, energy=None)
    without.model, without.state = replace(without.model, heat=None), isothermal
    for b in (with_heat, without):
        for _ in range(20):
            b.step(b.next_step())
    for name, field in without.state.fields().items():
        assert np.array_equal(field, getattr(with_heat.state, name)), name


def test_heat_is_symmetric():
    b = bubbling("quadrilateral", True)
    x, z = b.model.grid.centres.T
    b.impose_heat(
        {
            "bottom": Thermal(T_gas=600.0),
            "left": Thermal(wall=400.0),
            "right": Thermal(wall=400.0),
        }
    )
    b.start(eps_s=np.where(z < 0.04, 0.5 + 0.02 * np.cos(300 * (x - 0.02)), 0.0))
    x, z = np.rint(1e4 * x), np.rint(1e4 * z)
    order, mirror = np.lexsort((x, z)), np.lexsort((400 - x, z))
    for _ in range(100):
        b.step(b.next_step())
    # the iterations of the flow end at 1e-9; what has no particles has no temperature
    # of theirs
    there = b.state.eps_s[order] > 1e-20
    assert_allclose(
        b.state.energy.T_gas[order], b.state.energy.T_gas[mirror], rtol=1e-6
    )
    assert_allclose(
        b.state.energy.T_solid[order][there],
        b.state.energy.T_solid[mirror][there],
        rtol=1e-6,
    )


@pytest.mark.parametrize(("shape", "phase"), [("quadrilateral", 0), ("triangle", 1)])
def test_conduction_in_one_phase(shape, phase):
    """A cosine between adiabatic walls fades; what remains of it is first order in
    the step, second in the cells.
    """
    length, k, s = 0.1, 50.0, 0.4
    content = (1.2 * CP_GAS, 2500.0 * CP_SOLID)[phase]
    end = 0.5 * content / k * (length / np.pi) ** 2
    grid = rectangle(length, length / 4, (24, 6), shape=shape)
    pair = (k, 0.0) if phase == 0 else (0.0, k)
    b = heated(
        grid,
        dict.fromkeys(grid.boundaries, SLIP),
        h=0.0,
        conductivity=pair,
        options=Options(dt=end / 200),
    )
    wave = np.cos(np.pi * grid.centres[:, 0] / length)
    b.start(eps_s=s, T_gas=300.0 + 10 * wave, T_solid=300.0 + 10 * wave)
    b.advance(end)
    left = (b.state.energy.T_gas, b.state.energy.T_solid)[phase] - 300.0
    assert_allclose(
        left, 10 * wave * np.exp(-0.5), atol=0.02 if shape == "quadrilateral" else 0.05
    )
    assert abs(b.state.energy.account.walls) < 1e-12 * stored(b)


def test_walls_at_two_temperatures():
    """A linear temperature is exact; both walls are given what the phases conduct."""
    grid = rectangle(0.1, 0.02, (10, 2))
    b = heated(
        grid,
        dict.fromkeys(grid.boundaries, SLIP),
        {"left": Thermal(wall=300.0), "right": Thermal(wall=400.0)},
        h=100.0,
        conductivity=(2.0, 10.0),
        options=Options(dt=1e4),
    )
    b.start(eps_s=0.4, T_gas=300.0, T_solid=350.0)
    for _ in range(20):
        b.step(1e4)
    for T in (b.state.energy.T_gas, b.state.energy.T_solid):
        assert_allclose(T, 300.0 + 1e3 * grid.centres[:, 0], rtol=1e-9)


def schumann_error(cells):
    """Largest error of both temperatures behind a front in a bed that does not move,
    over the step at the inlet.

    Return also the number of steps.
    """
    length, u, s, h = 0.1, 1.0, 0.5, 3.0
    b = heated(
        line(length, cells),
        {"left": InletCondition(u * (1 - s)), "right": OutletCondition()},
        {"left": Thermal(T_gas=310.0)},
        h,
        options=Options(courant=0.4, dt_max=1.0),
        gravity=(0.0,),
    )
    b.start(eps_s=s, u_gas=u, T_gas=300.0, T_solid=300.0)
    b.advance(4.0 * length / u)
    H = 6 * h * s / 275e-6
    gas, solid = schumann(
        b.model.grid.centres[:, 0],
        b.state.time,
        u,
        H / ((1 - s) * 1.2 * CP_GAS),
        H / (s * 2500 * CP_SOLID),
    )
    energy = b.state.energy
    errors = (
        np.abs(energy.T_gas - 300 - 10 * gas).max(),
        np.abs(energy.T_solid - 300 - 10 * solid).max(),
    )
    return max(errors) / 10, b.state.steps


def test_gas_does_not_bind_the_step():
    """Its temperature goes in sub-cycles: 294 steps in which gas crossed 0.4 of a
    cell had an error of 3.82e-3.
    """
    error, steps = schumann_error(25)
    assert error < 3.9e-3
    assert steps < 120


@pytest.mark.slow
def test_hot_front_in_a_bed_at_rest():
    (coarse, _), (fine, _) = schumann_error(50), schumann_error(100)
    assert fine < 2e-3
    assert coarse / fine > 2**0.9


def test_ideal_gas_that_warms_flows_faster():
    """A steady stream keeps its mass flux; its velocity follows the temperature."""
    b = heated(
        line(0.1, 20),
        {"left": InletCondition(0.5), "right": OutletCondition()},
        {"left": Thermal(T_gas=300.0)},
        50.0,
        ideal=True,
        options=Options(courant=0.4),
        gravity=(0.0,),
        rho_solid=2.5e9,
    )
    b.start(eps_s=0.01, u_gas=0.5 / 0.99, T_gas=300.0, T_solid=600.0)
    b.advance(1.0)
    rise = 600.0 - b.state.energy.T_gas
    assert (
        b.state.energy.T_gas.max() > 450.0
        and (np.diff(rise[np.argsort(b.model.grid.centres[:, 0])]) < 0).all()
    )
    flux = b.state.fluxes.total - b.state.fluxes.moved
    out = b.model.grid.boundaries["right"]
    end = b.state.energy.T_gas[b.model.grid.geometry.left[out]]
    assert_allclose(flux[out], 0.5 * end / 300.0, rtol=1e-7)


def test_gas_that_expands_in_one_step_leaves_in_the_time_of_that_step():
    """Cold gas between hot particles doubles its volume in the first step of 5e-4 s:
    half of the 0.05 m3 per m2 has to leave, at 200 m/s where it is fastest. In the next
    steps, 30 times as short, it goes on at that speed.
    """
    s, length, first = 0.5, 0.1, 5e-4
    options = Options(dt_first=first, dt_max=1e-3, courant=0.3)
    sides = {"left": SLIP, "right": OutletCondition()}
    b = heated(
        line(length, 10), sides, h=2000.0, ideal=True, options=options, gravity=(0.0,)
    )
    b.start(eps_s=s, T_gas=300.0, T_solid=600.0)
    speeds = []
    while b.state.time < 2.0 * first:
        b.step_towards(2.0 * first)
        speeds.append(b.state.u_gas.max())
    # the first pressure foresees as much heat again as the step has given
    assert max(speeds[1:]) < 1.05 * length / first < max(speeds) < 2.1 * length / first
    energy = b.state.energy
    still_open = energy.mass * energy.T_gas / density_times_T(
        energy.p0, b.model.heat, b.model
    ) - (1.0 - b.state.eps_s)
    assert np.abs(still_open).max() < 1e-3


PULSE = scene_of(
    """
[mesh]
type = "rectangle"
length = 0.06
height = 0.12
cells = [10, 20]
[two_fluid]
[gas]
density = 1.18
viscosity = 1.8e-05
heat_capacity = 1010.0
conductivity = 0.026
density_law = "ideal_gas"
[solids.beads]
diameter = 0.003
density = 2526.0
heat_capacity = 840.0
conductivity = 1.0
[closures]
conductivity_bed = "zehner_schluender"
[heat]
[boundary.left]
type = "wall"
solids.beads.wall = "slip"
temperature = 310.0
[boundary.right]
type = "wall"
solids.beads.wall = "slip"
heat_flux = 100.0
[boundary.bottom]
type = "inlet"
gas.velocity = 1.5
gas.temperature = 300.0
[boundary.jet]
type = "inlet"
on = "bottom"
start = 0.024
end = 0.036
gas.velocity = 30.0
gas.temperature = 700.0
until = 0.011
[boundary.top]
type = "outlet"
[initial]
gas.temperature = 300.0
gas.velocity = 1.5
layer = [{ end = 0.06, solids = { beads = { volume_fraction = 0.55 } }, gas = { velocity = 3.0 } }]
[time]
end = 0.03
sample = 0.005
average_from = 0.01
[output]
plots = false
fields = false
"""
)


def scene(changes=None, without=()):
    return changed(PULSE, changes, without)


@each_case(__file__, "cold_ideal_gas_between_hot_particles_is_told")
def test_cold_ideal_gas_between_hot_particles_is_told(T_solid, d_p, density, told):
    """The gas follows in rho_g c_g eps_g d_p^2/(6 eps_s 10 k) = 5.6e-5 s: the 0.06 m
    of it double at 1070 m/s.
    """
    layer = {
        "end": 0.06,
        "solids": {"beads": {"volume_fraction": 0.55, "temperature": T_solid}},
    }
    changes = {
        "initial.layer": [layer],
        "solids.beads.diameter": d_p,
        "gas.density_law": density,
    }
    found = [
        text
        for text in plan(from_dict(scene(changes))).warnings
        if "its new volume" in text
    ]
    assert len(found) == told
    if told:
        assert (
            "initial.layer[0].gas.temperature: gas of 300 K between particles of 600 K "
            "takes" in found[0]
        )
        assert "in 5.6e-05 s and its new volume flows at 1.1e+03 m/s" in found[0]


def test_a_pulse_restarts_bit_for_bit(tmp_path):
    """Stopped right at the end of the pulse, and after it; with what the run writes
    about heat.
    """
    loaded = from_dict(scene({"boundary.jet.until": 0.01}))
    whole = cb.run(loaded)
    assert {"gas", "heat", "solids"} <= set(whole.balances)
    assert_closed(whole, 1e-12)
    assert whole.profiles["T_gas_max [K]"].max() > 500.0
    assert {"T_gas [K]", "T_solid [K]"} <= set(whole.tables["axial"])
    assert {"nusselt_gunn", "conductivity_zehner_schluender"} <= {
        use["name"] for use in whole.closures
    }
    for rows in (3, 5):
        part = tmp_path / str(rows)
        interrupt(loaded, part, study, "_keep", rows)
        same_run(cb.run(loaded, part, restart=part), whole)


def test_coefficient_of_a_closure_file_and_of_a_number():
    folder = Path(__file__).parents[2] / "studies" / "closure_transfer" / "closures"
    s, slip, T = np.array([0.5]), np.array([1.5]), np.array([300.0])
    found = {}
    for key, nusselt in (
        ("file", {"file": "nusselt.toml"}),
        ("number", 7.0),
        ("name", "gunn"),
    ):
        chosen = from_dict(scene({"closures.nusselt": nusselt}), base=folder)
        made = heat_planning.physics(chosen, bound(chosen))
        found[key] = made.coefficient(s, slip, 0.5, T)[0] * 3e-3 / 0.026
    Re, Pr = 0.5 * 1.18 * 0.5 * 1.5 * 3e-3 / 1.8e-5, 1010.0 * 1.8e-5 / 0.026
    assert found["number"] == approx(7.0)
    assert found["name"] == approx(closure.nusselt_gunn(Re, Pr, 0.5))
    assert found["file"] == approx(
        closure_of("nusselt.toml", folder, "nusselt")(Re=Re, Pr=Pr, eps=0.5)
    )


def test_a_closure_with_parameters_of_its_own():
    power = {"name": "power", "a": 1.2, "b": 0.5}
    found = cb.run(
        from_dict(
            scene(
                {
                    "closures.nusselt": power,
                    "time.end": 0.002,
                    "time.average_from": 0.001,
                }
            )
        )
    ).closures
    assert "nusselt_power" in {use["name"] for use in found}
    refused(
        r"closures\.nusselt: parameter 'a' of closure 'power' is in \[0, inf\)",
        lambda: from_dict(
            scene({"closures.nusselt": {"name": "power", "a": -1.2, "b": 0.5}})
        ),
    )


def test_a_pulse_brings_what_was_given_and_ends():
    run = study.Run(plan(from_dict(scene())))
    run.bed.advance(0.011, run.after_step)
    given = 0.011 * (1.18 * 1.5 * 0.048 + 1.18 * 300.0 / 700.0 * 30.0 * 0.012)
    assert run.bed.state.energy.account.gas_in == approx(given, rel=1e-12)
    jet = run.bed.model.grid.boundaries["jet"]
    assert_allclose(
        run.bed.state.fluxes.total[jet], -1.5 * run.bed.model.grid.geometry.area[jet]
    )
    assert_allclose(
        run.bed.model.heat.at_faces.T_gas[jet - run.bed.model.grid.interior], 300.0
    )


@each_case(__file__, "mistakes")
def test_a_mistake_about_heat_is_named(changes, without, told):
    assert told in refusal(lambda: from_dict(scene(changes, without)))

"""Beds with computed coefficients at the ends of their range, with bad input, and
against a manufactured solution.
"""

import numpy as np
import pytest
from computed_scenes import hot, tables
from pytest import approx

import contbed as cb
from contbed import closures
from contbed.bubbling_bed.plan import plan
from contbed.bubbling_bed.problem import BubblingProblem
from contbed.errors import ConvergenceError
from contbed.loading import from_dict
from contbed.materials import gas_mixture
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options, newton
from studies._exact.manufactured import Manufactured, observed_order
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import set_keys

ALONE = {"volume_share": 1.0, "exchange": {}}
EXACT = {
    "T_inert": lambda z: 620.0 + 60.0 * np.sin(3.0 * z),
    "T_char": lambda z: 700.0 + 80.0 * np.exp(-z),
    "T_emulsion": lambda z: 600.0 + 120.0 * z**2,
    "T_bubble": lambda z: 520.0 + 200.0 * z * np.exp(-z),
    "G": lambda z: 4 * 5.67e-8 * (650.0 + 60.0 * np.cos(2.0 * z)) ** 4,
    "flow_bubble": lambda z: 0.40 + 0.05 * np.sin(2.0 * z),
    "d_bubble": lambda z: 0.05 + 0.15 * z - 0.05 * z**2,
    "T_distributor": lambda z: 450.0 + 0.0 * z,
}


def solved(scene, closed=1e-11):
    result = cb.run(scene)
    assert_closed(result, closed)
    return result


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_order_of_a_manufactured_solution(degree):
    """All closures at work, exact fields far from any state of the bed."""
    errors, sizes = [], (6, 12, 24)
    for cells in sizes:
        scene = hot(
            mesh={"cells": cells},
            solver={"degree": degree},
            bubbles={"size": "horio_nonaka"},
            tubes__coefficient="martin",
        )
        made = plan(scene)
        even = np.linspace(0.0, 0.6, cells + 1)
        made.mesh.skfem.p[0] = even[np.argsort(np.argsort(made.mesh.skfem.p[0]))]
        problem = BubblingProblem(made)
        case = Manufactured(
            problem.system,
            {name: EXACT[name] for name in problem.system.fields},
            problem.forms,
        )
        load = case.load()

        def assemble(state, jacobian, problem=problem, load=load):
            residual, matrix = problem.assemble(state, jacobian)
            return residual - load, matrix

        start = case.interpolant() * (1.0 + 1e-3)
        state, _ = newton(
            assemble,
            start,
            np.empty(0, dtype=int),
            Policy(1),
            Options(weights=problem.weights),
        )
        errors.append(case.errors(state))
    for name in errors[0].keys() - {"T_distributor"}:
        found = observed_order(
            [error[name] for error in errors], [1.0 / cells for cells in sizes]
        )
        # degree + 1 in L2, a little less on coarse meshes
        assert found[-1] > degree + 0.7, (name, found)


def test_without_bubbles_the_bed_is_a_packed_bed_of_its_closures():
    """One species, no bubbles: W (h - h_in) = release, and the coefficient of gas is
    that of the closure.
    """
    given = tables(
        radiation=None,
        distributor=None,
        freeboard=None,
        bubbles=None,
        tubes=None,
        release=None,
    )
    given["solids"] = {"inert": {**given["solids"]["inert"], **ALONE}}
    set_keys(given, "solids.inert.release = { rate = 5e5 }")
    result = solved(from_dict(given))
    gas = gas_mixture("N2:0.79, O2:0.21", 101325.0)
    out = gas.enthalpy(result.qoi["T_emulsion_top_K"]) - gas.enthalpy(300.0)
    assert 0.6 * out == approx(5e5 * 0.6, rel=1e-9)
    assert "T_bubble_top_K" not in result.qoi
    # mixing of 2e4 W/m/K carries 3e5 W over 0.3 m at 4 K; far from the distributor the
    # gas is as hot as the particles
    assert result.qoi["T_emulsion_top_K"] == approx(result.qoi["T_inert_mid_K"], abs=4)


def test_tiny_and_absent_parts():
    """1e-6 of a species and of a feed are as none."""
    traces = tables()
    traces["solids"]["char"]["feed"]["mass_flow"] = 1e-8
    (
        traces["solids"]["char"]["volume_share"],
        traces["solids"]["inert"]["volume_share"],
    ) = 1e-6, 1 - 1e-6
    traces["solids"]["char"]["exchange"] = {}
    absent = tables()
    absent["solids"]["char"] = {
        **absent["solids"]["char"],
        "volume_share": 0.0,
        "feed": None,
        "exchange": {},
    }
    absent["solids"]["char"].pop("feed")
    absent["solids"]["inert"]["volume_share"] = 1.0
    found, none = solved(from_dict(traces)), solved(from_dict(absent))
    for key in (
        "T_inert_mid_K",
        "tubes_convection_W",
        "T_bubble_top_K",
        "T_distributor_K",
    ):
        assert found.qoi[key] == approx(none.qoi[key], rel=2e-5)


@pytest.mark.slow
def test_ten_species():
    ten = {
        f"s{k}": {
            "volume_share": 0.1,
            "diameter": 2e-4 * 1.4**k,
            "density": 1000.0 + 200.0 * k,
            "heat_capacity": 1000.0,
            "emissivity": 0.3 + 0.06 * k,
            "nusselt": "gunn",
            "mixing_conductivity": "kunii_levenspiel",
            "exchange": {f"s{other}": "agu" for other in range(k)},
        }
        for k in range(10)
    }
    result = solved(hot(solids=ten))
    assert len(result.history) <= 15
    assert sum(header.startswith("T_s") for header in result.profiles) == 10


def test_conductivity_of_the_emulsion_and_nusselt_from_files(tmp_path):
    """A file that holds the form of a published law, and one whose polynomial is a
    constant ratio.
    """
    (tmp_path / "nusselt.toml").write_text(
        'format = 1\nkind = "nusselt"\nform = "power"\n[parameters]\nbase = {value = '
        "2.0}\na = {value = 0.6}\n"
        "b = {value = 0.5}\nc = {value = 0.3333333333333333}\n[range]\nRe = [0.1, "
        "100.0]\nPr = [0.5, 1.0]\n"
        "[provenance]\nscene = 'this test'\n"
    )
    (tmp_path / "conductivity.toml").write_text(
        'format = 1\nkind = "conductivity"\nform = "log_polynomial"\n[variables]\n'
        '"k_solid/k_fluid" = {scale = "log", reference = 1.0}\n[[terms]]\npowers = '
        "[0]\nvalue = 2.0\n"
        '[range]\n"k_solid/k_fluid" = [1.0, 100.0]\n'
        "[provenance]\nscene = 'this test'\n"
    )
    written = tables()
    written["solids"]["inert"]["nusselt"] = {"file": "nusselt.toml"}
    written["bubbling_bed"]["conductivity"] = {"file": "conductivity.toml"}
    named = tables()
    named["solids"]["inert"]["nusselt"] = "ranz_marshall"
    found, other = solved(from_dict(written, base=tmp_path)), solved(from_dict(named))
    # a conductivity of 0.4 W/m/K adds nothing to a mixing of 2e4
    assert found.qoi["T_inert_mid_K"] == approx(other.qoi["T_inert_mid_K"], rel=1e-6)
    assert any(
        use["name"] == "conductivity of conductivity.toml" for use in found.closures
    )


@each_case(__file__, "bad_scenes")
def test_bad_scenes_are_explained(said, changes, without):
    refused(said, lambda: hot(**changes, **dict.fromkeys(without)))


def test_gas_below_minimum_fluidization_is_refused():
    refused(
        r"gas.mass_flow = 0.05: below minimum fluidization, 0\.0\d+ kg/s at 1100 K",
        lambda: cb.run(hot(inlet__mass_flow=0.05)),
    )
    # `contbed check`
    refused("below minimum fluidization", lambda: plan(hot(inlet__mass_flow=0.05)))


def test_gas_that_flows_down_through_the_emulsion_is_refused_where_it_does():
    """The state says whether a closure lets gas flow down: the particles are not as
    hot as the guess.
    """
    with pytest.raises(
        ConvergenceError,
        match=r"bubbles\.emulsion_gas: the gas would flow down .* m/s at .* m, which",
    ):
        cb.run(hot(bubbles__emulsion_gas="kunii_levenspiel", inlet__mass_flow=1.0))
    # at 1100 K, where layers are predicted, it would flow down
    solved(hot(bubbles__emulsion_gas="kunii_levenspiel"))


@pytest.mark.slow  # 5 CPU s
def test_states_that_no_gas_has_do_not_end_the_search():
    """Newton's method fails at 124 K, where hardly any bed is fluidized; steps in
    time find the bed at 2455 K.
    """
    found = solved(cb.load("studies/rabi_two_flux_bed/none.toml"))
    # table of the study
    assert found.qoi["T_char_mid_K"] == approx(2454.8, abs=0.1)


def test_closures_by_hand():
    """Worked step by step, on paper."""
    # Darton: 0.54 0.3^0.4 0.5^0.8 / 9.81^0.2 with 0.6178, 0.5743, 1.5787
    z = (0.1214 * 9.81**0.2 / (0.54 * 0.3**0.4)) ** 1.25
    assert z == approx(0.5, rel=2e-3)
    assert closures.bubble_growth_darton(0.1214, 0.3, 1.0) == approx(
        0.8 * 0.1214 / z, rel=1e-12
    )
    # Zabrodsky: 35.8 x 4.820 x 0.2114 x 15.43
    assert closures.bed_tube_zabrodsky(5e-4, 2600.0, 0.075) == approx(
        35.8 * 4.820 * 0.2114 * 15.43, rel=1e-3
    )
    # Molerus: l = (4.5e-5 / (3.132 x 2600))^(2/3) = 3.13e-7^..., 0.09/l/(13.33 + 19.32)
    length = (4.5e-5 / (3.1321 * 2599.7)) ** (2 / 3)
    assert closures.bed_tube_molerus_laminar(
        50.0, 4.5e-5, 0.3, 1150.0, 0.075, 2600.0
    ) == approx(0.09 / length / (13.333 + 19.324), rel=1e-4)
    # Haider: Stokes' law for a small sphere, Newton's 1.74 ((rho_s/rho) g d)^(1/2) for
    # a large one to 10 %
    fine = closures.terminal_velocity_haider_levenspiel(1e-3, 1.8e-5, 1.2, 1e-5, 1.0)
    assert fine == approx(1.8e-5 / (1.2 * 1e-5) * 1e-3 / 18.0, rel=5e-3)
    Ar = 2e-2**3 * 1.2 * 2600.0 * 9.81 / 1.8e-5**2
    coarse = closures.terminal_velocity_haider_levenspiel(Ar, 1.8e-5, 1.2, 2e-2, 1.0)
    assert coarse == approx(1.74 * (2600.0 / 1.2 * 9.81 * 2e-2) ** 0.5, rel=0.1)
    # collisions: Sun and Chen's 5.36 (m/E)^0.6 (R v)^0.7 per impact over the
    # effusivities, 36 / (4 pi^2) of the rate
    f, d, v = (0.1, 0.4), (1e-3, 7e-4), 0.5
    m = np.pi / 6 * np.array([2000 * d[0] ** 3, 2600 * d[1] ** 3])
    number = [share / (np.pi / 6 * each**3) for share, each in zip(f, d, strict=True)]
    w = 2 / 15 * v**2 / 0.1 * (d[0] ** 2 + d[1] ** 2)
    impacts = (
        number[0] * number[1] * (0.5 * (d[0] + d[1])) ** 2 * (8 * np.pi * w) ** 0.5
    )
    each = (
        5.36
        * (m.prod() / m.sum() / 3e7) ** 0.6
        * (d[0] * d[1] / (2 * (d[0] + d[1])) * v) ** 0.7
    )
    each /= (2000 * 1000 * 1.0) ** -0.5 + (2600 * 1000 * 2.0) ** -0.5
    found = closures.solid_exchange_agu(
        *f, *d, 2000.0, 2600.0, 1000.0, 1000.0, 1.0, 2.0, v, 1.0
    )
    assert found == approx(impacts * each, rel=2e-3)  # 4.88 is rounded


def test_bubble_fraction_joins_its_limits():
    u, u_mf, eps = 1.0, 0.2, 0.45
    slow = closures.bubble_fraction_kunii_levenspiel(u, u_mf, 1e-3, eps)
    assert slow == approx((u - u_mf) / (1e-3 + 2 * u_mf), rel=1e-6)
    fast = closures.bubble_fraction_kunii_levenspiel(u, u_mf, 100.0, eps)
    assert fast == approx(u / 100.0, rel=1e-3)
    rise = np.geomspace(0.01, 100, 400)
    assert np.all(
        np.diff(closures.bubble_fraction_kunii_levenspiel(u, u_mf, rise, eps)) < 0
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"bubbles": None},
            r"solids\.char\.mixing_conductivity.*needs delta, u_b, d_b.*given here: .*u_mf",
        ),
        (
            {"bubbles__start": {"name": "darton", "area": -1.0}},
            r"bubbles\.start: parameter 'area'.*\(0, inf\)",
        ),
    ],
)
def test_closures_that_the_bed_cannot_use_are_refused(changes, message):
    refused(message, lambda: cb.plan(hot(**changes)))

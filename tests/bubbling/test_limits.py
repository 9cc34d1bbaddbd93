"""Beds whose solution is known: exponentials, one temperature, the two-energy model,
equilibrium.
"""

import numpy as np
import pytest
from bubbling_scenes import QUIET, case1, one, solids

import contbed as cb
from contbed.loading import from_dict
from tests.scene_text import scene_of

INERT = {
    "volume_share": 1.0,
    "diameter": 1e-3,
    "gas_coefficient": 100.0,
    "mixing_conductivity": 5.0,
}


def test_inert_heater_is_an_exponential():
    """Without mixing the particles follow the gas, and the tubes heat it through
    both resistances in series.
    """
    tubes = {"perimeter": 2.0, "coefficient": 300.0, "temperature": 800.0}
    result = cb.run(
        one(inert={"mixing_conductivity": 0.0, "gas_coefficient": 1.0}, tubes=tubes)
    )
    z, gas, inert = (
        result.profiles[name] for name in ("z [m]", "T_emulsion [K]", "T_inert [K]")
    )
    inside, outside = 1.3 * 6 * 0.5 / 1e-3 * 1.0, 2.0 * 300.0
    exact = 800.0 - 500.0 * np.exp(-z / 300.0 / (1 / inside + 1 / outside))
    # the interpolation error of cubic elements on the automatic mesh, relative to 500 K
    assert np.abs(gas - exact).max() < 5e-6 * 500
    assert (
        np.abs(inert - (inside * exact + outside * 800.0) / (inside + outside)).max()
        < 5e-6 * 500
    )


def test_two_energy_model_of_a_packed_bed():
    """One species and no bubbles: the fluid and solid of the packed bed with the
    same coefficients.
    """
    section, flow, source = 1.3, 300.0, 2e6
    bed = cb.run(one(inert={"release": {"rate": source}}))
    scene = scene_of(
        """
        mesh = { type = "line", length = 0.6 }
        packed_bed = { porosity = 0.5 }
        heat = {}
        solver = { tolerance = 1e-7 }

        [gas]
        density = 1.0
        heat_capacity = 1000.0
        conductivity = 0.05
        viscosity = 2e-5

        [solids.inert]
        diameter = 1e-3
        density = 2000.0
        heat_capacity = 900.0
        conductivity = 1.0

        [closures]
        nusselt = 2.0
        conductivity_gas = 0.0
        conductivity_solids = 5.0

        [boundary.left.gas]
        temperature = 300.0
        """,
        {
            "region.bed.solids.heat_source": source,
            "boundary.left.gas.velocity": flow / section / 1000.0,
            "output": QUIET | {"positions": list(np.linspace(0.0, 0.6, 61))},
        },
    )
    packed = cb.run(from_dict(scene))
    z = bed.profiles["z [m]"]
    for name, other in (
        ("T_emulsion [K]", "T_fluid [K]"),
        ("T_inert [K]", "T_solid [K]"),
    ):
        at = np.interp(packed.profiles["x [m]"][5:], z, bed.profiles[name])
        # 5200 K are released; reading a profile of 12 points in a cell by straight
        # lines costs 1e-5 of that
        assert np.abs(at - packed.profiles[other][5:]).max() < 5e-5 * 5200
    rise = bed.qoi["T_emulsion_top_K"] - 300.0
    assert rise == pytest.approx(packed.qoi["T_fluid_out_K"] - 300.0, rel=1e-6)
    assert bed.qoi["release_inert_W"] == pytest.approx(
        source * section * 0.6, rel=1e-12
    )


def test_infinite_exchange_is_one_temperature():
    """-K T'' + W T' + P (T - T_t) = Q with the Danckwerts inlet that a gas in
    equilibrium with the particles makes.
    """
    conductivity, flow, contact, source = 200.0, 300.0, 600.0, 1e5
    two = {
        "a": INERT
        | {"volume_share": 0.4, "gas_coefficient": 1e10, "mixing_conductivity": 50.0},
        "b": INERT
        | {"volume_share": 0.6, "gas_coefficient": 1e10, "mixing_conductivity": 150.0},
    }
    two["a"] |= {"release": {"rate": source}, "exchange": {"b": 1e13}}
    result = cb.run(
        one(
            solids=two,
            inlet={"capacity_flow": 0.25 * flow, "temperature": 300.0},
            bubbles={"fraction": 0.2, "capacity_flow": 0.75 * flow, "exchange": 1e13},
            tubes={"perimeter": 2.0, "coefficient": 300.0, "temperature": 800.0},
        )
    )
    K, Q, H = 1.3 * conductivity, 1.3 * source, 0.6
    down, up = (flow + np.array([-1.0, 1.0]) * np.sqrt(flow**2 + 4 * K * contact)) / (
        2 * K
    )
    far = 800.0 + Q / contact
    # a e^(down z) + b e^(up (z - H)): -K T' + W (T - 300) = 0 at z = 0, T' = 0 at z = H
    a, b = np.linalg.solve(
        [
            [flow - K * down, (flow - K * up) * np.exp(-up * H)],
            [down * np.exp(down * H), up],
        ],
        [flow * (300.0 - far), 0.0],
    )
    z = result.profiles["z [m]"]
    exact = far + a * np.exp(down * z) + b * np.exp(up * (z - H))
    inside = z > 1e-6  # above the layer in which the gas meets the particles
    for name in ("T_a [K]", "T_b [K]", "T_emulsion [K]", "T_bubble [K]"):
        # W/(a h) is 1e-13 m, of no account; what is left is the mesh
        assert np.abs(result.profiles[name] - exact)[inside].max() < 5e-6 * 800, name


def test_everything_at_one_temperature_stays_there():
    T = 900.0
    surfaces = {
        name: {
            "perimeter": 4.0,
            "coefficient": 50.0,
            "temperature": T,
            "emissivity": 0.5,
        }
        for name in ("tubes", "walls")
    }
    particles = solids(**{name: {"release": None} for name in ("char", "limestone")})
    for name in ("char", "limestone"):
        particles[name]["feed"]["temperature"] = T
    result = cb.run(
        case1(
            inlet={"capacity_flow": 230.0, "temperature": T},
            release=None,
            solids=particles,
            freeboard={"temperature": T},
            **surfaces,
        )
    )
    for header, column in result.profiles.items():
        if header.startswith("T_"):
            # rounding through cells of 0.1 mm
            assert np.abs(column - T).max() < 1e-7, header
    # of 37 kW/m2 of black radiation
    assert (
        max(abs(value) for name, value in result.qoi.items() if name.endswith("_W"))
        < 1e-3
    )


def test_thick_bed_between_mirrors_is_the_papers_closure():
    """Small mean free paths carry nothing from place to place, so that only the
    exchange at one height is left.
    """
    closed = {"distributor": None, "freeboard": None}
    differences = []
    for factor in (1.0, 0.1):
        fine = {
            name: {"diameter": factor * d}
            for name, d in (("char", 3e-3), ("limestone", 1e-3), ("inert", 7e-4))
        }
        p1, paper = (
            cb.run(case1(name, solids=solids(**fine), **closed))
            for name in ("p1", "paper_closure")
        )
        differences.append(abs(p1.qoi["T_char_mid_K"] - paper.qoi["T_char_mid_K"]))
    # surfaces take from the field p eps/4 of K_a A (1 - delta) = 400 m, which it lags
    # behind: as the diameter
    assert differences[0] < 1.0
    assert differences[1] < 0.15 * differences[0]


def test_equal_bubbles_and_emulsion_gas():
    """Bubbles with infinite exchange are emulsion gas of the sum of both flows where
    particles fill the same volume.
    """
    joined = cb.run(
        case1(
            "none", bubbles={"fraction": 0.3, "capacity_flow": 460.0, "exchange": 1e12}
        )
    )
    alone = cb.run(
        case1(
            "none",
            bubbles={"fraction": 0.3, "capacity_flow": 0.0, "exchange": 1e12},
            inlet={"capacity_flow": 690.0, "temperature": 300.0},
        )
    )
    for name, value in joined.qoi.items():
        assert value == pytest.approx(alone.qoi[name], rel=2e-6), name

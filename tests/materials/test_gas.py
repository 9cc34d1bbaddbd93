"""Gas mixtures against Cantera itself, and the identities that hold between their
properties.
"""

import pickle
import sys

import cantera as ct
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contbed.errors import SceneError
from contbed.loading import from_dict
from contbed.materials import gas_mixture
from tests.cases import each_case
from tests.refusals import problems_of, refused
from tests.scene_text import scene_of

PRESSURE = 2.3e5
MIXTURES = {
    "nitrogen": "N2:1",
    "steam": "H2O:1",
    "air": "N2:0.79, O2:0.21",
    "syngas": "CO:0.2, CO2:0.1, H2:0.2, H2O:0.1, CH4:0.05, N2:0.35",
    "three mid temperatures": "AR:1, HCN:1, HNCO:2, N2:2, HOCN:0.5, C3H8:1e-6",
}
# holds both ends and 1000 K, the usual mid temperature
T = np.linspace(300.0, 3000.0, 541)


@pytest.fixture(scope="module", params=MIXTURES, ids=list(MIXTURES))
def pair(request):
    """The mixture, and Cantera's own properties at T."""
    composition = MIXTURES[request.param]
    solution = ct.Solution("gri30.yaml")
    wanted = (
        "density",
        "cp_mass",
        "viscosity",
        "thermal_conductivity",
        "enthalpy_mass",
    )
    rows = []
    for T_i in T:
        solution.TPX = T_i, PRESSURE, composition
        rows.append([getattr(solution, name) for name in wanted])
    names = ("density", "heat_capacity", "viscosity", "conductivity", "enthalpy")
    return (
        gas_mixture(composition, PRESSURE),
        dict(zip(names, np.array(rows).T, strict=True)),
        solution,
    )


@pytest.mark.parametrize(
    "name", ["density", "heat_capacity", "viscosity", "conductivity"]
)
def test_equals_cantera(pair, name):
    """1e-12: both are sums of the same few terms; Cantera's unshifted fits lose up
    to 3 digits by cancellation.
    """
    gas, cantera, _ = pair
    assert_allclose(getattr(gas, name)(T), cantera[name], rtol=1e-12)


def test_enthalpy_equals_cantera_below_the_mid_temperatures_and_is_continuous(pair):
    """Above, Cantera's jumps by the rounding of its seven-digit coefficients; 100
    J/kg is 0.1 K at most.
    """
    gas, cantera, solution = pair
    T_mid = sorted({solution.species(s).thermo.coeffs[0] for s in gas.mole_fractions})
    scale = np.ptp(cantera["enthalpy"])
    low = T_mid[0] >= T
    assert_allclose(
        gas.enthalpy(T[low]), cantera["enthalpy"][low], rtol=1e-12, atol=1e-12 * scale
    )
    assert_allclose(gas.enthalpy(T), cantera["enthalpy"], rtol=0, atol=100.0)
    for T_m in T_mid:
        below, above = gas.enthalpy(np.array([T_m, np.nextafter(T_m, np.inf)]))
        assert abs(above - below) < 1e-12 * scale


def test_enthalpy_is_the_integral_of_heat_capacity(pair):
    """Complex step, exact to round-off; off 1000 K, where a complex number counts as
    above the mid temperature.
    """
    gas, _, _ = pair
    points = T[T != 1000.0]
    slope = gas.enthalpy(points + 1e-20j).imag / 1e-20
    assert_allclose(slope, gas.heat_capacity(points), rtol=1e-13)


def test_ideal_gas_law(pair):
    gas, _, _ = pair
    assert_allclose(
        gas.density(T) * 8.31446261815324 * T / gas.molar_mass, PRESSURE, rtol=1e-14
    )


def test_sanity(pair):
    gas, _, _ = pair
    assert np.all(np.diff(gas.density(T)) < 0)
    assert np.all(np.diff(gas.enthalpy(T)) > 0)
    assert np.all(np.diff(gas.viscosity(T)) > 0)
    assert np.all(gas.conductivity(T) > 0)
    assert not gas.constant
    assert gas.T_range == (300.0, 3000.0)


def test_shapes_and_scalars():
    gas = gas_mixture("N2:0.79, O2:0.21", 1e5)
    field = T[:540].reshape(60, 9)
    for name in ("density", "heat_capacity", "enthalpy", "viscosity", "conductivity"):
        f = getattr(gas, name)
        assert_array_equal(f(field).ravel(), f(T[:540]))
        assert np.isclose(f(500.0), f(np.array([500.0]))[0], rtol=1e-15)


def test_ways_to_write_a_composition():
    wanted = gas_mixture("N2:0.79, O2:0.21", 1e5).viscosity(T)
    for composition in (
        {"N2": 79, "O2": 21, "AR": 0},
        "N2: 3.76; O2:1",
        "N2 : 79 O2 : 21",
    ):
        gas = gas_mixture(composition, 1e5)
        assert list(gas.mole_fractions) == ["N2", "O2"]
        assert_allclose(gas.viscosity(T), wanted, rtol=1e-4)
    assert_array_equal(
        gas_mixture("N2", 1e5).density(T), gas_mixture({"N2": 2.0}, 1e5).density(T)
    )


def test_survives_pickling():
    gas = gas_mixture("N2:0.79, O2:0.21", 1e5)
    assert_array_equal(pickle.loads(pickle.dumps(gas)).viscosity(T), gas.viscosity(T))


def test_cost_does_not_grow_with_species():
    """One polynomial for each range, however many species."""
    gas = gas_mixture(MIXTURES["syngas"], 1e5)
    assert [len(c) for c in gas._heat_capacity] == [5, 5]


@each_case(__file__, "mistakes")
def test_mistakes_are_told(arguments, words):
    with pytest.raises(SceneError) as caught:
        gas_mixture(*arguments)
    for word in words:
        assert word in str(caught.value)


def test_all_unknown_species_at_once():
    assert len(problems_of(gas_mixture, "XX:1, YY:1, N2:1", 1e5)) == 2


def test_a_file_with_species_alone_is_used_by_the_phase_that_the_message_gives(
    tmp_path,
):
    """The line of the message is a mechanism with the same data."""
    with pytest.raises(SceneError, match="has species and no phase") as caught:
        gas_mixture("CH4:0.1, N2:0.9", 1e5, "nasa_gas.yaml")
    own = tmp_path / "gas.yaml"
    own.write_text(str(caught.value).split("`")[1])
    constant = {"viscosity": 2e-5, "conductivity": 0.03}
    made = gas_mixture("CH4:0.1, N2:0.9", 1e5, str(own), **constant)
    usual = gas_mixture("CH4:0.1, N2:0.9", 1e5, "gri30.yaml", **constant)
    assert_allclose(made.heat_capacity(T), usual.heat_capacity(T), rtol=5e-3)


def test_no_cantera(monkeypatch):
    monkeypatch.setitem(sys.modules, "cantera", None)
    refused(r"package cantera .*pip install cantera", gas_mixture, "N2", 1e5)


def test_share_outside():
    gas = gas_mixture("N2", 1e5)
    assert gas.share_outside(
        np.array([299.9, 300.0, 3000.0, 3000.1, 3100.0])
    ) == pytest.approx(0.6)
    assert gas.share_outside(500.0) == 0.0


@each_case(__file__, "fractions_sum_to_one")
def test_fractions_sum_to_one(text, good):
    """Fractions that do not are a mistake of the scene; amounts above 1 are in
    moles, in any scale.
    """
    fluid = {"model": "cantera", "composition": text}
    scenes = (
        scene_of("""
            [mesh]
            type = "line"
            length = 1.0

            [packed_bed]
            porosity = 0.4

            [solids.sand]
            density = 2000.0
            heat_capacity = 900.0
            conductivity = 1.0
            diameter = 0.01

            [closures]
            nusselt = 10.0

            [heat]

            [boundary.left.gas]
            velocity = 0.1
            temperature = 400.0
        """, {"gas": fluid}),
        scene_of("""
            [particles]
            count = 60
            width = [8e-3, 8e-3]
            height = 0.06

            [solids.glass]
            diameter = 2e-3
            density = 2500.0
            heat_capacity = 840.0
            conductivity = 0.84
            emissivity = 0.9

            [closures]
            nusselt = "gunn"

            [boundary.bottom.gas]
            velocity = 1.0

            [time]
            end = 0.01
            sample = 0.001
        """, {"gas": fluid}),
    )  # fmt: skip
    for scene in scenes:
        if good:
            assert from_dict(scene)
        else:
            refused(
                r"gas\.composition.*fractions sum to (1\.1|0\.91), not to 1",
                from_dict,
                scene,
            )

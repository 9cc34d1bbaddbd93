"""Reversible reactions of solids: shrinking cores beyond their equilibrium, and laws
that have none.
"""

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.chemistry.species import solid_species
from contbed.errors import SceneError
from contbed.loading import loads
from contbed.scene.reactions import Substance

BED = """
mesh = { type = "line", length = "2 cm", cells = 2 }
packed_bed = { porosity = 0.4, pressure_drop = "none" }
closures = { sherwood = 6.0 }
"""
MAGNETITE = (
    BED
    + """
title = "Magnetite pellets in much hydrogen: the product layer controls"
time = { end = "400 s", times = ["150 s"] }

[gas]
model = "cantera"
composition = "H2:1, H2O:0"
pressure = "2 bar"
diffusivity = "8e-2 m**2/s"
viscosity = 2e-5

[solids.pellets]
diameter = "12 mm"
composition = "Fe3O4:1"
density = 3600.0

[solids.pellets.constituent]
Fe3O4 = { heat_capacity = 200.0, enthalpy = "-1118.4 kJ/mol", entropy = 146.4 }
Fe = { heat_capacity = 36.0, enthalpy = 0.0, entropy = 27.3 }

[reactions.reduction]
equation = "Fe3O4 + 4 H2 <-> 3 Fe + 4 H2O"
law = "shrinking_core"
A = 500.0
E = 0
diffusivity = "1.5e-4 m**2/s"

[boundary.left]
gas = { velocity = "300 m/s", temperature = "800 degC" }
"""
)
LIME = (
    BED
    + """
title = "Lime in CO2: the product layer controls"
time = { end = "1500 s", times = ["600 s"] }

[gas]
model = "ideal_gas"
composition = "CO2:0.5, N2:0.5"
pressure = "1 bar"
diffusivity = "1e-2 m**2/s"
viscosity = 4e-5

[gas.species]
CO2 = { heat_capacity = 50.0, enthalpy = "-393.51 kJ/mol", entropy = 213.79 }
N2 = {}

[solids.lime]
diameter = "5 mm"
density = 1600.0
composition = "CaO:1"

[solids.lime.constituent]
CaO = { heat_capacity = 50.0, enthalpy = "-634.9 kJ/mol", entropy = 38.1 }
CaCO3 = { heat_capacity = 110.0, enthalpy = "-1206.9 kJ/mol", entropy = 91.7 }

[reactions.carbonation]
equation = "CaO + CO2 <-> CaCO3"
law = "shrinking_core"
A = 500.0
E = 0
diffusivity = "5e-6 m**2/s"

[boundary.left]
gas = { velocity = "100 m/s", temperature = "750 degC" }
"""
)
# resistances of film and reaction, depletion of the gas along the bed: some tenths of a
# percent of the time
CONTROL = 1e-2


def left_of(text, solid, made, per_solid, time):
    """Share of a solid that is left at a time, of which others are made."""
    profiles = cb.run(loads(text)).profiles
    rows = np.isclose(profiles["t [s]"], time)
    n, others = (profiles[f"n_{name} [mol/m3]"][rows].mean() for name in (solid, made))
    return n / (n + others / per_solid)


def share_left(time, total):
    """Of a core behind a product layer: time/total = 1 - 3 q^2 + 2 q^3, q^3 left."""
    roots = np.roots([2.0, -3.0, 0.0, 1.0 - time / total])
    (q,) = [root.real for root in roots if abs(root.imag) < 1e-9 and 0 < root.real < 1]
    return q**3


def equilibrium_of_lime(T):
    """ln K of the data of the scene, by hand: enthalpies and entropies of 298.15 K and
    constant heat capacities.
    """
    total = 0.0
    for n, h, s, cp in (
        (-1.0, -634.9e3, 38.1, 50.0),  # CaO
        (-1.0, -393.51e3, 213.79, 50.0),  # CO2
        (1.0, -1206.9e3, 91.7, 110.0),  # CaCO3
    ):
        g = h + cp * (T - 298.15) - T * (s + cp * np.log(T / 298.15))
        total -= n * g / (8.314462618 * T)
    return total


def test_lime_takes_up_what_is_beyond_equilibrium():
    """n_gas made is none: the drive is c - c_eq, whatever the unit of c is."""
    T, R = 1023.15, 8.314462618
    beyond = (0.5e5 - 1e5 * np.exp(-equilibrium_of_lime(T))) / (R * T)
    n = 1600.0 / 56.077e-3
    total = (2.5e-3) ** 2 * n / (6.0 * 5e-6 * beyond)
    found = left_of(LIME, "CaO", "CaCO3", 1.0, 600.0)
    assert found == pytest.approx(share_left(600.0, total), rel=5 * CONTROL)


def test_a_core_is_the_same_by_any_multiple_of_its_equation():
    """K belongs to one mole of the gas that is taken up."""
    single = MAGNETITE.replace(
        "Fe3O4 + 4 H2 <-> 3 Fe + 4 H2O", "0.25 Fe3O4 + H2 <-> 0.75 Fe + H2O"
    )
    found = [left_of(text, "Fe3O4", "Fe", 3.0, 150.0) for text in (MAGNETITE, single)]
    assert 0.05 < found[1] < 0.5
    # A is per mole of the equation: a core that reaction slows differs
    assert found[0] == pytest.approx(found[1], rel=5 * CONTROL)


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        (
            'diffusivity = "1.5e-4 m**2/s"',
            'grain_radius = 1e-6\nmolar_density = 1e4\nlaw = "grain"',
            "grains have no reverse",
        ),
        ("+ 4 H2 <-> 3 Fe + 4 H2O", "+ 2 H2 <-> 3 Fe + 2 H2O + O2", "a shrinking core runs back only where"),
        (', entropy = 27.3', "", "needs enthalpy and entropy of Fe"),
    ],
)  # fmt: skip
def test_laws_that_cannot_run_back_are_refused(old, new, text):
    scene = MAGNETITE.replace(old, new)
    if "grain" in new:
        scene = scene.replace('law = "shrinking_core"\n', "")
    with pytest.raises(SceneError, match=text):
        cb.run(loads(scene))


def test_a_core_without_a_gas_to_take_up_is_refused():
    calcined = LIME.replace("CaO + CO2 <-> CaCO3", "CaCO3 -> CaO + CO2")
    calcined = calcined.replace('"CaO:1"', '"CaCO3:1"')
    with pytest.raises(SceneError, match="takes up no gas"):
        cb.run(loads(calcined))


def test_enthalpy_and_entropy_beside_a_to_e_of_shomate():
    """Those of FeO at 298.15 K stand for F and G (NIST webbook), to their digits."""
    five = (45.75120, 18.78553, -5.952201, 0.852779, -0.081265)
    seven = Substance(shomate=(*five, -286.7429, 110.3120))
    stated = Substance(shomate=five, enthalpy=-272044.1, entropy=60.75)
    full, found = (solid_species("FeO", each, True) for each in (seven, stated))
    assert found.has_entropy
    for T in (400.0, 1000.0):
        assert found.gibbs(T) == approx(full.gibbs(T), abs=20.0)
        assert found.enthalpy(T) == approx(full.enthalpy(T), abs=20.0)

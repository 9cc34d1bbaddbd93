"""A scene with constant properties pays for no property library."""

import pytest

from tests.imported import modules_after

HEAVY = {"cantera", "CoolProp", "scipy"}


@pytest.mark.parametrize(
    ("code", "wanted"),
    [
        ("import contbed.materials", set()),
        (
            "from contbed.materials import *; ConstantFluid(1, 1, 1, 1); Solid(1, (1, "
            "1), 1).enthalpy(300.0)",
            set(),
        ),
        (
            "from contbed.materials import gas_mixture; gas_mixture('N2', "
            "1e5).viscosity(300.0)",
            {"cantera"},
        ),
        (
            "from contbed.materials import real_fluid; real_fluid('Water', 1e5, (280, "
            "300))",
            {"CoolProp", "scipy"},
        ),
    ],
)
def test_only_what_is_needed(code, wanted):
    assert HEAVY & modules_after(code) == wanted

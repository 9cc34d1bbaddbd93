"""A scene with constant properties pays for no property library."""

import subprocess
import sys

import pytest

HEAVY = ("cantera", "CoolProp", "scipy")


def loaded(code: str) -> set[str]:
    program = f"import sys\n{code}\nprint(*(m for m in {HEAVY} if m in sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


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
    assert loaded(code) == wanted

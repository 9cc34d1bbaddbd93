"""Single terms of the two energy equations: weighting of storage, dispersion, heat
content, scale of the balance.

Each is compared with an equivalent that the code computes by another term, or with its
closed form; both agree to rounding, unless a test says otherwise.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from manufactured_cases import Heat
from pytest import approx
from scipy.integrate import quad

import contbed as cb
from contbed.fem.ad.dual import Dual
from contbed.fem.stabilisation import tau
from contbed.loading import from_dict
from contbed.packed_bed.equations import two_energy
from contbed.packed_bed.heat import HeatProblem
from contbed.packed_bed.plan import plan
from contbed.packed_bed.run_parts import heat_balance
from tests.scene_text import scene_of

AIR = {
    "density": 1.2,
    "heat_capacity": 1005.0,
    "conductivity": 0.03,
    "viscosity": 1.8e-5,
}


def bed(
    conductivity: float, dispersion: dict[str, float] | None = None, **tables: Any
) -> Any:
    """Cold air into a conducting bed of a hot end, on cells so large that the
    stabilisation shows.
    """
    closures: dict[str, Any] = {
        "nusselt": 5.0,
        "conductivity_gas": conductivity,
        "conductivity_solids": 2.0,
    }
    if dispersion is not None:
        closures["dispersion"] = dispersion
    found = scene_of(
        """
        [mesh]
        type = "line"
        length = 0.2
        cells = 6

        [solids.particles]
        density = 2500.0
        heat_capacity = 900.0
        conductivity = 2.0
        diameter = 0.01

        [packed_bed]
        porosity = 0.4

        [heat]

        [boundary]
        left.gas = { velocity = 0.2, temperature = 300.0 }
        right.solids.particles = { fixed_temperature = 900.0 }

        [solver]
        degree = 1

        [output]
        plots = false
        fields = false
    """,
        {"gas": AIR, "closures": closures},
    )
    return from_dict(found | tables)


def posed(scene: Any) -> HeatProblem:
    """The problem of a scene on its mesh."""
    return HeatProblem(plan(scene))


@pytest.mark.parametrize("shape", ["line", "triangle"])
def test_storage_is_weighted_as_a_source(shape: str) -> None:
    """A heat content of 0.7 J/m3 in each phase is tested as a sink of 0.7 W/m3 is,
    stabilisation included.
    """
    case = Heat(shape, (3,), 2, nonlinear=True)
    manufactured, _ = case.manufactured(3)
    system, state = manufactured.system, manufactured.interpolant()
    c = case.coefficients(system, system.cells)

    def steady(source: float) -> Any:
        phases = {
            name: replace(getattr(c, name), source=source)
            for name in ("fluid", "solid")
        }
        return system.assemble(
            [(two_energy.residual, system.cells, replace(c, **phases))], state, False
        )[0]

    held = {
        name: replace(getattr(c, name), content=lambda T: 0.7 + 0.0 * T)
        for name in ("fluid", "solid")
    }
    stored = system.assemble(
        [(two_energy.storage, system.cells, replace(c, **held))], state, False
    )[0]
    sunk = steady(0.0) - steady(0.7)
    assert np.abs(sunk).max() > 1e-3
    assert stored == approx(sunk, abs=1e-12)


def test_dispersion_along_a_line_is_conductivity() -> None:
    """On a line only dispersion along the flow acts, in conduction and in the
    stabilisation.
    """
    dispersed = cb.run(bed(0.3, {"axial": 0.8, "transverse": 0.5}))
    conducting = cb.run(bed(1.1))
    for name, values in conducting.profiles.items():
        if name.startswith("T_"):
            assert dispersed.profiles[name] == approx(values, rel=1e-12), name


def test_heat_content_of_a_constant_fluid() -> None:
    """eps rho c_p times the change of temperature."""
    medium = plan(bed(0.3)).medium
    assert medium.content_fluid(700.0) - medium.content_fluid(400.0) == approx(
        0.4 * 1.2 * 1005.0 * 300.0
    )
    assert medium.content_solid(700.0) - medium.content_solid(400.0) == approx(
        0.6 * 2500.0 * 900.0 * 300.0
    )


def test_heat_content_of_a_gas() -> None:
    """The integral of eps rho c_p over temperature, by quadrature; the gas expands.

    A polynomial through c_p, whose slope jumps at 1000 K, misses it by 2e-8.
    """
    medium = plan(bed(0.3, gas={"model": "cantera", "composition": "N2:1"})).medium
    gas = medium.fluid
    expected = (
        0.4
        * quad(
            lambda T: float(gas.density(T) * gas.heat_capacity(T)),
            400.0,
            700.0,
            epsabs=0.0,
        )[0]
    )
    assert medium.content_fluid(700.0) - medium.content_fluid(400.0) == approx(
        expected, rel=1e-7
    )


def test_heat_content_beyond_the_range_of_a_fluid_has_the_slope_of_its_end() -> None:
    """A polynomial grows without limit there, and a steep front, which overshoots, has
    no solution.
    """
    oil = {
        "model": "coolprop",
        "name": "INCOMP::TVP1",
        "pressure": 12e5,
        "T_range": [295.0, 650.0],
    }
    medium = plan(bed(0.3, gas=oil)).medium
    fluid = medium.fluid
    for end, beyond in ((295.0, 275.0), (650.0, 670.0)):
        slope = 0.4 * float(fluid.density(end) * fluid.heat_capacity(end))
        change = medium.content_fluid(beyond) - medium.content_fluid(end)
        assert change == approx(slope * (beyond - end), rel=1e-9)


def test_scale_of_the_balance() -> None:
    """What streams carry out above 0 K at the highest temperature of the scene: rho u
    c_p T for each m2.

    A larger scale would let an open balance pass.
    """
    assert posed(bed(0.3)).throughput() == approx(1.2 * 0.2 * 1005.0 * 900.0)
    held = (0.4 * 1.2 * 1005.0 + 0.6 * 2500.0 * 900.0) * 0.2 * 900.0
    assert posed(bed(0.3)).capacity() == approx(held)


def test_a_balance_is_measured_against_what_crosses() -> None:
    """A millionth of what crosses is missing and seen as that, also where streams hold
    300 times as much above 0 K; a larger floor would hide it.
    """
    balance = heat_balance(
        {"left": {"T_fluid": 1.0}, "right": {"T_fluid": 1e-6 - 1.0}},
        {},
        0.0,
        0.0,
        "W",
        300.0,
    )
    assert balance["relative_residual"] == approx(1e-6)


def test_a_closure_of_the_whole_bed_beside_the_fluid_is_told() -> None:
    """By name both conduct the fluid; a number is what is meant."""
    whole = {"nusselt": 10.0, "conductivity_solids": "zehner_schluender"}
    (text,) = bed(0.3, closures=whole).warnings
    assert "closures.conductivity_solids" in text and text.endswith(
        "a second time; give closures.conductivity_gas = 0"
    )
    assert not bed(0.3, closures={**whole, "conductivity_gas": 0.0}).warnings
    assert not bed(0.3, closures={"nusselt": 10.0, "conductivity_solids": 1.0}).warnings


def test_tolerances_and_cells_that_hide_everything_are_told() -> None:
    """A balance that may be open by 1 %, and a bed of one cell."""
    told = bed(
        0.3,
        solver={"balance_tolerance": 0.01},
        mesh={"type": "line", "length": 0.2, "cells": 1},
    ).warnings
    assert any(
        "balance_tolerance" in text and "not meaningful" in text for text in told
    )
    assert any("mesh.cells" in text and "one cell cannot show" in text for text in told)
    assert not bed(0.3).warnings


def test_limits_of_the_stabilisation() -> None:
    """tau is C h/(2 C u), C h^2/(12 k) and C/a where convection, conduction or
    exchange is all there is.
    """
    assert tau(2.0, 0.0, 0.0, 3.0, 0.1, 1) == approx(3.0 * 0.1 / (2.0 * 2.0))
    assert tau(2.0, 0.0, 0.0, 3.0, 0.1, 2) == approx(3.0 * 0.05 / (2.0 * 2.0))
    assert tau(0.0, 2.0, 0.0, 3.0, 0.1, 1) == approx(3.0 * 0.1**2 / (12.0 * 2.0))
    assert tau(0.0, 0.0, 2.0, 3.0, 0.1, 1) == approx(3.0 / 2.0)


@pytest.mark.parametrize(
    ("gas", "error"),
    [
        ({"model": "cantera", "composition": "N2:0.79, O2:0.21"}, 1e-6),
        (
            {
                "model": "coolprop",
                "name": "CO2",
                "pressure": 100e5,
                "T_range": [295.0, 890.0],
            },
            2e-5,
        ),
    ],
    ids=["bends of air", "peak of carbon dioxide"],
)
def test_the_heat_that_a_fluid_holds_follows_its_properties(
    gas: dict[str, Any], error: float
) -> None:
    """The derivative of its content is rho c_p, also where that bends or peaks, and the
    content its integral by Simpson's rule.
    """
    medium = plan(bed(0.3, gas=gas)).medium
    T = np.linspace(306.0, 880.0, 2297)
    exact = 0.4 * medium.fluid.density(T) * medium.fluid.heat_capacity(T)
    found = medium.content_fluid(Dual(T, {(0, 0): np.ones_like(T)}))
    assert found.tangents[0, 0] == approx(exact, rel=error)
    simpson = (exact[:-2:2] + 4.0 * exact[1:-1:2] + exact[2::2]) * (T[1] - T[0]) / 3.0
    assert np.diff(found.value[::2]) == approx(simpson, rel=10.0 * error)

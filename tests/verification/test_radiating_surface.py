"""A boundary whose surface radiates to surroundings: `emissivity` and `ambient` of a
phase, alone or beside a wall coefficient and a heat flux.
"""

from __future__ import annotations

import pytest
from pytest import approx
from scipy.optimize import brentq

import contbed as cb
from contbed.closures.optics import SIGMA
from contbed.loading import from_dict
from tests.balances import assert_closed
from tests.cases import each_case
from tests.refusals import refused
from tests.scene_text import scene_of, set_keys

LENGTH, K_SOLID, EPS, EMISSIVITY, HOT, COLD = 0.1, 2.0, 0.4, 0.7, 1200.0, 300.0
MESHES = {
    "line": ({"type": "line", "length": LENGTH}, ("left", "right"), 1.0),
    "plane": (
        {"type": "rectangle", "length": LENGTH, "height": 0.02, "cells": [8, 2]},
        ("left", "right"),
        0.02,
    ),
    "round": (
        {"type": "axisymmetric", "length": LENGTH, "radius": 0.1, "cells": [2, 8]},
        ("bottom", "top"),
        3.141592653589793 * 0.01,
    ),
    "box": (
        {
            "type": "box",
            "length": LENGTH,
            "width": 0.02,
            "height": 0.03,
            "cells": [6, 1, 1],
        },
        ("left", "right"),
        6e-4,
    ),
}


def scene(mesh, sides, emissivity=EMISSIVITY, **more):
    """A bed that conducts from a hot end to one that radiates; the phases do not
    exchange heat.
    """
    low, high = sides
    fluid = {"fixed_temperature": 500.0}
    return (
        scene_of(
            """
                closures = { nusselt = 0.0 }
                heat = {}

                [gas]
                density = 1.0
                heat_capacity = 1000.0
                conductivity = 0.05
                viscosity = 2e-5

                [solids.particles]
                density = 2000.0
                heat_capacity = 900.0
                diameter = 2e-3
            """,
            {
                "mesh": mesh,
                "solids.particles.conductivity": K_SOLID,
                "packed_bed.porosity": EPS,
                "boundary": {
                    low: {
                        "gas": fluid,
                        "solids": {"particles": {"fixed_temperature": HOT}},
                    },
                    high: {
                        "solids": {
                            "particles": {"emissivity": emissivity, "ambient": COLD}
                        }
                    },
                },
            },
        )
        | more
    )


@pytest.mark.parametrize("name", MESHES)
def test_conduction_to_a_radiating_end_is_exact(name):
    """k (T0 - T)/L = e sigma (T^4 - Ta^4) at the end, linear between: 1e-9 by
    Newton; the balance to 1e-10.
    """
    mesh, sides, section = MESHES[name]
    k = (1.0 - EPS) * K_SOLID
    end = brentq(
        lambda T: k * (HOT - T) / LENGTH - EMISSIVITY * SIGMA * (T**4 - COLD**4),
        COLD,
        HOT,
        xtol=1e-12,
    )
    result = cb.run(from_dict(scene(mesh, sides)))
    T = result.profiles["T_solid [K]"]
    assert T[-1] == approx(end, rel=1e-9)
    assert T[len(T) // 2] == approx(
        HOT + (end - HOT) * next(iter(result.profiles.values()))[len(T) // 2] / LENGTH,
        rel=1e-9,
    )
    assert result.qoi[f"heat_{sides[1]}_W"] == approx(
        -section * k * (HOT - end) / LENGTH, rel=1e-8
    )
    assert_closed(result, 1e-10, "energy")


def test_flux_coefficient_and_emissivity_add_up():
    """k (T - T0)/L = q + h (Ta - T) + e sigma (Ta^4 - T^4) at the end: 1e-9 by
    Newton.
    """
    mesh, sides, _ = MESHES["line"]
    values = scene(mesh, sides)
    surface = values["boundary"][sides[1]]["solids"]["particles"]
    flux, coefficient = 2e4, 15.0
    surface |= {"heat_flux": flux, "coefficient": coefficient}
    k = (1.0 - EPS) * K_SOLID

    def missing(T):
        convection = coefficient * (COLD - T)
        radiation = EMISSIVITY * SIGMA * (COLD**4 - T**4)
        return flux + convection + radiation - k * (T - HOT) / LENGTH

    end = brentq(missing, COLD, HOT, xtol=1e-12)
    result = cb.run(from_dict(values))
    assert result.profiles["T_solid [K]"][-1] == approx(end, rel=1e-9)
    assert_closed(result, 1e-10, "energy")


@pytest.mark.parametrize("phase", ["gas", "particles"])
@pytest.mark.parametrize("key", ["heat_flux", "coefficient", "emissivity"])
def test_heat_into_a_phase_that_does_not_conduct_is_refused(phase, key):
    """The result would depend on the size of the cells."""
    mesh, (low, high), _ = MESHES["plane"]
    values = scene(mesh, (low, high))
    given = {key: 0.5} | ({} if key == "heat_flux" else {"ambient": COLD})
    values["boundary"][high] = (
        {"gas": given} if phase == "gas" else {"solids": {"particles": given}}
    )
    conductivity = "conductivity_gas" if phase == "gas" else "conductivity_solids"
    values["closures"][conductivity] = 0.0
    table = {"gas": ".solids.particles", "particles": ".gas"}[phase]
    advice = f"boundary.{high}{table if key == 'emissivity' else ''}.{key}"
    refused(f"closures.{conductivity} = 0; give {advice}$", from_dict, values)
    values["boundary"][high] = {}
    set_keys(values, f"{advice} = 0.5")
    if key != "heat_flux":
        set_keys(values, f"{advice.removesuffix(key)}ambient = 300.0")
    from_dict(values)


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("k_gas", [0.0, 0.3])
def test_phases_share_the_heat_of_a_wall(name, k_gas):
    """Two phases without exchange conduct from ends of one temperature to a wall that
    gives a flux: both have the slope q/(k_gas + k_solid) of a bed of one temperature.
    Newton: 1e-9.
    """
    mesh, (low, high), section = MESHES[name]
    values = scene(mesh, (low, high))
    values["closures"] |= {"conductivity_gas": k_gas, "conductivity_solids": K_SOLID}
    end, flux = {"fixed_temperature": COLD}, 1500.0
    solids = {"particles": end}
    values["boundary"][low] = {"solids": solids} | ({"gas": end} if k_gas else {})
    values["boundary"][high] = {"heat_flux": flux}
    values["closures"]["nusselt"] = 0.0 if k_gas else 2.0
    result = cb.run(from_dict(values))
    T = COLD + flux * LENGTH / (k_gas + K_SOLID)
    assert result.profiles["T_solid [K]"][-1] == approx(T, rel=1e-9)
    if k_gas:
        assert result.profiles["T_fluid [K]"][-1] == approx(T, rel=1e-9)
    assert result.qoi[f"heat_{high}_W"] == approx(section * flux, rel=1e-9)
    assert_closed(result, 1e-10, "energy")


def test_no_phase_conducts_what_a_wall_gives():
    mesh, (low, high), _ = MESHES["plane"]
    values = scene(mesh, (low, high))
    values["closures"] |= {"conductivity_gas": 0.0, "conductivity_solids": 0.0}
    values["boundary"][high] = {"heat_flux": 10.0}
    zero = "closures.conductivity_gas = 0 and closures.conductivity_solids = 0"
    refused(f"{zero}; give a phase a conductivity", from_dict, values)


@pytest.mark.parametrize(
    ("name", "k_gas", "loose"),
    [
        ("line", 0.3, "solid"),
        ("plane", 0.0, "gas"),
        ("plane", 0.3, None),
    ],
)
def test_a_phase_that_takes_no_heat_of_the_wall_is_undetermined(name, k_gas, loose):
    """Without exchange each phase needs a temperature of its own; beside a line the
    wall is that of the gas.
    """
    mesh, (low, high), _ = MESHES[name]
    values = scene(mesh, (low, high))
    values["closures"] |= {"conductivity_gas": k_gas, "conductivity_solids": K_SOLID}
    side = "wall" if name == "line" else high
    values["mesh"] = mesh | ({"diameter": 0.1} if name == "line" else {})
    values["boundary"] = {side: {"coefficient": 5.0, "ambient": COLD}}
    if loose is None:
        from_dict(values)
        return
    refused(f"temperature of the {loose} is undetermined", from_dict, values)


def test_heat_of_a_wall_stands_once():
    mesh, (low, high), _ = MESHES["plane"]
    values = scene(mesh, (low, high))
    values["boundary"][high]["heat_flux"] = 10.0
    refused("for the whole bed, or in gas and solids.NAME", from_dict, values)


def test_phases_that_do_not_conduct_are_told_together():
    """P1 carries no heat away from a boundary of the solid: its temperature there grew
    from 532 to 1027 K from 10 to 160 cells. A flux of 0 passes none.
    """
    mesh, (low, high), _ = MESHES["line"]
    values = scene(mesh, (low, high))
    values["closures"] |= {"conductivity_gas": 0.0, "conductivity_solids": 0.0}
    surface = {"heat_flux": 0.0}
    values["boundary"][high] = {"solids": {"particles": surface}}
    from_dict(values)
    set_keys(values, 'radiation = { level = "p1" }')
    values["solids"]["particles"]["emissivity"] = 0.8
    surface["heat_flux"] = 2e3
    refused("solids = 0; give a phase a conductivity", from_dict, values)
    values["radiation"]["level"] = "rosseland"
    from_dict(values)


def test_small_emissivity_is_adiabatic():
    mesh, sides, _ = MESHES["line"]
    result = cb.run(from_dict(scene(mesh, sides, emissivity=1e-9)))
    assert result.profiles["T_solid [K]"] == approx(HOT, rel=1e-6)


@each_case(__file__, "what_does_not_fit_is_refused")
def test_what_does_not_fit_is_refused(solid, wrong):
    mesh, sides, _ = MESHES["line"]
    values = scene(mesh, sides)
    values["boundary"]["right"]["solids"] = {"particles": solid}
    refused(wrong, from_dict, values)

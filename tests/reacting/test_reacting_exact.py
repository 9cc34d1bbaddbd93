"""Reacting beds against closed forms, to the digits of their tables."""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import (
    bilinear,
    danckwerts,
    equilibrium,
    ergun,
    expansion,
    shrinking_core,
    species,
    table,
)
from solving import solved

from contbed.chemistry.local import Smoothing
from contbed.loading import loads
from contbed.reacting_bed import solve
from contbed.runner import run
from tests.scene_text import set_keys

# of what enters: fluxes at the ends converge with order 7; cells follow a tolerance of
# 1e-6 and reach 1e-8 and better
DIGITS = 1e-8
FRONT = 1e-6  # where a conversion ends at a point with an infinite slope


@pytest.mark.parametrize(
    "row",
    table("danckwerts_first_order"),
    ids=lambda row: f"{row['Pe']:g}-{row['Da']:g}",
)
def test_first_order_with_dispersion(row):
    scene = danckwerts(row["Pe"], row["Da"])
    set_keys(scene, "output.positions = [0.0, 0.5, 1.0]")
    result = solved(scene)
    assert result.qoi["x_A_out"] == approx(row["c1"], abs=DIGITS)
    # inside of a cell the polynomials are of order 4
    assert list(result.profiles["x_A [1]"]) == approx(
        [row["c0"], row["c_half"], row["c1"]], rel=1e-5
    )


@pytest.mark.parametrize(
    "row", table("expansion_first_order"), ids=lambda row: f"{row['e']:g}-{row['Da']:g}"
)
def test_change_of_moles(row):
    result = solved(expansion(row["e"], row["Da"]))
    assert result.qoi["conversion_A"] == approx(row["conversion"], rel=DIGITS)
    assert result.qoi["u_out_m_s"] / result.qoi["u_in_m_s"] == approx(
        row["velocity_ratio"], rel=1e-6
    )


@pytest.mark.parametrize(
    "row", table("ergun_isothermal_gas"), ids=lambda row: f"{row['G_kg_m2_s']:g}"
)
def test_pressure_of_an_isothermal_gas(row):
    result = solved(ergun(row))
    assert result.qoi["p_out_Pa"] == approx(row["p_out_Pa"], rel=1e-10)
    assert result.qoi["u_out_m_s"] == approx(row["u_out_m_s"], rel=1e-7)


@pytest.mark.parametrize(
    "row",
    table("counter_current_bilinear"),
    ids=lambda row: f"{row['N']:g}-{row['r']:g}",
)
def test_counter_current_bilinear(row):
    result = solved(bilinear(row["N"], row["r"]))
    gas_in = result.qoi["out_A_mol_m2s"] + result.qoi["out_B_mol_m2s"]
    assert result.qoi["out_A_mol_m2s"] / gas_in == approx(row["gas_out"], abs=DIGITS)
    left = 1.0 - result.qoi["conversion_S"]
    assert left == approx(row["solid_out_over_in"], abs=DIGITS)


@pytest.mark.parametrize(
    "row",
    table("counter_current_shrinking_core"),
    ids=lambda r: f"{r['N']:g}-{r['n']:g}-{r['f']:g}-{r['d']:g}",
)
def test_counter_current_shrinking_core(row):
    result = solved(shrinking_core(*(row[key] for key in ("N", "n", "f", "d", "r"))))
    gas = result.qoi["out_A_mol_m2s"] / (
        result.qoi["out_A_mol_m2s"] + result.qoi["out_B_mol_m2s"]
    )
    assert gas == approx(row["gas_out"], abs=FRONT)
    assert result.qoi["conversion_S"] == approx(row["X_out"], abs=FRONT)


@pytest.mark.parametrize(
    "row", table("equilibrium_shift"), ids=lambda row: f"{row['T_K']:g}"
)
def test_shift_ends_in_equilibrium(row):
    scene = equilibrium(
        "CO:1, H2O:2, N2:1", 1e5, row["T_K"], {"shift": "CO + H2O <-> CO2 + H2"}
    )
    qoi = solved(scene).qoi
    for name in ("CO", "H2O", "CO2", "H2"):
        assert qoi[f"x_{name}_out"] == approx(row[f"x_{name}"], rel=1e-8)
    assert qoi["Q_over_K_shift"] == approx(1.0, abs=1e-8)


@pytest.mark.parametrize(
    "row", table("equilibrium_reforming"), ids=lambda row: f"{row['T_K']:g}"
)
def test_reforming_ends_in_equilibrium(row):
    equations = {
        "reforming": "CH4 + H2O <-> CO + 3 H2",
        "shift": "CO + H2O <-> CO2 + H2",
    }
    qoi = solved(equilibrium("CH4:1, H2O:3", row["p_Pa"], row["T_K"], equations)).qoi
    for name in ("CH4", "CO", "H2O", "CO2", "H2"):
        assert qoi[f"x_{name}_out"] == approx(row[f"x_{name}"], rel=1e-8)


def test_inert_gases_have_no_conversion():
    """Rounding of what leaves would decide whether one of 1e-15 is written."""
    scene = danckwerts(5.0, 1.0)
    set_keys(scene, 'gas.composition = "A:0.5, B:0.1, N:0.4"')
    scene["gas"]["species"] |= species(N=0.014)
    found = solved(scene).qoi
    assert [name for name in found if name.startswith("conversion_")] == [
        "conversion_A"
    ]


@pytest.mark.parametrize(
    ("shares", "within"),
    [
        ((2.0, 1.2, 0.2, 0.5, 0.3), 1e-3),
        ((1.0, 0.8, 0.2, 0.5, 0.3), 1e-3),
        ((2.0, 0.8, 0.0, 0.0, 1.0), 0.6),
    ],
    ids=["film-and-ash", "much-gas", "used-up"],
)
def test_what_smooth_powers_change_is_estimated(shares, within):
    """Straight lines below 1e-3 of a core, by a step of Newton's method; half too
    much where it ends within the bed.
    """
    problem, sharp = solved(shrinking_core(*shares)).solved
    smooth = problem.with_small(Smoothing(1e-3))
    u = solve.newton(smooth, sharp, solve.Report())
    change = np.abs(
        solve.what_leaves(problem, sharp) - solve.what_leaves(smooth, u)
    ).max()
    assert change > 1e-8
    assert solve.smoothing_changes(smooth, u, solve.Report()) == approx(
        change, rel=within
    )


def test_pure_steam_has_no_dry_composition():
    """Nothing but water leaves, so that fractions of the dry gas mean nothing."""
    found = run(
        loads(
            """
mesh = { type = "line", length = 0.6 }
gas = { model = "cantera", composition = "H2O:1" }
solids.s = { density = 2200, heat_capacity = 1000, diameter = 0.04 }
packed_bed.porosity = 0.4
boundary.left.gas = { velocity = 0.5, temperature = 423 }
reactions.none = { equation = "2 H2O -> 2 H2 + O2", law = "power", A = 0, E = 0 }
"""
        )
    )
    assert found.qoi["x_H2O_out"] == approx(1.0, rel=1e-12)
    assert not [name for name in found.qoi if name.endswith("_dry")]

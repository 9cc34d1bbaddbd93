"""Several kinds of particles in one bed: alike they are one kind; unlike they follow
closed forms; balances close.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest import approx
from reacting_bed_scenes import (
    MOLAR,
    bilinear,
    fixed_bed,
    isothermal,
    let_move,
    shrinking_core,
    solids,
    species,
    table,
)
from scipy.linalg import expm
from several_solids import SHARES, part_of, split
from solving import solved, stepped

from contbed.loading import from_dict
from contbed.reacting_bed.plots import looks_of
from contbed.reacting_bed.problem import Problem
from tests.scene_text import set_keys

# of two solutions of the same equations on the same cells, whose Newton's methods end
# at 1e-10
ROUNDING = 1e-9
# of runs with steps to a tolerance of 1e-3, whose lengths rounding may move by a
# percent
STEPS = 1e-5
DIGITS = 1e-8  # fluxes at the ends on cells that follow a tolerance of 1e-6
EPS, U = 0.4, 0.5


def hot(**more) -> dict:
    """Particles that react with gas and give off heat, against the gas, with all
    that a bed may have.
    """
    gases = species(A=0.028, B=0.028)
    gases["A"] |= {"heat_capacity": 30.0, "enthalpy": 4e3}
    gases["B"] |= {"heat_capacity": 32.0, "enthalpy": 0.0}
    scene = isothermal("A:0.9, B:0.1", gases, **more)
    set_keys(
        scene,
        """
        gas.viscosity = 2e-5
        gas.conductivity = 0.03
        gas.diffusivity = 2e-5
        packed_bed.pressure_drop = "ergun"
        """,
    )
    scene["solids"]["particles"] |= solids()
    for name, heat in (("S", 1e3), ("P", 0.0)):
        scene["solids"]["particles"]["constituent"][name] |= {
            "heat_capacity": 80.0,
            "enthalpy": heat,
        }
    set_keys(
        scene,
        """
        heat = {}
        closures.nusselt = "nusselt_wakao_kaguei"
        closures.conductivity_solids = 0.5
        closures.conductivity_gas = 0.1
        closures.sherwood = "sherwood_wakao_funazkri"
        closures.dispersion_mass = 1e-4
        """,
    )
    let_move(scene, -2e-4, temperature=400.0)
    orders = {"A": 1.0, "S": 1.0}
    scene["reactions"] = {
        "r": {
            "equation": "A + S -> B + P",
            "A": 5e-3,
            "E": "20 kJ/mol",
            "orders": orders,
        }
    }
    set_keys(scene, 'reactions.r.basis = "bed"')
    return scene


def alike(scene: dict, same: float = ROUNDING) -> None:
    """Compare one kind with two that differ in nothing; what each makes and holds is
    its share.
    """
    one, two = solved(scene), solved(split(scene))
    for key, value in one.qoi.items():
        names = (
            [key]
            if key in two.qoi
            else [
                k
                for k in two.qoi
                if k.replace("_coarse", "").replace("_fine", "") == key
            ]
        )
        assert names, key
        for name in names:
            assert two.qoi[name] == approx(value, rel=same, abs=same), name
    for key, values in one.profiles.items():
        name, unit = key.split(" ")
        of_kinds = {f"{name}_{kind} {unit}": part_of(name, kind) for kind in SHARES}
        for column, part in ({key: 1.0} if key in two.profiles else of_kinds).items():
            assert two.profiles[column] == approx(part * values, rel=same, abs=same), (
                column
            )
    if "extent_r_mol_m2s" in one.qoi:
        for kind, share in SHARES.items():
            part = two.qoi[f"extent_r_{kind}_mol_m2s"]
            assert part == approx(share * one.qoi["extent_r_mol_m2s"], rel=same)


def on_cells(scene: dict, cells: int = 12) -> dict:
    return scene | {"mesh": scene["mesh"] | {"cells": cells}}


@pytest.mark.parametrize(
    "scene",
    [
        on_cells(bilinear(2.0, 1.2)),
        on_cells(shrinking_core(2.0, 1.2, 0.2, 0.5, 0.3), 24),
        on_cells(hot(), 5),
    ],
    ids=["bilinear", "shrinking_core", "hot"],
)
def test_kinds_that_are_alike_are_one(scene):
    alike(scene)


@pytest.mark.parametrize("with_one_temperature", [False, True])
def test_kinds_that_are_alike_are_one_along_the_gas(with_one_temperature):
    scene = on_cells(hot(), 5)
    scene["boundary"]["left"]["solids"] = scene["boundary"].pop("right")["solids"]
    if with_one_temperature:
        del scene["closures"]["nusselt"]
    alike(scene)


@pytest.mark.parametrize("moves", [True, False], ids=["moving", "at rest"])
@pytest.mark.parametrize("gas", ["quasi_steady", "stored"])
def test_steps_of_kinds_that_are_alike_are_those_of_one(moves, gas):
    one, two = (
        stepped(in_time(scene, moves, gas), 5.0) for scene in (hot(), split(hot()))
    )
    for name, values in one.items():
        parts = {
            kind: share if name.startswith("n_") else 1.0
            for kind, share in SHARES.items()
        }
        for kind, share in parts.items():
            found = two[name if name in two else f"{name}_{kind}"]
            assert found == approx(share * values, rel=ROUNDING, abs=ROUNDING), name


def in_time(scene: dict, moves: bool, gas: str = "auto") -> dict:
    scene = on_cells(scene, 3)
    set_keys(scene, "time = { end = 200.0, tolerance = 1e-3 }")
    scene["packed_bed"]["gas_storage"] = gas
    set_keys(scene, "initial.temperature = 450.0")
    if not moves:
        del scene["boundary"]["right"]
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("moves", [True, False], ids=["moving", "at rest"])
def test_runs_in_time_of_kinds_that_are_alike(moves):
    alike(in_time(hot(), moves), STEPS)


def test_two_sizes_in_a_moving_bed_follow_their_own_closed_forms():
    """First order in what is left, at a rate of each kind's own, and cores that
    shrink in much gas.
    """
    scene = on_cells(split(bilinear(1.0, 1.0)))
    streams = scene["boundary"]["right"]["solids"]
    v = streams["fine"]["velocity"]
    k = {kind: c * v / (1.0 - EPS) for kind, c in (("coarse", 0.5), ("fine", 1.5))}
    streams["fine"]["velocity"] = 2.0 * v
    scene["gas"]["composition"] = "A:0.5, B:0.5"
    scene["boundary"]["left"]["gas"]["velocity"] = 50.0  # more gas than solids take
    scene["reactions"] = {
        f"r_{kind}": {
            "equation": "A + S -> B + P",
            "A": each,
            "E": 0.0,
            "orders": {"S": 1.0},
            "solid": kind,
        }
        for kind, each in k.items()
    }
    qoi = solved(scene).qoi
    X = {"coarse": 1.0 - np.exp(-0.5), "fine": 1.0 - np.exp(-0.75)}
    for kind, exact in X.items():
        assert qoi[f"conversion_S_{kind}"] == approx(exact, abs=DIGITS)
    flow = {"coarse": 0.3, "fine": 1.4}
    mean = sum(flow[kind] * X[kind] for kind in X) / sum(flow.values())
    assert qoi["conversion_S"] == approx(mean, abs=DIGITS)
    mass = 3000.0 * v * sum(flow.values())
    assert qoi["solids_out_kg_m2s"] == approx(mass, rel=DIGITS)


@pytest.mark.slow
def test_two_sizes_at_rest_shrink_as_their_diameters_say():
    """A surface reaction in a gas that hardly changes: X = 1 - (1 - t/tau)^3,
    tau = rho d/(2 k c).
    """
    scene = fixed_bed("shrinking_core", 0.0, 0.0, 1.0, 1e-9, 0.4)
    set_keys(
        scene,
        """
        mesh.length = 1.0
        mesh.cells = 2
        boundary.left.gas.velocity = 1e9
        output.positions = [0.5]
        time.tolerance = 1e-5
        """,
    )
    scene = split(scene, fine={"diameter": 2e-3})  # 3 mm is complete after 1000 s
    result = solved(scene)
    X = {"coarse": 1.0 - (1.0 - 0.4) ** 3, "fine": 1.0 - (1.0 - 0.4 * 3.0 / 2.0) ** 3}
    for kind, exact in X.items():  # steps of a local tolerance of 1e-5
        assert result.profiles[f"w_P_{kind} [1]"][-1] == approx(exact, abs=1e-5)


def catalysed(share: float, **more) -> dict:
    """A share of catalyst among beads without reaction."""
    scene = isothermal("A:1", species(A=0.028, B=0.028), **more)
    d = scene["solids"].pop("particles")["diameter"]
    scene["solids"] = {
        "catalyst": {"volume_share": share, "diameter": d, "density": 1500.0},
        "beads": {"volume_share": 1.0 - share, "diameter": 2.0 * d, "density": 2500.0},
    }
    scene["reactions"] = {
        "r": {
            "equation": "A -> B",
            "A": 2e-3,
            "E": 0.0,
            "basis": "catalyst",
            "solid": "catalyst",
        }
    }
    return scene


@pytest.mark.parametrize("share", [0.2, 0.75])
def test_beads_dilute_a_catalyst(share):
    Da = 2e-3 * share * (1.0 - EPS) * 1500.0 / U
    assert solved(catalysed(share)).qoi["conversion_A"] == approx(
        1.0 - np.exp(-Da), abs=DIGITS
    )


def test_each_kind_has_its_own_film():
    """Resistances of film and reaction in series for each of two catalysts, in
    parallel for both.
    """
    scene = catalysed(0.4)
    D, Sh = 2e-5, {"catalyst": 4.0, "beads": 8.0}
    scene["gas"]["diffusivity"] = D
    for kind, number in Sh.items():
        scene["solids"][kind]["sherwood"] = number
    set_keys(scene, 'reactions.r.solid = ["catalyst", "beads"]')
    total = 0.0
    for kind, at in scene["solids"].items():
        d, share = at["diameter"], at["volume_share"]
        film = Sh[kind] * D / d * 6.0 * share * (1.0 - EPS) / d
        total += 1.0 / (1.0 / film + 1.0 / (2e-3 * share * (1.0 - EPS) * at["density"]))
    qoi = solved(scene).qoi
    assert qoi["conversion_A"] == approx(1.0 - np.exp(-total / U), abs=DIGITS)
    assert qoi["extent_r_mol_m2s"] == approx(
        U * MOLAR * (1.0 - np.exp(-total / U)), rel=DIGITS
    )


def exchanging(directions: float) -> tuple[dict, dict[str, float]]:
    """Two sizes heated by a gas with constant data, and what the matrix exponential
    says of what leaves.
    """
    G, cp, k_f, L, v = 0.5, 30.0 / 0.028, 0.03, 0.3, 3e-4
    gases = species(A=0.028)
    gases["A"] |= {"heat_capacity": 30.0, "enthalpy": 0.0}
    scene = isothermal("A:1", gases)
    scene["gas"]["conductivity"] = k_f
    scene["mesh"]["length"] = L
    scene["boundary"]["left"]["gas"] = {"mass_flux": G, "temperature": 900.0}
    set_keys(scene, "heat = {}")
    kinds = {
        "small": (0.25, 4e-3, 2000.0, 800.0, 5.0, v),
        "large": (0.75, 9e-3, 1200.0, 1000.0, 8.0, 1.5 * v),
    }
    scene["solids"] = {
        kind: {
            "volume_share": share,
            "diameter": d,
            "density": rho,
            "heat_capacity": c,
            "nusselt": Nu,
        }
        for kind, (share, d, rho, c, Nu, _) in kinds.items()
    }
    end = "left" if directions > 0 else "right"
    streams = {
        kind: {"velocity": speed, "temperature": 300.0}
        for kind, (*_, speed) in kinds.items()
    }
    scene["boundary"].setdefault(end, {})["solids"] = streams
    rows = np.zeros((3, 3))
    for i, (share, d, rho, c, Nu, speed) in enumerate(kinds.values(), 1):
        ha = Nu * k_f / d * 6.0 * share * (1.0 - EPS) / d
        C = directions * speed * share * rho * c
        rows[0, [0, i]] += np.array([-ha, ha]) / (G * cp)
        rows[i, [0, i]] = np.array([ha, -ha]) / C
    E = expm(rows * L)
    if directions > 0:
        gas, *leaving = E @ [900.0, 300.0, 300.0]
    else:
        leaving = np.linalg.solve(E[1:, 1:], 300.0 - E[1:, 0] * 900.0)
        gas = E[0] @ [900.0, *leaving]
    exact = {
        "T_fluid_out_K": gas,
        "T_solid_small_out_K": leaving[0],
        "T_solid_large_out_K": leaving[1],
    }
    return scene, exact


@pytest.mark.parametrize("directions", [1.0, -1.0], ids=["along", "against"])
def test_two_sizes_heated_by_a_gas(directions):
    scene, exact = exchanging(directions)
    result = solved(scene)
    for key, value in exact.items():
        assert result.qoi[key] == approx(value, rel=DIGITS), key
    assert {"T_solid_small [K]", "T_solid_large [K]"} <= set(result.profiles)
    assert "4 temperatures" not in str(
        result.plan
    ) and "3 temperatures: of the gas, and of small, large" in str(result.plan)


def unlike(**more) -> dict:
    """Ore that reacts and beads that hold heat, of other size and speed."""
    scene = split(hot(**more), {"ore": 0.6, "beads": 0.4}, ore={"diameter": 4e-3})
    beads = {
        "volume_share": 0.4,
        "diameter": 8e-3,
        "density": 2500.0,
        "heat_capacity": 900.0,
    }
    scene["solids"]["beads"] = beads | {"nusselt": 12.0}
    set_keys(scene, "boundary.right.solids.beads.velocity = 4e-4")
    return scene


def test_balances_close_with_all_that_differs():
    result = solved(on_cells(unlike(), 6))
    assert "energy" in result.balances and "conversion_S_ore" in result.qoi
    # Ergun's equation has the Sauter mean
    at = result.plan.problem.bed.medium.diameter
    assert at == approx(1.0 / (0.6 / 4e-3 + 0.4 / 8e-3), rel=1e-14)


@pytest.mark.slow
def test_steps_in_time_end_in_the_steady_state():
    """P enters as well: of a scene that would fall below zero on its cells the
    steady state alone is damped.
    """
    scene = on_cells(unlike(), 4)
    set_keys(scene, 'solids.ore.composition = "S:0.9, P:0.1"')
    steady = solved(scene)
    assert steady.qoi["cells_damped"] == 0
    set_keys(scene, "time = { end = 2e5, tolerance = 1e-3 }")
    set_keys(scene, "initial.temperature = 500.0")
    ended = solved(scene)
    for key in ("T_fluid_out_K", "conversion_S_ore", "T_solid_beads_out_K", "x_A_out"):
        assert ended.qoi[key] == approx(steady.qoi[key], rel=1e-7), key


def test_beads_at_rest_among_ore_that_moves_are_as_hot_as_the_gas():
    """Nothing heats them but the gas where nothing conducts, and a steady state
    needs no heat capacity of theirs.
    """
    scene = on_cells(unlike(), 5)
    del scene["boundary"]["right"]["solids"]["beads"]
    del (
        scene["closures"]["conductivity_solids"],
        scene["solids"]["beads"]["heat_capacity"],
    )
    result = solved(scene)
    assert result.profiles["T_solid_beads [K]"] == approx(
        result.profiles["T_fluid [K]"], rel=1e-10
    )
    assert "T_solid_beads_out_K" not in result.qoi and result.qoi[
        "solids_out_kg_m2s"
    ] == approx(0.36, rel=1e-12)


def test_streams_that_change_reach_all_kinds():
    """A bed whose streams are replaced, as series do at each of their times, is that
    of a scene with them.
    """
    scene = on_cells(unlike(), 4)
    vertices = np.linspace(0.0, 1.0, 5)
    set_keys(scene, "boundary.right.solids.beads.velocity = 2e-4")
    before = Problem.of(from_dict(scene), vertices)
    set_keys(scene, "boundary.left.gas.velocity = 0.7")
    let_move(scene, -3e-4, temperature=420.0)
    there = from_dict(scene)
    exact, found = Problem.of(there, vertices), before.within(there)
    u = exact.start(450.0)
    residuals = [problem.system.assemble(u, False)[0] for problem in (exact, found)]
    assert residuals[1] == approx(residuals[0], rel=1e-13)
    assert np.abs(before.system.assemble(u, False)[0] - residuals[0]).max() > 0.0


@pytest.mark.slow
def test_a_gas_that_changes_in_time_reaches_all_kinds():
    scene = on_cells(hot(), 4)
    set_keys(
        scene,
        """
        boundary.left.gas.velocity = { times = [0.0, 50.0], values = [0.5, 0.7], form = "step" }
        time = { end = 100.0, tolerance = 1e-3 }
        initial.temperature = 450.0
        """,
    )
    alike(scene, STEPS)


def test_the_table_of_one_kind_holds_for_each_of_several():
    row = next(row for row in table("counter_current_bilinear") if row["r"] != 1.0)
    qoi = solved(split(bilinear(row["N"], row["r"]))).qoi
    for name in ("conversion_S", "conversion_S_coarse", "conversion_S_fine"):
        assert 1.0 - qoi[name] == approx(row["solid_out_over_in"], abs=DIGITS)


def test_lines_of_a_constituent_have_one_colour_and_a_style_for_each_kind():
    looks = looks_of(
        ["T_fluid", "T_solid_ore", "T_solid_coke", "w_C_coke", "w_C_ore"],
        ["ore", "coke"],
    )
    colours, styles = zip(*looks, strict=True)
    assert (
        colours[1] == colours[2] != colours[0]
        and colours[3] == colours[4] != colours[1]
    )
    assert styles == ("--", "-", "--", "--", "-")
    assert len(set(looks_of(["w_A", "w_B", "w_C"], []))) == 3
    (axis, full), (same, broken) = looks_of(
        ["T_solid_ore_axis", "T_solid_coke_axis"], ["ore", "coke"]
    )
    assert axis == same and (full, broken) == ("-", "--")

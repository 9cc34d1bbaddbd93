"""Several kinds of particles in beds resolved across the flow: alike they are one;
rings alike are one dimension.
"""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from several_solids import SHARES, part_of, split, split_pellets
from solving import solved, stepped
from test_kinds_adsorb import warm
from test_kinds_pellets import reforming
from test_reacting_section import heated, mixed
from test_several_solids import hot, on_cells, unlike

from contbed.loading import from_dict
from contbed.reacting_bed.equations.section import Section
from contbed.reacting_bed.plan import plan
from tests.refusals import refused
from tests.scene_text import set_keys

# of two solutions of the same equations, whose Newton's methods end at 1e-10
ROUNDING = 1e-9
DIAMETER = 0.1  # [m]
COOLED = {"coefficient": 50.0, "ambient": 350.0}


def across(scene, wall=COOLED, rings=3, **more):
    """The bed in rings that exchange heat by gas and particles, and species."""
    scene = deepcopy(scene)
    section = {
        "rings": rings,
        "conductivity_gas": 0.3,
        "conductivity_solids": 0.6,
        "dispersion_mass": 1e-4,
    }
    scene["packed_bed"]["section"] = section | more
    scene["mesh"]["diameter"] = DIAMETER
    if wall:
        scene["boundary"]["wall"] = wall
    return scene


def same(one, two, kinds=SHARES):
    """All profiles of one bed, each of particles in every kind of the other."""
    for key, values in one.profiles.items():
        name, unit = key.split(" ")
        place = next((end for end in ("_axis", "_wall") if name.endswith(end)), "")
        of_kinds = {
            f"{name.removesuffix(place)}_{kind}{place} {unit}": part_of(name, kind)
            for kind in kinds
        }
        for column, part in ({key: 1.0} if key in two.profiles else of_kinds).items():
            np.testing.assert_allclose(
                two.profiles[column],
                part * values,
                rtol=ROUNDING,
                atol=1e-12,
                err_msg=column,
            )


def along():
    """Particles that move with the gas, at its temperature."""
    scene = on_cells(hot(), 5)
    scene["boundary"]["left"]["solids"] = scene["boundary"].pop("right")["solids"]
    del scene["closures"]["nusselt"]
    return scene


@pytest.mark.parametrize("temperatures", [1, 2])
def test_kinds_that_are_alike_are_one(temperatures):
    """They react with heat and move; the wall cools, by a coefficient on the
    stagnant conductivity.
    """
    scene = along() if temperatures == 1 else on_cells(hot(), 5)
    set_keys(scene, "solids.particles.conductivity = 0.8")
    wall = COOLED | {"coefficient": "martin_nilles"}
    scene = across(scene, wall, conductivity_solids="krupiczka", dispersion="vdi")
    del scene["packed_bed"]["section"]["conductivity_gas"]
    one, two = solved(scene), solved(split(scene))
    same(one, two)
    assert (
        np.abs(
            one.profiles["T_fluid_axis [K]"] - one.profiles["T_fluid_wall [K]"]
        ).max()
        > 20.0
    )


def test_each_kind_conducts_by_its_share():
    """One temperature: two conductivities of particles are one of their mean by
    volume.
    """
    scene = along()
    scene["solids"]["particles"]["conductivity"] = 0.3 * 2.0 + 0.7 * 0.5
    scene = across(scene, conductivity_solids="phase")
    same(
        solved(scene),
        solved(split(scene, coarse={"conductivity": 2.0}, fine={"conductivity": 0.5})),
    )


@pytest.mark.parametrize(
    "kinds", [unlike, lambda: split_pellets(reforming())], ids=["unlike", "pellets"]
)
def test_rings_alike_are_the_bed_in_one_dimension(kinds):
    """Kinds of other size, speed and conduction, and pellets that are resolved,
    behind a wall that nothing passes.
    """
    one = solved(on_cells(kinds(), 4))
    two = solved(across(on_cells(kinds(), 4), {}))
    same(one, two)


@pytest.mark.parametrize("gas", ["quasi_steady", "stored"])
@pytest.mark.parametrize("level", ["film", "interior"])
def test_steps_of_kinds_that_adsorb(gas, level):
    """Kinds alike are one kind in each ring, as the wall warms."""
    scene = across(warm(level), COOLED | {"ambient": 600.0}, rings=2)
    scene["packed_bed"]["gas_storage"] = gas
    one, two = stepped(scene, 2.0), stepped(split(scene), 2.0)
    for name, values in one.items():
        for found in [name] if name in two else [f"{name}_{kind}" for kind in SHARES]:
            assert two[found] == pytest.approx(values, rel=ROUNDING, abs=1e-12), found


def test_all_that_differs_closes():
    """Kinds of other size and speed cooled by a wall: what each conducts to it is in
    the balance of energy.
    """
    result = solved(across(on_cells(unlike(), 4)))
    assert "energy" in result.balances
    for kind in ("ore", "beads"):
        axis, wall = (
            result.profiles[f"T_solid_{kind}_{place} [K]"] for place in ("axis", "wall")
        )
        assert np.abs(axis - wall).max() > 5.0


def test_heat_passes_from_ring_to_ring_within_a_kind():
    """Ore that is warmer at the axis warms the ore of the next ring, by its share of
    0.6 W/m/K, and no beads there.
    """
    problem = plan(from_dict(across(on_cells(unlike(), 4), rings=2))).problem
    names, rings = list(problem.layout.names), problem.rings
    section = Section(problem.bed, rings)

    def gains(warmer):
        points = np.array([problem.first_point()] * 2, dtype=float)
        points[0, names.index("T_solid_ore")] += warmer
        values = [np.array([value]) for value in points.ravel()]
        outer = section(values, [0.0 * value for value in values], np.zeros(1))[2][
            len(names) :
        ]
        return {
            name: float(outer[names.index(f"T_solid_{name}")][0])
            for name in ("ore", "beads")
        }

    cold, warm = gains(0.0), gains(10.0)
    assert warm["beads"] == cold["beads"]
    # 0.6 of the volume are ore
    exact = 10.0 * 0.6 * 0.6 * rings.joins[0].area / rings.shares[1]
    assert warm["ore"] - cold["ore"] == pytest.approx(exact, rel=1e-9)


def test_beads_among_a_catalyst_pass_heat_as_a_plug_flow():
    """Graetz's problem with particles of two sizes that all have the conductivity of
    the bed.
    """
    scene = heated(8)
    d = scene["solids"].pop("particles")["diameter"]
    scene["solids"] = {
        "catalyst": {"volume_share": 0.4, "diameter": d, "density": 1000.0},
        "beads": {"volume_share": 0.6, "diameter": 2.0 * d, "density": 2000.0},
    }
    exact = np.array([mixed("tube", 50.0, x) for x in (0.5, 1.0)])
    found = solved(scene).profiles["T_fluid [K]"]
    assert np.abs(found - exact).max() < 0.5  # of 300 K, by 8 rings as with one kind


def test_a_wall_is_needed():
    scene = across(on_cells(unlike(), 4))
    del scene["mesh"]["diameter"]
    refused(r"mesh\.diameter: missing", from_dict, scene)

"""Scenes of particles: lattices exactly, packings from files, closure files,
mistakes with file and line.
"""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.closures.file import closure_of
from contbed.dem.plausibility import judge
from contbed.loading import loads
from contbed.many.converge import converge
from contbed.scene.identity import scene_hash
from tests.balances import assert_closed
from tests.refusals import problems_of, refused

STUDIES = Path(__file__).parents[2] / "studies"

BED = """
[particles]
file = "bed.csv"

[particles.layers]
bottom = 0.6
top = 4.4
area = 9.0

[solids.spheres]
diameter = 1.0
conductivity = 10.0

[gas]
conductivity = 1.0
"""
LAYERS = "[particles.layers]\nbottom = 0.6\ntop = 4.4\narea = 9.0\n"
RADIATING = (
    BED.replace("diameter", "emissivity = 0.9\ndiameter")
    + "[radiation]\ntemperature = 1500.0\n"
)
VACUUM = BED.replace("[gas]\nconductivity = 1.0\n", "").replace(
    'csv"\n', 'csv"\npaths = "columns"\n'
)


@pytest.fixture
def folder(tmp_path):
    """3 x 3 x 6 spheres of unit diameter in simple cubic order, as positions and as
    a periodic dump.
    """
    x = np.stack(
        np.meshgrid(np.arange(3.0), np.arange(3.0), np.arange(6.0), indexing="ij"), -1
    ).reshape(-1, 3)
    np.savetxt(tmp_path / "bed.csv", x, delimiter=",")
    head = (
        "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n54\nITEM: BOX BOUNDS pp pp pp\n0 "
        "3\n0 3\n0 6\n"
    )
    rows = [f"{k} {a} {b} {c} 0.5" for k, (a, b, c) in enumerate(x)]
    (tmp_path / "bed.dump").write_text(
        head + "ITEM: ATOMS id x y z radius\n" + "\n".join(rows) + "\n"
    )
    return tmp_path


def problems(text, folder="."):
    return problems_of(lambda: cb.run(loads(text, "scene.toml", base=folder)))


@pytest.mark.parametrize(
    ("name", "wanted"), [("sc", 1.0), ("bcc", 3**0.5), ("fcc", 8**0.5)]
)
@pytest.mark.parametrize("cells", [1, 2])
def test_lattices(name, wanted, cells):
    # exact: all contacts are alike, and the mean gradient solves the network
    scene = cb.load(
        STUDIES / f"lattices/{name}.toml", {"particles.lattice.cells": cells}
    )
    result = cb.run(scene)
    assert result.qoi["k_eff_over_contact_scale"] == approx(wanted, rel=1e-12)
    assert result.qoi["k_xx [W/m/K]"] == approx(result.qoi["k_zz [W/m/K]"], rel=1e-12)
    assert abs(result.qoi["k_xy [W/m/K]"]) < 1e-12
    assert result.qoi["coordination"] == {"sc": 6, "bcc": 8, "fcc": 12}[name]
    assert result.qoi["porosity"] == approx(
        {"sc": 0.4764, "bcc": 0.3198, "fcc": 0.2595}[name], abs=1e-4
    )


def test_a_lattice_of_fluid_conducts_as_fluid():
    scene = cb.load(
        STUDIES / "lattices/fcc.toml",
        {"gas.conductivity": 26.0, "particles.paths": "columns"},
    )
    assert cb.run(scene).qoi["k_eff_over_k_fluid"] == approx(1.0, rel=1e-13)


def test_a_bed_of_positions(folder):
    result = cb.run(loads(BED, base=folder))
    # cut planes, not whole cells
    assert result.qoi["porosity"] == approx(1 - np.pi / 6, abs=0.05)
    assert list(result.profiles) == ["z [m]", "T_solid [K]"]
    # layers of a cubic bed are planes of one temperature each, in equal steps
    assert result.profiles["T_solid [K]"] == approx(
        np.linspace(398.15, 298.15, 6), rel=1e-12
    )
    assert_closed(result, 1e-12, "energy")


def test_layers_of_a_periodic_dump_are_its_cell(folder):
    # the sides stay periodic, the axis of the heat does not: then both ways are the
    # same, to round-off
    layers = BED.replace("bed.csv", "bed.dump").replace("diameter = 1.0\n", "")
    cell = layers.replace(LAYERS, "")
    eps = {"particles.porosity": 0.4764}
    found = cb.run(loads(layers, overrides=eps, base=folder)).qoi["k_eff [W/m/K]"]
    assert found == approx(
        cb.run(loads(cell, overrides=eps, base=folder)).qoi["k_zz [W/m/K]"], rel=1e-12
    )
    assert cb.run(loads(cell, base=folder)).qoi["porosity"] == approx(
        1 - np.pi / 6, rel=1e-12
    )


def test_radiation_adds_to_the_conductivity(folder):
    cold = cb.run(loads(BED, base=folder)).qoi
    radiating = cb.run(loads(RADIATING, base=folder))
    hot = radiating.qoi
    assert any("within 1.5 diameters" in text for text in radiating.warnings)
    assert hot["k_eff [W/m/K]"] > cold["k_eff [W/m/K]"]
    assert hot["share_radiation"] > 0.5 and "share_radiation" not in cold


FCC = """
[particles.lattice]
type = "fcc"
contact_radius = 15e-6
[particles.closure]
ratios = [2, 30, 60, 100, 200]
[solids.zirconia]
diameter = 3e-3
conductivity = 2.2
emissivity = 0.5
[gas]
conductivity = 0.25
"""


@pytest.mark.parametrize("more", ["", "[radiation]\ntemperature = 800.0\n"])
def test_conduction_beyond_the_bounds_of_hashin_and_shtrikman_warns(more):
    eps, alpha = 1 - np.pi / 18**0.5, 0.25 / 2.2 - 1
    # Hashin and Shtrikman 1962: k_1 + v_2/(1/(k_2 - k_1) + v_1/(3 k_1)), over k_fluid
    high = (2.2 + eps / (1 / (2.2 * alpha) + (1 - eps) / 6.6)) / 0.25
    low = (0.25 + (1 - eps) / (-1 / (2.2 * alpha) + eps / 0.75)) / 0.25
    (warning,) = cb.run(loads(FCC + more)).warnings
    # the closure at 30 and more is within its bounds; radiation does not count
    assert f"porosity: 6.489 at 8.8 ({low:.4g} to {high:.4g}), 3.298 at 2 (" in warning
    assert warning.count(" to ") == 2
    assert warning.endswith('misses there, try "columns" or "spreading"')


def test_paths_of_equal_spheres_are_no_advice_for_unequal_ones():
    (warning,) = judge({8.8: 9.0}, 0.4, "cones", equal=False)
    assert warning.endswith("need equal spheres: they show by how much")
    # no other path is nearer
    (warning,) = judge({3.0: 9.0}, 0.4, "columns", equal=True)
    assert warning.endswith("conductivity_zehner_schluender holds there")


def test_lists_that_are_too_short_name_their_length():
    short = FCC.replace("[2, 30, 60, 100, 200]", "[20]")
    (problem,) = problems_of(loads, short)
    assert "ratios = [20]: a list of 1; allowed: a list of 3 or more, each a" in problem


def test_spreading_columns_keep_the_bounds():
    text = 'particles.paths = "spreading"\n' + FCC.replace(
        "ratios = [2", "ratios = [20"
    )
    assert not cb.run(loads(text)).warnings


def test_a_run_writes_its_closure(tmp_path):
    scene = cb.load(STUDIES / "zhou_2010_etc/glass.toml", {"output.plots": False})
    result = cb.run(scene, out=tmp_path)
    assert result.qoi["k_eff_over_k_fluid"] == approx(7.042, rel=2e-3)
    closure = closure_of("closure.toml", tmp_path, "conductivity")
    found = closure(k_fluid=0.026, k_solid=2.6, eps=0.391) / 0.026
    assert found == approx(
        result.qoi["k_eff_over_k_fluid"], rel=2 * result.qoi["closure_residual"]
    )
    assert result.qoi["closure_residual"] < 2e-3
    provenance = tomllib.loads((tmp_path / "closure.toml").read_text())["provenance"]
    assert provenance["scene"] == "glass.toml" and provenance[
        "scene_hash"
    ] == scene_hash(scene)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "ok" and summary["qoi"]["coordination"] == approx(4.556)
    assert {
        "versions",
        "scene",
        "dofs",
        "timings",
        "balances",
        "skipped",
        "warnings",
    } <= set(summary)


def test_the_particles_are_part_of_the_scene(folder):
    before = scene_hash(loads(BED, base=folder))
    (folder / "bed.csv").write_text((folder / "bed.csv").read_text() + "9,9,9\n")
    assert scene_hash(loads(BED, base=folder)) != before


def test_mistakes(folder):
    assert problems("[particles]\n[solids.a]\nconductivity = 1.0\n") == [
        "scene.toml:1: particles: give one of file, lattice, packing"
    ]
    lattice = (
        '[particles.lattice]\ntype = "hcp"\ncontact_radius = 0.1\n[solids.a]\n'
        "conductivity = 0\ndiametr = 1\n"
    )
    found = problems(lattice)
    assert found[:2] == [
        'scene.toml:2: particles.lattice.type = "hcp": unknown choice; allowed: sc, '
        "bcc, fcc",
        "scene.toml:5: solids.a.conductivity = 0: out of range; allowed: a number > 0 "
        "W/m/K",
    ]
    assert found[2].startswith(
        "scene.toml:6: solids.a.diametr = 1: unknown key; allowed: "
    )
    more = (
        '[particles.lattice]\ntype = "sc"\ncontact_radius = 2.0\n'
        "[particles.closure]\nratios = [1, 2, 3]\n"
    )
    assert sorted(text.split(": ", 2)[1] for text in problems(BED + more, folder)) == [
        "particles.closure.ratios = [1, 2, 3]",
        "particles.lattice",
        "particles.lattice.contact_radius = 2.0",
        "particles.layers",
    ]
    line = BED.splitlines().index("bottom = 0.6") + 1
    assert problems(BED.replace("0.6", "4.5"), folder)[0].startswith(
        f"scene.toml:{line}: particles.layers.bottom = 4.5: is not"
    )
    assert problems(BED.replace("bed.csv", "no.csv"), folder) == [
        'scene.toml:3: particles.file = "no.csv": no such file; looked for '
        f"{folder / 'no.csv'}"
    ]
    assert "columns are paths through the gas" in problems(VACUUM, folder)[0]


def test_mistakes_that_the_file_shows(folder):
    assert (
        "solids.spheres.diameter: missing"
        in problems(BED.replace("diameter = 1.0\n", ""), folder)[0]
    )
    assert (
        "layers: this table is missing" in problems(BED.replace(LAYERS, ""), folder)[0]
    )
    assert "0 hot and 9 cold" in problems(BED.replace("0.6", "-1.0"), folder)[0]
    text = (folder / "bed.dump").read_text()
    (folder / "bed.dump").write_text(text[:-100])
    (said,) = problems(BED.replace("bed.csv", "bed.dump"), folder)
    key = 'scene.toml:3: particles.file = "bed.dump"'
    assert "truncated" in said and said.startswith(f"{key}: {folder}/bed.dump:")


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        (lambda text: text[: text.index("\n0 0.0") + 1].replace("\n54\n", "\n0\n"), "4: step 7 has no particles"),
        (lambda text: text.replace("\n5 0.0", "\n4 0.0"), "15: id 4 occurs twice in "
                                                          "step 7"),
        (lambda text: text.replace("\n0 6\n", "\n6 0\n"), "8: the box of step 7 has no "
                                                          "volume: z from 6 to 0"),
        (lambda text: text.replace("\n0 3\n", "\n3 3\n", 1), "6: the box of step 7 has "
                                                             "no volume: x from 3 to 3"),
        (lambda text: text.replace("pp pp pp\n0 3", "ff pp pp\n0 1"),
         "46: a particle of step 7 is outside of the box: x = 2"),
        (lambda text: text[:-1], "63: truncated: the last line has no end"),
        (lambda text: text[:-5], "63: truncated: 4 values for the 5 columns id x y z "
                                 "radius"),
    ],
    ids=["no particles", "id twice", "reversed box", "flat box", "outside", "no line break", "cut line"],
)  # fmt: skip
def test_dumps_that_cannot_be_used_are_refused_by_the_check(folder, change, wanted):
    path = folder / "bed.dump"
    path.write_text(change(path.read_text()))
    text = BED.replace("bed.csv", "bed.dump").replace("diameter = 1.0\n", "")
    assert problems_of(loads, text, "scene.toml", base=folder)[0].startswith(
        f'scene.toml:3: particles.file = "bed.dump": {path}:{wanted}'
    )


def test_the_check_sees_what_the_run_would_refuse(folder):
    for text, wanted in (
        (BED.replace("diameter = 1.0\n", ""), "solids.spheres.diameter: missing; "
                                              "bed.csv has no radii"),
        (BED.replace(LAYERS, ""), "layers: this table is missing"),
        (BED.replace("0.6", "-1.0"), "0 hot and 9 cold particles"),
        (BED.replace("area = 9.0", "area = 0.1"), "layers.area = 0.1: gives a porosity "
                                                  "of"),
        (RADIATING.replace('csv"\n', 'csv"\npaths = "columns"\n'),
         "columns are for equal particles without [radiation]"),
    ):  # fmt: skip
        assert wanted in problems_of(loads, text, "scene.toml", base=folder)[0]


def test_unwrapped_positions_of_a_dump_are_brought_into_its_periodic_box(folder):
    text = (folder / "bed.dump").read_text()
    scene = BED.replace("bed.csv", "bed.dump").replace("diameter = 1.0\n", "")
    inside = cb.run(loads(scene, base=folder)).qoi
    # id 3 is at (0, 0, 3): the same sphere one period to the left
    (folder / "bed.dump").write_text(
        text.replace("\n3 0.0 0.0 3.0", "\n3 -3.0 0.0 3.0").replace("x y z", "xu yu zu")
    )
    assert cb.run(loads(scene, base=folder)).qoi == inside


def test_what_does_not_apply_to_particles(tmp_path):
    refused(r"no \[mesh\] to refine", lambda: converge(STUDIES / "lattices/sc.toml", 2))
    refused(
        "nothing to restart",
        lambda: cb.run(cb.load(STUDIES / "lattices/sc.toml"), restart=tmp_path),
    )


def test_former_keys_name_the_present_ones():
    text = """[lattice]
type = "sc"
radius = 1.0
[conduction]
particles = 1.0
fluid = 0.1
[conduction.correction]
real = 1e9
[layers]
bottom = 0.1
"""
    found = problems(text)
    for told in (
        "scene.toml:1: lattice: this key is called 'particles.lattice' now",
        "scene.toml:3: lattice.radius = 1.0: solids.NAME.diameter takes the place of a "
        "radius, with twice the value",
        "scene.toml:5: conduction.particles = 1.0: this key is called "
        "'solids.NAME.conductivity' now",
        "scene.toml:6: conduction.fluid = 0.1: this key is called 'gas.conductivity' "
        "now",
        "scene.toml:8: conduction.correction.real = 1000000000.0: this key is called "
        "'solids.NAME.youngs_modulus' now",
        "scene.toml:9: layers: this key is called 'particles.layers' now",
    ):
        assert told in found


def test_rough_contacts_need_all_their_properties(folder):
    text = BED.replace("conductivity = 10.0", "conductivity = 10.0\nroughness = 1e-6")
    keys = [line.split(": ", 2)[1].split(" = ")[0] for line in problems(text, folder)]
    assert set(keys) == {
        "solids.spheres.roughness",
        "solids.spheres.asperity_slope",
        "solids.spheres.microhardness",
        "solids.spheres.youngs_modulus",
        "gas.mean_free_path",
    }

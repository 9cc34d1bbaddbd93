"""Particles on a GPU move as on processors: by numba's simulator everywhere, and on a
GPU where there is one.

Both compute the same laws in another order of sums; positions, velocities and
temperatures of a hundred steps with contacts differ by rounding, which contacts enlarge
tenfold in so many steps: 1e-11 of the largest is allowed.
"""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import contbed as cb
from contbed.dem import gpu, packing
from contbed.dem.packing import pack
from contbed.dem.particles import Material, Particles
from contbed.dem.simulation import Simulation
from contbed.dem.walls import SKIN, Domain, box
from contbed.errors import ConvergenceError, EngineError
from contbed.loading import loads
from tests.dem import gpu_scenes
from tests.imported import modules_after

ROOT = Path(__file__).parents[2]
MOTION = ("position", "velocity", "spin", "T")


def alike(one, other, tolerance=1e-11):
    for name in MOTION:
        size = np.abs(other[name]).max(initial=0.0)
        assert_allclose(
            one[name], other[name], rtol=0.0, atol=tolerance * size, err_msg=name
        )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What the simulator of a GPU found."""
    place = tmp_path_factory.mktemp("gpu")
    half = gpu_scenes.mixed("contbed")
    half.run(gpu_scenes.HALF)
    np.savez(place / "of_processor.npz", **half.state())
    # the package that this process has, and the folder of the tests
    path = os.pathsep.join([str(Path(cb.__file__).parents[1]), str(ROOT)])
    environment = os.environ | {
        "NUMBA_ENABLE_CUDASIM": "1",
        "NUMBA_DISABLE_JIT": "1",
        "PYTHONPATH": path,
    }
    command = [
        sys.executable,
        "-W",
        "ignore",
        str(ROOT / "tests/dem/gpu_without_gpu.py"),
        str(place),
    ]
    done = subprocess.run(
        command, env=environment, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return place


@pytest.fixture(scope="module")
def whole():
    """The mixed bed on a processor."""
    found = gpu_scenes.mixed("contbed")
    found.run(gpu_scenes.STEPS)
    return found


def test_the_mixed_bed_has_all_kinds_of_contacts(whole):
    start = gpu_scenes.mixed("contbed")
    record = whole._memory.read()
    assert len(whole.contacts()) > 4
    assert len(set(record.wall[record.wall_onset[:, 0] > 0])) > 2
    assert (record.entry >> 26 & 31).any()  # through the periodic sides
    # new lists were made
    assert (whole._memory.user != np.arange(len(start.position))).any()
    assert np.abs(whole.T - start.T).max() > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mixed", "went_on"])
def test_a_bed_moves_as_on_a_processor(folder, whole, name):
    """From the start, and from a checkpoint of a processor."""
    with np.load(folder / f"{name}.npz") as found:
        alike(found, whole.state())


@pytest.mark.slow
def test_a_checkpoint_goes_on_on_a_processor(folder, whole):
    again = gpu_scenes.mixed("contbed")
    with np.load(folder / "half.npz") as state:
        again.restore(dict(state))
    again.run(gpu_scenes.STEPS - gpu_scenes.HALF)
    alike(again.state(), whole.state())
    one, other = again.contacts(), whole.contacts()
    assert (one.i.tolist(), one.j.tolist(), one.since.tolist()) == (
        other.i.tolist(),
        other.j.tolist(),
        other.since.tolist(),
    )


@pytest.mark.slow
@pytest.mark.parametrize("what", ["cut", "restart", "room", "grown", "kept", "near"])
def test_nothing_depends_on_the_cut(folder, what):
    """Bit for bit: intervals and calls of any length, restarts, more room for lists,
    the state before a failure.

    And no particle is farther than half the skin from where it was listed.
    """
    with np.load(folder / "found.npz") as found:
        assert found[what]


@pytest.mark.slow
def test_what_leaves_one_particle_enters_the_other(folder):
    """Forces are opposite bit for bit; momentum and heat of unlike spheres are kept
    to the rounding of 10 sums.
    """
    start = gpu_scenes.pair("contbed")
    with np.load(folder / "pair.npz") as found:
        assert_array_equal(found["load"][0, :3], -found["load"][1, :3])
        assert np.abs(found["load"][0, :3]).max() > 0.0
        before, after = (start.mass @ v for v in (start.velocity, found["velocity"]))
        assert np.abs(after - before).max() < 10 * 2.3e-16 * start.mass @ np.abs(
            start.velocity
        ).max(axis=1)
        assert found["T"][0] < 400.0 - 1e-3
        kept = start.heat_capacity @ found["T"] / (start.heat_capacity @ start.T)
        assert kept == pytest.approx(1.0, abs=10 * 2.3e-16)


@pytest.mark.slow
def test_steps_are_halved(folder):
    wanted = gpu_scenes.stray("contbed", 2)
    wanted.run(20)
    with np.load(folder / "halved.npz") as found:
        assert found["halvings"] == wanted.halvings == 1
        alike(found, wanted.state())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "make"),
    [
        ("fast", gpu_scenes.stray),
        ("lost", gpu_scenes.leaving),
        ("through", gpu_scenes.pushed),
    ],
)
def test_failures_are_told_alike(folder, name, make):
    with pytest.raises(ConvergenceError) as error:
        make("contbed").run(400)
    assert (folder / f"{name}.txt").read_text() == str(error.value)


@pytest.mark.slow
def test_too_little_memory_is_told(folder):
    text = (folder / "memory.txt").read_text()
    assert text.startswith("15 particles take about ") and "GB are free" in text


SCENE = """
[particles.packing]
count = 70
width = ["6 mm", "6 mm"]

[solids.spheres]
diameter = "2 mm"
conductivity = 1.4
youngs_modulus = "10 MPa"
"""
LATTICE = SCENE.replace(
    "packing]\ncount = 70", 'lattice]\ntype = "sc"\ncontact_radius = "0.1 mm"'
).replace('width = ["6 mm", "6 mm"]\n', "")


@pytest.mark.parametrize(
    ("engine", "width", "periodic", "skin"),
    [
        ("cuda", 20.0, True, 0.6),
        ("cuda", 7.0, True, 1.0 / 3.0),
        ("cuda", 7.0, False, 0.6),
        ("contbed", 20.0, True, 0.1),
    ],
)
def test_lists_of_a_packing_reach_further_on_a_gpu(
    monkeypatch, engine, width, periodic, skin
):
    """In radii; periodic sides 7 radii apart leave a third of a radius beside three
    diameters.
    """
    made = {}

    def simulation(*_, **options):
        made.update(options)
        raise EngineError("no GPU")

    monkeypatch.setattr(packing, "Simulation", simulation)
    with pytest.raises(EngineError, match="no GPU"):
        pack(
            (width, width),
            radius=1.0,
            count=20,
            periodic=(periodic, periodic),
            engine=engine,
        )
    assert (made["skin"] or SKIN) == pytest.approx(skin, rel=1e-12)


def test_without_a_gpu_it_is_said(monkeypatch):
    monkeypatch.setattr(gpu, "find_spec", lambda name: None)
    with pytest.raises(EngineError, match=r"pip install 'contbed\[cuda\]'"):
        cb.run(loads(SCENE, "bed.toml"), engine="cuda")
    with pytest.raises(EngineError, match="numba-cuda"):
        pack((6e-3, 6e-3), count=20, engine="cuda")


def test_a_driver_that_is_missing_is_told(monkeypatch):
    class Nothing:
        def current_context(self):
            raise RuntimeError("\nError at driver init: \n\nno driver\n")

    monkeypatch.setattr(gpu, "find_spec", lambda name: name)
    monkeypatch.setattr("contbed.dem.gpu.arrays.cuda", Nothing())
    with pytest.raises(
        EngineError,
        match="finds no GPU that it can use: Error at driver init; no driver",
    ):
        cb.run(loads(SCENE, "bed.toml"), engine="cuda")


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (loads(LATTICE, "lattice.toml"), "this scene has none"),
        (cb.load(ROOT / "studies/moving_bed_heater/heater.toml"), "of kind"),
    ],
)
def test_scenes_without_moving_particles_are_refused(scene, words):
    with pytest.raises(
        EngineError, match=f"--engine cuda .*{words}.*leave the option out"
    ):
        cb.run(scene, engine="cuda")


def test_it_is_loaded_only_where_it_is_asked_for():
    found = modules_after("import contbed.dem.packing")
    assert not {"numba.cuda.api", "contbed.dem.gpu"} & found


def on_a_gpu():
    if find_spec("numba_cuda") is None:
        return False
    from numba import cuda

    return cuda.is_available()


@pytest.mark.skipif(not on_a_gpu(), reason="no GPU from NVIDIA with numba-cuda")
def test_a_bed_on_a_gpu():
    """4000 spheres that move: as on a processor to rounding, bit for bit from a
    restart and in a second run.
    """

    def bed(engine):
        rng = np.random.default_rng(0)
        places = np.stack(
            np.meshgrid(*[np.arange(20.0)] * 2, np.arange(10.0), indexing="ij"), -1
        ).reshape(-1, 3)
        domain = Domain((0, 0, 0), (40e-3, 40e-3, np.inf), (True, False, False))
        spheres = Particles(
            (places + 0.5) * 2e-3, 1e-3, velocity=rng.normal(0.0, 0.2, places.shape)
        )
        return Simulation(spheres, [Material()], box(domain), domain, engine=engine)

    one, again, half, own = bed("cuda"), bed("cuda"), bed("cuda"), bed("contbed")
    for found in (one, again, own):
        found.run(100, interval=100)
    half.run(37, interval=11)
    rest = bed("cuda")
    rest.restore(half.state())
    rest.run(63)
    assert len(own.contacts()) > 5000
    alike(one.state(), own.state(), 1e-10)
    for found in (again, rest):
        for name in MOTION:
            assert_array_equal(getattr(one, name), getattr(found, name), err_msg=name)

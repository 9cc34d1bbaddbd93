"""Restart of a run of particles in a gas: whenever it stopped, the rest gives what the
uncut run gives, bit for bit.

The states that a kill leaves are copies of the folder taken while the run writes.
"""

import shutil

import pytest

import contbed as cb
from contbed.cfd_dem import coupling
from contbed.cfd_dem.plan import simulation_of
from contbed.loading import loads
from contbed.output import checkpoint
from tests.refusals import refused
from tests.restarts import interrupt, same_run

SCENE = """
particles = { count = 60, width = ["8 mm", "8 mm"], height = "60 mm", modulus = "1 MPa", seed = 3 }
solids.glass = { diameter = "2 mm", density = 2500.0, conductivity = 0.84, restitution = 0.5 }
gas = { density = 1.2, viscosity = 1.8e-5, heat_capacity = 1005.0, conductivity = 0.026 }
closures.nusselt = "gunn"
boundary.bottom.gas = { velocity = 1.0, temperature = 400.0 }
heat = {}
initial.solids.glass.temperature = 300.0
time = { end = 0.04, average_from = 0.01, sample = 0.005, fields = 0.01, checkpoint_every = 1e-9 }
output = { plots = false, levels = [0.004] }
"""


def same(found, whole, folder, reference):
    same_run(found, whole)
    names = {path.name for path in reference.glob("particles*")}
    assert {path.name for path in folder.glob("particles*")} == names
    for name in names:
        assert (folder / name).read_bytes() == (reference / name).read_bytes(), name


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The uncut run, its folder, and copies of the folder just before each
    checkpoint and at the start of each.
    """
    folder, copies = tmp_path_factory.mktemp("whole"), tmp_path_factory.mktemp("killed")
    save = checkpoint.save

    def copying(*arguments):
        if (folder / checkpoint.NAME).is_file():
            shutil.copytree(folder, copies / str(len(list(copies.iterdir()))))
        save(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checkpoint, "save", copying)
        result = cb.run(loads(SCENE), out=folder)
    return result, folder, sorted(copies.iterdir(), key=lambda path: int(path.name))


def test_files_of_particles_are_written_once_for_each_time(whole):
    _, folder, _ = whole
    assert sorted(path.name for path in folder.glob("*.vtu")) == [
        f"particles_000{k}.vtu" for k in range(4)
    ]
    text = (folder / "particles.pvd").read_text()
    assert [text.count(f"particles_000{k}.vtu") for k in range(4)] == [1, 1, 1, 1]


def test_a_run_that_was_killed_between_particles_and_checkpoint_continues(
    whole, tmp_path
):
    result, folder, killed = whole
    # checkpoints after eight samples and at the end, the first without a copy
    assert len(killed) == 8
    for path in (killed[0], killed[2], killed[-1]):
        again = shutil.copytree(path, tmp_path / path.name)
        same(cb.run(loads(SCENE), restart=again), result, again, folder)


def test_a_finished_run_restarts_to_itself(whole, tmp_path):
    result, folder, _ = whole
    again = shutil.copytree(folder, tmp_path / "again")
    same(cb.run(loads(SCENE), restart=again), result, again, folder)


def test_a_run_continues_into_another_folder(whole, tmp_path):
    result, _, killed = whole
    found = cb.run(loads(SCENE), out=tmp_path, restart=killed[4])
    assert found.qoi == result.qoi and found.closures == result.closures
    listed = (tmp_path / "particles.pvd").read_text()
    for k in range(4):
        assert (f"particles_000{k}.vtu" in listed) == (
            tmp_path / f"particles_000{k}.vtu"
        ).is_file()


@pytest.mark.parametrize(
    "key", ["probes = { a = [0.004, 0.004, 0.0] }", "levels = [0.005]"]
)
def test_what_was_averaged_or_recorded_elsewhere_is_refused(whole, key, tmp_path):
    _, folder, _ = whole
    again = shutil.copytree(folder, tmp_path / "again")
    other = loads(
        SCENE.replace("plots = false, levels = [0.004]", f"plots = false, {key}")
    )
    refused(
        f"output.{key.split()[0]}.*the checkpoint has", cb.run, other, restart=again
    )


def test_a_run_that_was_interrupted_before_its_first_sample_reports(tmp_path):
    interrupt(loads(SCENE), tmp_path, coupling.Bed, "run", 1)
    assert (tmp_path / "summary.json").is_file()


def test_a_step_that_was_halved_is_told_and_restarts(tmp_path, monkeypatch):
    """The uppermost particle starts with one and a half of the speed that the step
    of the particles allows.
    """

    def thrown(*arguments):
        simulation = simulation_of(*arguments)
        simulation.velocity[simulation.position[:, 2].argmax(), 2] = (
            1.5 * 0.1 * 1e-3 / simulation.time_step
        )
        return simulation

    monkeypatch.setattr("contbed.cfd_dem.run.simulation_of", thrown)
    ends = [loads(SCENE.replace("end = 0.04", f"end = {end}")) for end in (0.02, 0.025)]
    whole = cb.run(ends[1])
    cb.run(ends[0], out=tmp_path)
    found = cb.run(ends[1], restart=tmp_path)
    assert found.qoi == whole.qoi and found.warnings == whole.warnings
    # 0.2 of the Rayleigh time is 32.6 us
    assert any(
        "was halved 1 time, to 1.63e-05 s: it resolves speeds up to 6.14 m/s" in text
        for text in whole.warnings
    )

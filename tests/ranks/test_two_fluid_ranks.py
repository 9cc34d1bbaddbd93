"""Two fluids on ranks: the state does not depend on their number, mass and heat
close, checkpoints fit any number.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from dolfinx_launch import started
from numpy.testing import assert_allclose
from two_fluid_scenes import BEDS, CHECK_CASES

from contbed.output.tables import read_table
from contbed.two_fluid.averages import OF_BED

PROGRAM = Path(__file__).with_name("two_fluid_program.py")
# after 20 steps; two numbers of ranks differ by the order of sums and by what the
# pressure equation leaves, 1e-13 of its right-hand side, which limiters multiply
TOLERANCE = 1e-10
# gas in nearly empty tetrahedra, where flux limiters switch: on one process, without
# ranks, a change of eps_s by 1e-15 becomes 4e-11 in its velocity within these steps;
# what ranks differ by is a few times that change
TOLERANCES = {"tetrahedra": 1e-9}
CONTINUED = 1e-8  # the same after some 50 steps, which multiply it further
AVERAGED = ("triangles", "heated_rectangles", "periodic", "closed")
# of the mass; each of the 20 steps rounds the content of each cell
ROUNDING = 2e-14


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory):
    """Folder with what a command of the program wrote on a number of ranks, run when
    first asked for.
    """
    done = {}

    def get(command: str, ranks: int, *arguments) -> Path:
        key = (command, ranks, *arguments)
        if key not in done:
            done[key] = tmp_path_factory.mktemp(f"{command}-{ranks}")
            finished = started(ranks, command, done[key], *arguments, program=PROGRAM)
            assert finished.returncode == 0, (
                finished.stdout[-4000:] + finished.stderr[-8000:]
            )
        return done[key]

    return get


def differences(one, other):
    """Largest difference of what cells hold, each over its largest value; of gas and
    particles over the faster one.
    """
    a, b = (
        {key.removeprefix("state."): found[key] for key in found}
        for found in (one, other)
    )
    speed = max(np.abs(a["u_gas"]).max(), np.abs(a["u_solid"]).max()) or 1.0
    s, t = a["eps_s"], b["eps_s"]
    # velocity and granular temperature of cells without particles are whatever rounding
    # leaves
    pairs = {
        "eps_s": (s, t, s.max()),
        "u_gas": (a["u_gas"], b["u_gas"], speed),
        "momentum": (
            s[:, None] * a["u_solid"],
            t[:, None] * b["u_solid"],
            s.max() * speed,
        ),
        "theta": (s * a["theta"], t * b["theta"], (s * a["theta"]).max() or 1.0),
        "p": (a["p"], b["p"], np.abs(a["p"]).max() or 1.0),
    }
    if "energy.T_gas" in a:
        # of the differences of temperature in the bed
        T, cold = (
            "energy.T_solid",
            min(a["energy.T_gas"].min(), a["energy.T_solid"].min()),
        )
        warm = max(a["energy.T_gas"].max(), a["energy.T_solid"].max()) - cold
        pairs |= {
            "T_gas": (a["energy.T_gas"], b["energy.T_gas"], warm),
            "heat_solid": (s * (a[T] - cold), t * (b[T] - cold), s.max() * warm),
            "mass": (a["energy.mass"], b["energy.mass"], a["energy.mass"].max()),
        }
    return {
        name: float(np.abs(x - y).max() / scale)
        for name, (x, y, scale) in pairs.items()
    }


@pytest.mark.parametrize("ranks", [2, 3])
@pytest.mark.parametrize("name", [*BEDS, *CHECK_CASES])
def test_ranks_agree(name: str, ranks: int, written) -> None:
    one, other = (
        np.load(written("states", count) / f"{name}.npz") for count in (1, ranks)
    )
    assert int(one["state.steps"]) == int(other["state.steps"]) == 20
    found = differences(one, other)
    assert max(found.values()) <= TOLERANCES.get(name, TOLERANCE), found
    for key in (
        key for key in one.files if key.startswith("state.counters") or key == "counts"
    ):
        assert np.array_equal(one[key], other[key]), key
    assert max(float(one["drift"]), float(other["drift"])) <= ROUNDING


@pytest.mark.parametrize(
    "name", ["rectangles", "triangles", "heated", "heated_closed", "heated_rectangles"]
)
def test_one_rank_agrees_with_the_other_engine(name: str, written) -> None:
    # other solvers: the pressure to 1e-11 there, and diffusion to 1e-7 where few cells
    # are stiff
    from contbed.loading import from_dict
    from contbed.models import plan
    from contbed.two_fluid.state import flatten

    bed, _ = plan(from_dict(BEDS[name])).bed()
    for _ in range(20):
        bed.step_towards(1e3)
    serial = flatten(bed.state)
    one = np.load(written("states", 1) / f"{name}.npz")
    found = differences(one, serial)
    assert max(found.values()) <= 1e-6, found


def rows(folder: Path):
    return np.genfromtxt(folder / "profiles.csv", delimiter=",", names=True)


@pytest.mark.parametrize(("first", "then"), [(2, 1), (2, 3), (1, 2)])
def test_checkpoint_goes_on_on_other_ranks(first: int, then: int, written) -> None:
    stopped = written("whole", first, "triangles", "0.02")
    assert (stopped / "checkpoint.npz").is_file()
    found = rows(written("resume", then, "triangles", stopped))
    expected = rows(written("whole", 1, "triangles", "0.05"))
    assert len(found) == len(expected) == 6
    for name in expected.dtype.names:
        scale = np.abs(expected[name]).max() or 1.0
        assert_allclose(
            found[name], expected[name], rtol=0.0, atol=CONTINUED * scale, err_msg=name
        )


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_averages_of_ranks_are_those_of_gathered_fields(ranks: int, written) -> None:
    folder = written("averages", ranks, *AVERAGED)
    for name in AVERAGED:
        taken, gathered = (
            np.load(folder / f"{name}.npz"),
            np.load(folder / f"{name}_gathered.npz"),
        )
        # no fields are gathered
        assert set(gathered["asked"]) == {"step_towards", "add"}
        assert taken["weight"].sum() > 0.0 and set(taken.files) == set(
            gathered.files
        ) - {"asked"}
        for key in taken.files:
            scale = np.abs(gathered[key]).max() or 1.0
            # cells have the same bits; sums over the bed are taken in another order
            allowed = ROUNDING * scale if key in OF_BED else 0.0
            assert_allclose(
                taken[key],
                gathered[key],
                rtol=0.0,
                atol=allowed,
                err_msg=f"{name} {key}",
            )


@pytest.mark.parametrize("ranks", [2, 3])
def test_averages_do_not_depend_on_the_number_of_ranks(ranks: int, written) -> None:
    for name in AVERAGED:
        one, other = (
            np.load(written("averages", count, *AVERAGED) / f"{name}.npz")
            for count in (1, ranks)
        )
        for key in one.files:
            scale = np.abs(one[key]).max() or 1.0
            assert_allclose(
                other[key],
                one[key],
                rtol=0.0,
                atol=TOLERANCE * scale,
                err_msg=f"{name} {key}",
            )


def test_pulse_of_hot_gas_ends_on_all_ranks(written) -> None:
    one, two = (rows(written("whole", ranks, "pulse", "0.05")) for ranks in (1, 2))
    drop, without = (
        found["pressure_drop_Pa"]
        for found in (one, rows(written("whole", 1, "heated", "0.05")))
    )
    # the pulse blows, and its end leaves a wider bed
    assert drop[0] > 1.5 * without[0] and drop[-1] < without[-1]
    for name in one.dtype.names:
        scale = np.abs(one[name]).max() or 1.0
        assert_allclose(
            two[name], one[name], rtol=0.0, atol=CONTINUED * scale, err_msg=name
        )


def test_results_and_files_are_those_of_one_rank(written) -> None:
    one, two = (written("whole", ranks, "triangles", "0.05") for ranks in (1, 2))
    assert {path.name for path in one.rglob("*")} == {
        path.name for path in two.rglob("*")
    }
    first, second = (
        json.loads((folder / "summary.json").read_text()) for folder in (one, two)
    )
    assert first["status"] == second["status"] == "ok"
    messages = {"messages_per_step", "message_bytes_per_step", "reductions_per_step"}
    qoi = first["qoi"], second["qoi"]
    assert qoi[0].keys() == qoi[1].keys() and messages <= qoi[0].keys()
    assert qoi[0]["messages_per_step"] == 0.0 < qoi[1]["messages_per_step"]
    assert abs(qoi[1]["mass_drift_relative"]) <= ROUNDING
    assert first["closures"] and len(first["closures"]) == len(second["closures"])


def test_a_killed_rank_ends_all_and_the_checkpoint_goes_on(
    written, tmp_path: Path
) -> None:
    done = started(2, "kill", tmp_path, "averaged", program=PROGRAM)
    assert done.returncode != 0
    assert "signal 9 (Killed)" in done.stdout + done.stderr
    assert (tmp_path / "checkpoint.npz").is_file()
    # of averages that have begun
    assert np.load(tmp_path / "checkpoint.npz")["array.weight"].any()
    expected = written("whole", 1, "averaged", "0.05")
    for ranks in (1, 3):
        found = written("resume", ranks, "averaged", tmp_path)
        for table in ("profiles", "axial", "lateral"):
            columns, wanted = (
                read_table(folder / f"{table}.csv") for folder in (found, expected)
            )
            assert columns.keys() == wanted.keys()
            for name, values in wanted.items():
                scale = np.abs(values).max() or 1.0
                assert_allclose(
                    columns[name],
                    values,
                    rtol=0.0,
                    atol=CONTINUED * scale,
                    err_msg=name,
                )


def test_more_ranks_than_cells(tmp_path: Path) -> None:
    scene = PROGRAM.parents[2] / "studies" / "two_fluid_checks" / "slip.toml"
    done = started(
        3, "run", scene, "--set", "mesh.cells=2", "--out", tmp_path, program="contbed"
    )
    assert done.returncode == 2
    assert done.stderr.count("3 ranks for a mesh of 2 cells: each rank needs one") == 1

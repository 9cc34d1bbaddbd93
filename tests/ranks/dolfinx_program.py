"""What the tests run under mpirun: `dolfinx_program.py COMMAND OUT ...`, see
`COMMANDS`.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx_scenes import SCENES

from contbed.errors import EngineError
from contbed.loading import from_dict
from contbed.many.derivatives.gradients import gradient, gradient_of
from contbed.runner import run
from tests.scene_text import changed


def found(result: Any) -> dict[str, Any]:
    """Fields, profiles, balances and named results of a run as arrays."""
    out = {
        f"nodal.{name}": np.asarray(values)
        for name, (_, values) in result.nodal.items()
    }
    out |= {
        f"series.{k}.{name}": np.asarray(values)
        for k, (_, nodal) in enumerate(result.series)
        for name, (_, values) in nodal.items()
    }
    out |= {
        f"profile.{name}": np.asarray(column)
        for name, column in result.profiles.items()
    }
    out |= {
        f"{name}.{header}": np.asarray(column)
        for name, table in result.tables.items()
        for header, column in table.items()
    }
    out |= {
        f"balance.{name}": np.array(item["relative_residual"])
        for name, item in result.balances.items()
    }
    out |= {
        f"qoi.{name}": np.array(value)
        for name, value in result.qoi.items()
        if isinstance(value, float)
    }
    for item in result.closures:
        out |= {
            f"used.{item['name']}.{k}": np.array(use["used"], float)
            for k, use in item["ranges"].items()
        }
    return out


def agree(out: Path, engine: str = "dolfinx") -> None:
    """Run all scenes."""
    for name, scene in SCENES.items():
        result = run(from_dict(scene), engine=engine)
        if result is not None:
            np.savez(out / f"{name}.npz", **found(result))


def iterate(out: Path) -> None:
    """Scenes in space without factorisations."""
    from contbed.ranks import petsc

    petsc.DIRECT_3D = 0
    for name in ("heat_tetrahedra", "heat_hexahedra"):
        result = run(from_dict(SCENES[name]), engine="dolfinx")
        if result is not None:
            np.savez(out / f"{name}.npz", **found(result))


def stop(out: Path, scene: str, after: str) -> None:
    """A transient run that is interrupted after a time [s]."""
    from contbed.output.progress import Progress

    def advance(self: Any, time: float) -> None:
        if time > float(after):
            raise KeyboardInterrupt

    Progress.advance_to = advance
    try:
        run(from_dict(SCENES[scene]), out=out, engine="dolfinx")
    except BaseException as error:
        assert "KeyboardInterrupt" in (type(error).__name__, str(error))
        return
    raise AssertionError("not interrupted")


def resume(out: Path, scene: str, folder: str) -> None:
    """Continue from the checkpoint in a folder."""
    result = run(from_dict(SCENES[scene]), restart=folder, out=out, engine="dolfinx")
    if result is not None:
        np.savez(out / "found.npz", **found(result))


def lose(out: Path, scene: str) -> None:
    """The last rank fails in the middle of an assembly."""
    from mpi4py import MPI

    from contbed.ranks import parts

    whole = parts._jacobian

    def fail(*arguments: Any) -> Any:
        if MPI.COMM_WORLD.rank == MPI.COMM_WORLD.size - 1:
            raise FloatingPointError("this rank has had enough")
        return whole(*arguments)

    parts._jacobian = fail
    run(from_dict(SCENES[scene]), engine="dolfinx")


def complain(out: Path, scene: str, key: str, value: str) -> None:
    """All ranks meet the error that ended the root rank, in a scene with one value
    changed.
    """
    tables = changed(SCENES[scene], {key: json.loads(value)})
    try:
        run(from_dict(tables), out=out, engine="dolfinx")
    except Exception as error:
        from mpi4py import MPI

        text = f"{type(error).__name__} {getattr(error, 'exit_code', None)} {error}"
        (out / f"rank{MPI.COMM_WORLD.rank}.txt").write_text(text)


def slopes(out: Path, scene: str, qoi: str, *keys: str) -> None:
    """Derivatives of a result; on all ranks, and on one rank of a run that has been
    made as well.
    """
    from mpi4py import MPI

    loaded = from_dict(SCENES[scene])
    found = gradient(loaded, [qoi], keys, engine="dolfinx")
    result = run(loaded, engine="dolfinx")
    if found is None or result is None:
        assert found is None and result is None
        return
    if MPI.COMM_WORLD.size == 1:
        assert np.array_equal(
            gradient_of(result, [qoi], keys).derivatives, found.derivatives
        )
    else:
        try:
            gradient_of(result, [qoi], keys)
        except EngineError as error:
            assert "need all of them" in str(error)
    np.savez(out / "slopes.npz", derivatives=found.derivatives, method=found.method)


COMMANDS = {
    f.__name__: f for f in (agree, iterate, stop, resume, lose, complain, slopes)
}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](Path(sys.argv[2]), *sys.argv[3:])

"""What the tests of two fluids run under mpirun: `two_fluid_program.py COMMAND OUT
...`, see `COMMANDS`.
"""

import os
import signal
import sys
from pathlib import Path
from typing import Any

import numpy as np
from two_fluid_scenes import BEDS, CHECK_CASES, CHECKS

from contbed.loading import from_dict, load
from contbed.ranks.engine import Ranks
from contbed.ranks.group import run_on_root
from contbed.ranks.two_fluid.averages import SharedAverages
from contbed.runner import run
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.momentum_budget import momentum
from contbed.two_fluid.results import balances, contents

STEPS = 20


def loaded(name: str) -> Any:
    """The scene of a check case or bed."""
    return from_dict(BEDS[name]) if name in BEDS else load(CHECKS / f"{name}.toml")


def states(out: Path, *names: str) -> None:
    """State of beds after STEPS steps, and the largest share of mass or heat that is
    not accounted for.
    """
    for name in names or (*BEDS, *CHECK_CASES):

        def main(name: str = name) -> None:
            bed, compiled = Ranks().plan(loaded(name)).bed()
            start = contents(bed)
            for _ in range(STEPS):
                bed.step_towards(1e3)
            open_shares = [
                abs(balance["relative_residual"])
                for balance in balances(bed, start).values()
            ]
            np.savez(
                out / f"{name}.npz",
                **bed.saved(),
                drift=max(open_shares),
                counts=np.concatenate(compiled.counts),
            )

        run_on_root(main)


def averages(out: Path, *names: str) -> None:
    """Averages by rank over the last steps, those of the fields that the first rank
    gathers, and what it asked for.
    """
    for name in names:

        def main(name: str = name) -> None:
            bed, _ = Ranks().plan(loaded(name)).bed()
            for _ in range(STEPS // 2):
                bed.step_towards(1e3)
            window = bed.clock.time * (1.0 + 1e-9), 4.0 * bed.clock.time
            gathered = Averages(*window, momentum=momentum(bed))
            taken = SharedAverages(bed, *window)
            asked, run = [], bed.shared.run
            for _ in range(STEPS // 2):
                bed.shared.run = lambda function, *more, **root: (
                    asked.append(function.__name__) or run(function, *more, **root)
                )
                bed.step_towards(1e3)
                taken.add(bed)
                del bed.shared.run
                gathered.add(bed)
            np.savez(out / f"{name}.npz", **taken.whole().arrays())
            np.savez(out / f"{name}_gathered.npz", **gathered.arrays(), asked=asked)

        run_on_root(main)


def whole(out: Path, name: str, end: str) -> None:
    """A run with its files until `end` [s]."""
    time = BEDS[name]["time"] | {"end": float(end)}
    run(
        from_dict(BEDS[name] | {"time": time, "output": {"plots": False}}),
        out=out,
        engine="dolfinx",
    )


def resume(out: Path, name: str, folder: str) -> None:
    """The same scene continued to its own end from the checkpoint in a folder."""
    run(loaded(name), restart=folder, out=out, engine="dolfinx")


def kill(out: Path, name: str) -> None:
    """The last rank is killed in the middle of a run."""
    from mpi4py import MPI

    from contbed.two_fluid.simulation import Simulation

    step = Simulation.step

    def dying(self: Simulation, dt: float) -> None:
        if self.state.time > 0.02 and MPI.COMM_WORLD.rank == MPI.COMM_WORLD.size - 1:
            os.kill(os.getpid(), signal.SIGKILL)
        step(self, dt)

    Simulation.step = dying
    scene = from_dict(
        BEDS[name] | {"time": BEDS[name]["time"] | {"checkpoint_every": 1e-9}}
    )
    run(scene, out=out, engine="dolfinx")


COMMANDS = {f.__name__: f for f in (states, averages, whole, resume, kill)}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](Path(sys.argv[2]), *sys.argv[3:])

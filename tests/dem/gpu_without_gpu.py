"""Kernels of a GPU computed by numba's simulator, in a process of its own: one thread
of Python for each of theirs.

    NUMBA_ENABLE_CUDASIM=1 NUMBA_DISABLE_JIT=1 python tests/dem/gpu_without_gpu.py FOLDER

writes what `test_gpu.py` compares with processors. The simulator knows no limit of
registers, one block of a grid whose blocks meet, and columns of tables only as
attributes of record arrays.
"""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numba import cuda

with_registers = cuda.jit
cuda.jit = lambda *arguments, max_registers=0, **options: with_registers(
    *arguments, **options
)

from contbed.dem import gpu, simulation  # noqa: E402
from contbed.dem.contact_heat import ContactHeat  # noqa: E402
from contbed.dem.gpu import memory  # noqa: E402
from contbed.errors import ConvergenceError, EngineError  # noqa: E402
from tests.dem import gpu_scenes  # noqa: E402


def with_columns(tabulate):
    """Let the columns of tables be attributes."""
    return lambda *given: tabulate(*given).view(np.recarray)


simulation.wall_table = with_columns(simulation.wall_table)
simulation.pair_table = with_columns(simulation.pair_table)
ContactHeat.table = with_columns(ContactHeat.table)
memory.THREADS, memory.resident_blocks, gpu.require_gpu = 3, lambda: 1, lambda: None


def bits(first, second):
    """Whether two simulations are alike, bit for bit."""
    one, other = first.state(), second.state()
    return all(one[name].tobytes() == other[name].tobytes() for name in one)


def main(folder):
    whole = gpu_scenes.mixed("cuda")
    whole.run(gpu_scenes.STEPS, interval=gpu_scenes.STEPS)
    np.savez(folder / "mixed.npz", **whole.state())
    # cut into intervals, and into calls of a few steps
    memory.SENT = 7 * len(whole.position)
    cut = gpu_scenes.mixed("cuda")
    cut._memory.longest = 10
    cut.run(gpu_scenes.HALF, interval=13)
    np.savez(folder / "half.npz", **cut.state())
    memory.SENT = 100_000_000
    again = gpu_scenes.mixed("cuda")
    again.restore(cut.state())
    for bed in (cut, again):
        bed.run(gpu_scenes.STEPS - gpu_scenes.HALF, interval=29)
    found = {"cut": bits(whole, cut), "restart": bits(whole, again)}
    listed = np.empty_like(whole.position)
    listed[whole.state()["user"]] = whole.state()["listed"]
    found["near"] = (
        np.linalg.norm(whole.position - listed, axis=1).max() <= 0.5 * whole.skin
    )
    # goes on from a processor
    with np.load(folder / "of_processor.npz") as state:
        other = gpu_scenes.mixed("cuda")
        other.restore(dict(state))
    other.run(gpu_scenes.STEPS - gpu_scenes.HALF)
    np.savez(folder / "went_on.npz", **other.state())
    # little room for neighbours at the start
    memory.ROOM = 1
    tight = gpu_scenes.mixed("cuda")
    memory.ROOM = 16
    tight.run(20)
    roomy = gpu_scenes.mixed("cuda")
    roomy.run(20)
    found["room"] = bits(tight, roomy) and tight._memory._room > 1
    # and as little in the middle of a run as there are neighbours
    full, free = gpu_scenes.mixed("cuda"), gpu_scenes.mixed("cuda")
    store = full._memory
    record, least = store.read(), int(store._lists[0].neighbours.copy_to_host().max())
    store._room = least
    store._allocate()
    store.write(record)
    for bed in (full, free):
        bed.run(gpu_scenes.HALF)
    found["grown"] = bits(full, free) and store._room > least
    context = cuda.current_context()
    cuda.current_context = lambda: SimpleNamespace(get_memory_info=lambda: (1e4, 1e4))
    try:
        gpu_scenes.mixed("cuda")
    except EngineError as error:
        (folder / "memory.txt").write_text(str(error))
    cuda.current_context = lambda: context
    pair = gpu_scenes.pair("cuda")
    pair.run(10)
    np.savez(folder / "pair.npz", **pair.state(), T_start=gpu_scenes.pair("cuda").T)
    fast = gpu_scenes.stray("cuda", 0)
    before = fast.state()
    try:
        fast.run(20)
    except ConvergenceError as error:
        (folder / "fast.txt").write_text(str(error))
    found["kept"] = all(
        before[name].tobytes() == fast.state()[name].tobytes() for name in before
    )
    halved = gpu_scenes.stray("cuda", 2)
    halved.run(20)
    np.savez(folder / "halved.npz", **halved.state(), halvings=halved.halvings)
    for name, make in (("lost", gpu_scenes.leaving), ("through", gpu_scenes.pushed)):
        try:
            make("cuda").run(400)
        except ConvergenceError as error:
            (folder / f"{name}.txt").write_text(str(error))
    np.savez(folder / "found.npz", **found)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

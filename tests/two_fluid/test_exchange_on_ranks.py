"""Implicit exchange on parts of a grid, each in a thread that stands for a rank."""

import queue
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from test_parts_of_ranks import GRIDS

from contbed.ranks.two_fluid.cg import solve_on_ranks
from contbed.ranks.two_fluid.division import Division
from contbed.two_fluid.fv import grid
from contbed.two_fluid.fv.connections import connect
from contbed.two_fluid.linear.cg import System, solve

EXPLICIT, TOLERANCE, MOST = 0.1, 1e-9, 500
# the sums of ranks are taken in another order
ROUNDING = 1e-14


class Communicator:
    """What the halo needs of MPI, between threads."""

    def __init__(self, rank: int, shared: SimpleNamespace):
        self.rank, self.shared = rank, shared

    def Isend(self, values, to):
        self.shared.mail[self.rank, to].put(values.copy())
        return SimpleNamespace(Wait=lambda: None)

    def Irecv(self, values, sender):
        mail = self.shared.mail[sender, self.rank]
        return SimpleNamespace(Wait=lambda: np.copyto(values, mail.get(timeout=60)))

    def allreduce(self, value, operation):
        return max(self._of_all(value))

    def Allreduce(self, mine, everywhere):
        everywhere[:] = sum(self._of_all(mine))

    def _of_all(self, value):
        self.shared.values[self.rank] = value
        self.shared.barrier.wait(60)
        found = list(self.shared.values)
        self.shared.barrier.wait(60)
        return found


def solved(part, whole_system, comm):
    on = part.shared_grid(comm)
    coef, links, *of_cells = whole_system
    cells = (values[part.cells] for values in (links, *of_cells))
    x = np.empty((len(part.cells), coef.shape[1]))
    system = System(coef[part.faces], *cells)
    return solve_on_ranks(on, system, EXPLICIT, TOLERANCE, MOST, x), x


@pytest.mark.parametrize("size", [1, 3])
@pytest.mark.parametrize(
    "name", ["rectangles", "triangles", "periodic triangles", "one cell around"]
)
def test_ranks_take_the_iterations_of_one(name, size, monkeypatch):
    """Stiff cells beside others, so that not all are solved for."""
    monkeypatch.setitem(sys.modules, "mpi4py", SimpleNamespace(MPI=SimpleNamespace()))
    monkeypatch.setattr(sys.modules["mpi4py"].MPI, "MAX", max, raising=False)
    mesh, periodic = GRIDS[name]()
    whole, division = grid.build(mesh, periodic), Division.of(connect(mesh, periodic))
    count, random = len(whole.cells), np.random.default_rng(3)
    coef = 3.0 * random.random((whole.face_count, 2))
    coef[random.random(len(coef)) < 0.7] *= 1e-3
    content, rhs = 0.5 + random.random((count, 2)), random.normal(size=(count, 2))
    system = System(coef, np.zeros((count, 2)), content, rhs)
    expected, links = np.empty((count, 2)), np.zeros((count, 2))
    iterations = solve(
        whole.geometry,
        system._replace(links=links),
        EXPLICIT,
        TOLERANCE,
        MOST,
        expected,
    )
    assert iterations > 3
    quiet = ~(links > EXPLICIT * content).any(axis=1)
    assert quiet.any() or name == "one cell around"
    height = whole.centres[:, -1] / whole.middles[:, -1].max()
    owner = np.minimum((height * size).astype(np.int64), size - 1)
    parts = [share.part() for share in division.split(owner, size)]
    shared = SimpleNamespace(
        mail={(a, b): queue.Queue() for a in range(size) for b in range(size)},
        values=[None] * size,
        barrier=threading.Barrier(size),
    )
    found = {}

    def work(part):
        found[part.rank] = solved(part, system, Communicator(part.rank, shared))

    threads = [threading.Thread(target=work, args=(part,)) for part in parts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    scale = np.abs(expected).max()
    for part in parts:
        taken, x = found[part.rank]
        assert taken == iterations
        np.testing.assert_allclose(
            x, expected[part.cells], rtol=0.0, atol=ROUNDING * scale
        )

"""Ghost cells of one rank, exchanged by messages between neighbouring ranks, and reductions over all ranks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Flags, Indices
from contbed.two_fluid.fv.halo import Halo


class Neighbour(NamedTuple):
    """Another rank, the own cells that it needs, and the ghost cells here that it owns; both in its order and ours."""

    rank: int
    sent: Indices
    received: Indices


class RankHalo(Halo):
    """The halo of one rank's part.

    Attributes
    ----------
    messages, bytes, reductions : counted since the start; of messages those that this rank sent
    """

    distributed = True

    def __init__(
        self, comm: Any, owned: int, near: int, faces: Flags, edges: Flags, neighbours: Sequence[Neighbour]
    ) -> None:
        self.comm, self.neighbours = comm, neighbours
        self.cells, self.near, self.faces, self.edges = slice(0, owned), near, faces, edges
        self.messages = self.bytes = self.reductions = 0

    def exchange(self, *fields: np.ndarray) -> None:
        """Set the ghost cells of fields (nc, ...); one message to each neighbour holds all of them."""
        if not fields:
            return
        widths = [field[:1].size for field in fields]
        inbox = [np.empty(len(other.received) * sum(widths)) for other in self.neighbours]
        pending = [self.comm.Irecv(buffer, other.rank) for buffer, other in zip(inbox, self.neighbours, strict=True)]
        for other in self.neighbours:
            outbox = np.concatenate([field[other.sent].ravel() for field in fields], dtype=float)
            pending.append(self.comm.Isend(outbox, other.rank))
            inbox.append(outbox)  # kept until it has been sent
            self.messages += 1
            self.bytes += outbox.nbytes
        for request in pending:
            request.Wait()
        for buffer, other in zip(inbox, self.neighbours, strict=False):
            start = 0
            for field, width in zip(fields, widths, strict=True):
                end = start + width * len(other.received)
                field[other.received] = buffer[start:end].reshape(-1, *field.shape[1:])
                start = end

    def max(self, value: float) -> float:
        """Return the largest value of all ranks."""
        from mpi4py import MPI

        self.reductions += 1
        return float(self.comm.allreduce(float(value), MPI.MAX))

    def any(self, found: bool) -> bool:
        """Return whether any rank has found something."""
        return self.max(float(found)) > 0.0

    def sum(self, *values: float) -> Sequence[float]:
        """Return the sum over all ranks of each value."""
        mine, everywhere = np.array(values, dtype=float), np.empty(len(values))
        self.reductions += 1
        self.comm.Allreduce(mine, everywhere)
        return [float(value) for value in everywhere]

    def first(self, message: str) -> str:
        """Return the message of the first rank that has one; empty if none has."""
        if not self.any(bool(message)):
            return ""
        return next(str(text) for text in self.comm.allgather(message) if text)

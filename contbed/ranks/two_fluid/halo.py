"""Ghost cells of one rank, exchanged by messages between neighbouring ranks, and
reductions over all ranks.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from contbed.two_fluid.compiled import Flags, Indices
from contbed.two_fluid.fv.halo import Halo


class Neighbour(NamedTuple):
    """Another rank, the own cells that it needs, and the ghost cells here that it
    owns; both in its order and ours.
    """

    rank: int
    sent: Indices
    received: Indices


@dataclass
class Traffic:
    """Messages and bytes that a rank has sent, and reductions over all ranks,
    counted since the start.
    """

    messages: int = 0
    bytes: int = 0
    reductions: int = 0


class RankHalo(Halo):
    """The halo of one rank's part, or of the cells of it that are solved for, with
    `traffic` counted together.
    """

    distributed = True

    def __init__(
        self,
        comm: Any,
        owned: int,
        near: int,
        faces: Flags,
        edges: Flags,
        neighbours: Sequence[Neighbour],
    ) -> None:
        self.comm, self.neighbours, self.traffic = comm, neighbours, Traffic()
        self.cells, self.near, self.faces, self.edges = (
            slice(0, owned),
            near,
            faces,
            edges,
        )

    def of_numbered(self, number: Indices) -> RankHalo:
        """Return the halo of the cells with a `number` (nc,), not -1, by that
        number; own ones come first.
        """
        part = copy(self)
        part.neighbours = []
        for other in self.neighbours:
            sent, received = number[other.sent], number[other.received]
            part.neighbours.append(
                Neighbour(other.rank, sent[sent >= 0], received[received >= 0])
            )
        return part

    def exchange(self, *fields: np.ndarray) -> None:
        """Set the ghost cells of fields (nc, ...); one message to each neighbour
        holds all of them.
        """
        if not fields:
            return
        widths = [field[:1].size for field in fields]
        senders = [other for other in self.neighbours if len(other.received)]
        inbox = [np.empty(len(other.received) * sum(widths)) for other in senders]
        pending = [
            self.comm.Irecv(buffer, other.rank)
            for buffer, other in zip(inbox, senders, strict=True)
        ]
        outboxes = []  # kept until they have been sent
        for other in self.neighbours:
            if not len(other.sent):
                continue
            outboxes.append(
                np.concatenate(
                    [field[other.sent].ravel() for field in fields], dtype=float
                )
            )
            pending.append(self.comm.Isend(outboxes[-1], other.rank))
            self.traffic.messages += 1
            self.traffic.bytes += outboxes[-1].nbytes
        for request in pending:
            request.Wait()
        for buffer, other in zip(inbox, senders, strict=True):
            start = 0
            for field, width in zip(fields, widths, strict=True):
                end = start + width * len(other.received)
                field[other.received] = buffer[start:end].reshape(-1, *field.shape[1:])
                start = end

    def max(self, value: float) -> float:
        """Return the largest value of all ranks."""
        from mpi4py import MPI

        self.traffic.reductions += 1
        return float(self.comm.allreduce(float(value), MPI.MAX))

    def any(self, found: bool) -> bool:
        """Return whether any rank has found something."""
        return self.max(float(found)) > 0.0

    def sum(self, *values: float) -> Sequence[float]:
        """Return the sum over all ranks of each value."""
        mine, everywhere = np.array(values, dtype=float), np.empty(len(values))
        self.traffic.reductions += 1
        self.comm.Allreduce(mine, everywhere)
        return [float(value) for value in everywhere]

    def first(self, message: str) -> str:
        """Return the message of the lowest rank that has one; empty if none has."""
        if not self.any(bool(message)):
            return ""
        return next(str(text) for text in self.comm.allgather(message) if text)

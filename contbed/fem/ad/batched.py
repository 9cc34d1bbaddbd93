"""Residuals and Jacobians of pointwise forms from graphs that are recorded once and
evaluated at any state.

A form with dozens of unknowns and closures takes thousands of small operations on dual
numbers. Recorded (`ad.graph`) each operation is done once, and the derivatives follow
by eliminating the inner operations in an order found once (`ad.elimination`), for all
cells and in batches. All coefficients are then contracted with the basis tables
together.

What changes a form other than its unknowns, such as another coefficient, needs a new
recording. Its plan (`ad.plan`) depends on the operations alone, not on their numbers:
forms with other numbers share it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp

from contbed.arrays import Array
from contbed.fem.ad.graph import LEAVES, Graph, recorded
from contbed.fem.ad.plan import planned, structure
from contbed.fem.domain import Domain
from contbed.fem.skfem import Form, Ops, System, _Unknown

Step = Callable[[], Any]  # fills a row from others
# points that are differentiated together: their rows stay in the cache of a core
POINTS = 64


def _choose(condition: Array, yes: Array, no: Array, out: Array) -> None:
    np.copyto(out, np.where(condition != 0.0, yes, no))


def _tabulate(function: Callable[[Array], Array], argument: Array, out: Array) -> None:
    np.copyto(out, function(argument))


def _slope(
    rule: Callable[..., Any],
    which: int,
    operands: tuple[Array, ...],
    value: Array,
    out: Array,
) -> None:
    """Put the derivative of an operation to one of its operands into `out`."""
    found = rule(*operands, value)
    np.copyto(out, found[which] if isinstance(found, tuple) else found)


class Program:
    """Values and derivatives of the results of a graph at the points of one domain,
    `shape` (cells, points of each).

    Attributes
    ----------
    slots : (name, component, kind) of the unknowns that are read; `rows` begins with
        them
    derivatives : (number of the result, number of the slot, row) of all that are not
        zero everywhere

    """

    def __init__(self, graph: Graph, results: Sequence[int], shape: tuple[int, int]):
        self._graph, self._shape = graph, shape
        self._plan = plan = planned(structure(graph, results))
        self.slots, self.derivatives = plan.slots, plan.derivatives
        self._rows = np.zeros((plan.minus + 1 + len(plan.slopes), shape[0] * shape[1]))
        self._rows[plan.one], self._rows[plan.minus] = 1.0, -1.0
        self._steps = self._value_steps()
        self._slope_steps = [
            partial(
                self._rule(rule, node),
                which,
                tuple(self._rows[r] for r in rows),
                self._rows[plan.row[node]],
                out,
            )
            for out, (rule, which, rows, node) in zip(
                self._rows[plan.minus + 1 :], plan.slopes, strict=True
            )
        ]

    def set_parameter(self, value: float) -> None:
        """Evaluate for another value of the parameter from now on."""
        if self._plan.parameter is not None:
            self._rows[self._plan.parameter] = value

    def values(self, slots: Array) -> Array:
        """Return the results (number, cells, points of each) where the slots have
        values (number, points).
        """
        self._rows[: len(slots)] = slots
        for step in self._steps:
            step()
        return self._rows[self._plan.results].reshape(-1, *self._shape)

    def slopes(self) -> Array:
        """Return the `derivatives` (number, cells, points of each) where `values`
        was called last.
        """
        for step in self._slope_steps:
            step()
        wanted = [row for *_, row in self.derivatives]
        base, points = self._rows.shape
        out = np.empty((len(wanted), points))
        for first in range(0, points, POINTS):
            part = slice(first, min(first + POINTS, points))
            work = np.empty((self._plan.size, part.stop - part.start))
            work[:base] = self._rows[:, part]
            for batch in self._plan.batches:
                batch.evaluate(work)
            out[:, part] = work[wanted]
        return out.reshape(-1, *self._shape)

    def _rule(self, rule: Callable[..., Any] | None, node: int) -> Callable[..., Any]:
        """Return what computes a derivative of a node; that of a table is the
        function which the table was given.
        """
        if rule is not None:
            return partial(_slope, rule)
        derivative = self._graph.operands[node][1]
        return partial(_slope, lambda argument, value: derivative(argument))

    def _value_steps(self) -> list[Step]:
        """Return what computes the values that depend on unknowns; all others are
        put into their rows here.
        """
        graph, plan, rows, varying = self._graph, self._plan, self._rows, set()
        steps: list[Step] = []
        for node in plan.live:
            operation = graph.operations[node]
            operands = graph.operands[node]
            out = rows[plan.row[node]]
            if operation in ("slot", "parameter"):
                varying.add(node)
                continue
            if operation in LEAVES:
                out[:] = (
                    np.broadcast_to(operands[0], self._shape).ravel()
                    if operation == "array"
                    else operands[0]
                )
                continue
            values = [rows[plan.row[k]] for k in plan.operands[node]]
            functions: dict[Any, Any] = {
                "where": _choose,
                "table": partial(_tabulate, operands[0]),
                "frozen": np.positive,
            }
            step = partial(functions.get(operation, operation), *values, out=out)
            if varying.isdisjoint(plan.operands[node]):
                step()
            else:
                varying.add(node)
                steps.append(step)
        return steps


class RecordedForm:
    """A form on one domain of a system, recorded; its element vectors and matrices at
    any state.

    Attributes
    ----------
    program : values and derivatives of the coefficients of its tests
    keys : (row, column, domain) of each element matrix, as `System.pattern` takes them
    dofs : numbers of the unknowns of all element vectors, one after another

    Raises
    ------
    NotRecordableError : the form is no fixed sequence of operations

    """

    def __init__(
        self,
        system: System,
        form: Form,
        where: Domain,
        coeffs: Any,
        graph: Graph | None = None,
    ):
        self._system, self._where = system, where
        graph = graph or Graph()
        coefficients = recorded(graph, system, form, coeffs, Ops(where))
        # (name, component, kind) by the number of the result
        tests = list(coefficients)
        self.program = Program(
            graph, [node.place for node in coefficients.values()], where.weight.shape
        )
        self._fields = _Groups(
            (self._space(slot), slot[2], slot[:2]) for slot in self.program.slots
        )
        self._rows = _Groups((self._space(test), test[2], test[:2]) for test in tests)
        self._pairs = _Groups(
            (
                (self._space(tests[result]), self._space(slot)),
                (tests[result][2], slot[2]),
                (tests[result][:2], slot[:2]),
            )
            for result, place, _ in self.program.derivatives
            for slot in [self.program.slots[place]]
        )
        self.keys = [
            (row, column, where)
            for pairs in self._pairs.members.values()
            for row, column in pairs
        ]
        numbers = [
            space.dofs[:, where.cells].T.ravel() + system.offset[key]
            for space, keys in self._rows.members.items()
            for key in keys
        ]
        self.dofs = np.concatenate([np.empty(0, dtype=np.int64), *numbers])

    def _space(self, slot: Any) -> Any:
        return self._system.fields[slot[0]][0]

    def vectors(self, state: Array) -> Array:
        """Return all element vectors at a state, one after another, as `dofs` has
        them.
        """
        where = self._where
        slots = np.empty((len(self.program.slots), *where.weight.shape))
        for (space, kind), (numbers, places) in self._fields.parts.items():
            starts = np.array(
                [self._system.offset[key] for key in self._fields.members[space]]
            )[places]
            local = state[starts[:, None, None] + space.dofs[:, where.cells].T]
            found = _Unknown(where, space, local, None)
            slots[numbers] = found.value if kind == "v" else found.slot(kind).value
        values = (
            self.program.values(slots.reshape(len(slots), where.weight.size))
            * where.weight
        )
        out = {
            space: np.zeros((len(keys), where.weight.shape[0], len(space.dofs)))
            for space, keys in self._rows.members.items()
        }
        for (space, kind), (numbers, places) in self._rows.parts.items():
            for reference, c in where.to_reference({kind: values[numbers]}).items():
                out[space][places] += c @ where.table(space, reference).T
        return np.concatenate([np.empty(0), *(local.ravel() for local in out.values())])

    def matrices(self) -> list[Array]:
        """Return all element matrices where `vectors` was called last, one after
        another, as `keys` has them.
        """
        where = self._where
        slopes = self.program.slopes() * where.weight
        out = {
            (test, trial): np.zeros(
                (len(pairs), where.weight.shape[0], len(test.dofs) * len(trial.dofs))
            )
            for (test, trial), pairs in self._pairs.members.items()
        }
        for ((test, trial), (row, column)), (
            numbers,
            places,
        ) in self._pairs.parts.items():
            for test_kind, by_test in where.to_reference(
                {row: slopes[numbers]}
            ).items():
                for trial_kind, c in where.to_reference({column: by_test}).items():
                    out[test, trial][places] += c @ where.pair_table(
                        test, test_kind, trial, trial_kind
                    )
        return [local for group in out.values() for local in group]


class _Groups:
    """Coefficients of the same space and kind, which are contracted with the same
    table.

    Attributes
    ----------
    members : by space, what coefficients of any kind belong to, each once
    parts : by (space, kind), the numbers of the coefficients and the places of what
        they belong to among the members

    """

    def __init__(self, items: Iterable[tuple[Any, Any, Any]]):
        self.members: dict[Any, dict[Any, int]] = {}
        found: dict[Any, list[tuple[int, int]]] = {}
        for number, (space, kind, key) in enumerate(items):
            known = self.members.setdefault(space, {})
            found.setdefault((space, kind), []).append(
                (number, known.setdefault(key, len(known)))
            )
        self.parts = {
            key: tuple(np.array(pairs, dtype=np.intp).T) for key, pairs in found.items()
        }


class RecordedForms:
    """The sum of recorded forms of a system; raises NotRecordableError where one cannot
    be recorded.

    Where coefficients depend on the parameter of a `graph`, the forms are recorded
    there, and hold for any value of it.
    """

    def __init__(
        self,
        system: System,
        forms: Sequence[tuple[Form, Domain, Any]],
        graph: Graph | None = None,
    ):
        self._system = system
        # a branch that no state takes may have no value
        with np.errstate(all="ignore"):
            self._forms = [RecordedForm(system, *form, graph) for form in forms]
        self._dofs = np.concatenate([form.dofs for form in self._forms])
        keys = [key for form in self._forms for key in form.keys]
        parts, self._indices, self._indptr = system.pattern(keys)
        places: list[Any] = [None] * len(keys)
        for numbers, position, place in parts:
            sizes = [self._entries(keys[k]) for k in numbers]
            for k, found in zip(
                numbers, np.split(place[position], np.cumsum(sizes)[:-1]), strict=True
            ):
                places[k] = found
        self._places = np.concatenate([np.empty(0, dtype=np.int32), *places])

    def set_parameter(self, value: float) -> None:
        """Assemble for another value of the parameter from now on."""
        for form in self._forms:
            form.program.set_parameter(value)

    def _entries(self, key: Any) -> int:
        row, column, where = key
        test, trial = (self._system.fields[name][0] for name, _ in (row, column))
        return len(where.weight) * len(test.dofs) * len(trial.dofs)

    def assemble(
        self, state: Array, jacobian: bool
    ) -> tuple[Array, sp.csc_matrix | None]:
        """Assemble the residual and, if wanted, the Jacobian, as `System.assemble`
        does.
        """
        size = self._system.size
        vectors = np.concatenate([form.vectors(state) for form in self._forms])
        residual = np.asarray(
            np.bincount(self._dofs, weights=vectors, minlength=size), dtype=float
        )
        if not jacobian:
            return residual, None
        matrices = np.concatenate(
            [
                np.empty(0),
                *(local.ravel() for form in self._forms for local in form.matrices()),
            ]
        )
        data = np.bincount(self._places, weights=matrices, minlength=len(self._indices))
        return residual, sp.csc_matrix(
            (data, self._indices, self._indptr), shape=(size, size)
        )

"""Manufactured solutions: known fields are inserted into a model's own residual, and
the error must fall at its order.

    exact = {"T_fluid": lambda x, y: 2 + np.sin(x) * y, "T_solid": lambda x, y: 2 + x * y}
    case = Manufactured(system, exact, [(two_energy.residual, system.cells, coefficients)])
    state = case.solve({"T_fluid": facets, "T_solid": facets}, policy)
    case.errors(state)                                                        # {"T_fluid": ..., "T_solid": ...}

The equations get the load vector R(exact), the residual with the exact values,
gradients and second derivatives at all quadrature points, so that no source is derived
by hand and the conditions on the rest of the boundary are consistent. The derivatives
come from `ad.dual`. This cannot detect a wrong sign that both sides share: `jet` gives
the strong form for that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contbed.fem.ad.dual import Components, Dual
from contbed.fem.domain import Domain
from contbed.fem.elements import lagrange
from contbed.fem.skfem import System
from contbed.solvers.linear import Policy
from contbed.solvers.newton import Options, newton

Array = NDArray[np.float64]
Function = Callable[..., Any]


def observed_order(errors: ArrayLike, sizes: ArrayLike) -> Array:
    """Return the exponent p of error = C size^p between neighbours of a sequence.

    Parameters
    ----------
    errors : (n,) > 0, sizes : (n,) > 0, cell sizes or time steps

    Returns
    -------
    (n - 1,)
    """
    order: Array = np.diff(np.log(np.asarray(errors, dtype=float))) / np.diff(
        np.log(np.asarray(sizes, dtype=float))
    )
    return order


def jet(function: Function, x: Sequence[Array]) -> tuple[Any, list[Any]]:
    """Return a scalar function of the coordinates and its gradient, both as dual
    numbers over the coordinates.

    Slot k of their tangents is the derivative along coordinate k, so that fluxes made
    of them can be differentiated.

    Parameters
    ----------
    function : of `len(x)` coordinates, in numpy functions
    x : coordinates, arrays of one shape

    Returns
    -------
    value, [its derivative along each coordinate]
    """
    twice = [Dual(Dual(array, {k: 1.0}), {k: 1.0}) for k, array in enumerate(x)]
    result = function(*twice)
    nothing = np.zeros_like(x[0])
    zero = Dual(nothing, dict.fromkeys(range(len(x)), nothing))
    slopes = getattr(result, "tangents", {})
    return zero + getattr(result, "value", result), [
        zero + slopes.get(k, 0.0) for k in range(len(x))
    ]


class Exact(Dual):
    """A scalar function of the coordinates as a form sees an unknown, with its
    derivatives and linear interpolant.
    """

    __slots__ = ("_corners", "_gradient")

    def __init__(self, function: Function, mesh: Any, where: Domain):
        value, self._gradient = jet(function, where.x.items)
        corners = mesh.p[:, mesh.t[:, where.cells]]
        nodal = np.broadcast_to(function(*corners), corners.shape[1:])
        self._corners = nodal.T @ lagrange(where.refdom, 1).table(where.X)
        super().__init__(value.value, {})

    def slot(self, kind: Any) -> Dual:
        """Return one slot: "v", ("g", k), ("h", k, m) or "low"."""
        if kind == "v":
            return Dual(self.value, {})
        if kind == "low":
            return Dual(self._corners, {})
        along = self._gradient[kind[1]]
        return Dual(along.value if kind[0] == "g" else along.tangents[kind[2]], {})


def exact(function: Function, mesh: Any, where: Domain) -> Any:
    """Return a function of the coordinates on a domain as `Exact`; Components of
    them where it returns a tuple.
    """
    sample = function(*mesh.p[:, :1])
    if not isinstance(sample, tuple):
        return Exact(function, mesh, where)
    return Components(
        Exact(lambda *x, k=k: function(*x)[k], mesh, where) for k in range(len(sample))
    )


@dataclass(frozen=True)
class Manufactured:
    """Exact fields of a system, and the forms whose sum vanishes for them with the
    right load.

    Parameters
    ----------
    system : unknowns and mesh
    fields : for each unknown a function of the coordinates; it returns a tuple for a
        vector
    forms : (form, domain, coefficients), as `System.assemble` takes them
    """

    system: System
    fields: Mapping[str, Function]
    forms: Sequence[tuple[Any, Domain, Any]]

    def load(self) -> Array:
        """Assemble the residual of the exact fields."""
        known = [
            (self._known(form, where), where, coeffs)
            for form, where, coeffs in self.forms
        ]
        return self.system.assemble(known, np.zeros(self.system.size), False)[0]

    def _known(self, form: Any, where: Domain) -> Any:
        fields = {
            name: exact(function, self.system.mesh, where)
            for name, function in self.fields.items()
        }
        return lambda unknowns, tests, coeffs, ops: form(
            SimpleNamespace(**fields), tests, coeffs, ops
        )

    def interpolant(self) -> Array:
        """Return the state with exact values at all nodes."""
        state = np.empty(self.system.size)
        for name, function in self.fields.items():
            values = function(*self.system.fields[name][0].points)
            self.system.part(state, name)[:] = (
                np.array(values) if isinstance(values, tuple) else values
            )
        return state

    def solve(
        self, fixed: Mapping[str, Any], policy: Policy, linear: bool = False
    ) -> Array:
        """Solve from the exact values, which are kept on the given facets of each
        field in `fixed`.
        """
        system, load = self.system, self.load()
        nodes = [
            system.nodes(name, facets, k)
            for name, facets in fixed.items()
            for k in range(max(system.fields[name][1], 1))
        ]

        def assemble(state: Array, jacobian: bool) -> tuple[Any, Any]:
            residual, matrix = system.assemble(list(self.forms), state, jacobian)
            return residual - load, matrix

        start = self.interpolant()
        fixed_nodes = np.unique(np.concatenate(nodes))
        state: Array
        state, _ = newton(
            assemble, start, fixed_nodes, policy, Options(tolerance=1e-8), linear
        )
        return state

    def errors(self, state: Array) -> dict[str, float]:
        """Return the L2 norm of each field's error, by quadrature exact for the
        square of its leading term.
        """
        system = self.system
        degree = max(space.degree for space, _ in system.fields.values())
        where = Domain(system.mesh, 2 * degree + 2, **system.measure)

        def square(name: str) -> Any:
            known = exact(self.fields[name], system.mesh, where)

            def expression(unknowns: Any, ops: Any) -> Any:
                difference = getattr(unknowns, name) - known
                return (
                    ops.dot(difference, difference)
                    if isinstance(difference, Components)
                    else difference**2
                )

            return expression

        return {
            name: system.integrate(square(name), [where], state) ** 0.5
            for name in self.fields
        }

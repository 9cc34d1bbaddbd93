"""Forms of the models in UFL, for FFCx and DOLFINx: pointwise values are UFL expressions behind numpy's ufunc protocol.

    problem = UflSystem("triangle", {"u": (2, 2), "p": (1, 0)})
    form = problem.form(porous_flow.residual, coefficients, order=5)          # a ufl.Form, one integral over cells
    matrix = ufl.derivative(form, problem.state)

Forms, closures and materials run unchanged. Property tables (CoolProp) have no expression: they enter as coefficients.
Where `ops.low` is used, `state_low` holds the linear interpolants of all fields, that is, their values at the vertices.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import ufl
from numpy.lib.mixins import NDArrayOperatorsMixin

from contbed.fem.ad.dual import Components
from contbed.fem.skfem import Ops

UFUNCS: dict[np.ufunc, Callable[..., Any]] = {
    np.negative: lambda a: -a,
    np.positive: lambda a: a,
    np.sqrt: ufl.sqrt,
    np.square: lambda a: a * a,
    np.exp: ufl.exp,
    np.log: ufl.ln,
    np.log10: lambda a: ufl.ln(a) / float(np.log(10.0)),
    np.tanh: ufl.tanh,
    np.sin: ufl.sin,
    np.cos: ufl.cos,
    np.arctan: ufl.atan,
    np.abs: abs,
    np.reciprocal: lambda a: 1.0 / a,
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.divide: lambda a, b: a / b,
    np.power: lambda a, b: a**b,
    np.float_power: lambda a, b: a**b,
    np.maximum: ufl.max_value,
    np.minimum: ufl.min_value,
    np.less: ufl.lt,
    np.less_equal: ufl.le,
    np.greater: ufl.gt,
    np.greater_equal: ufl.ge,
    np.equal: ufl.eq,
    np.not_equal: ufl.ne,
    np.logical_and: ufl.And,
    np.logical_or: ufl.Or,
    np.logical_not: ufl.Not,
    np.bitwise_and: ufl.And,
    np.bitwise_or: ufl.Or,
    np.invert: ufl.Not,
}


class Pointwise(NDArrayOperatorsMixin):
    """A scalar UFL expression that obeys numpy's functions."""

    __slots__ = ("expression",)

    def __init__(self, expression: Any):
        self.expression = expression

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or any(isinstance(item, Components) for item in inputs):
            return NotImplemented
        if ufunc not in UFUNCS:
            raise TypeError(f"forms and closures may not use numpy.{ufunc.__name__}: it has no counterpart in UFL")
        return Pointwise(UFUNCS[ufunc](*(_expression(item) for item in inputs)))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function is not np.where:
            return NotImplemented
        if not isinstance(args[0], Pointwise):
            return args[1] if args[0] else args[2]
        return Pointwise(ufl.conditional(*(_expression(item) for item in args)))


def _expression(item: Any) -> Any:
    return item.expression if isinstance(item, Pointwise) else ufl.as_ufl(float(item))


def lagrange(cell: str, degree: int, ncomponents: int) -> Any:
    """Return the element with equispaced nodes: a vector of `ncomponents`, or a scalar for 0."""
    import basix.ufl

    shape = (ncomponents,) if ncomponents else None
    return basix.ufl.element("P", cell, degree, lagrange_variant=basix.LagrangeVariant.equispaced, shape=shape)


def mixed(elements: list[Any]) -> Any:
    """Return the element of several unknowns."""
    from basix.ufl import mixed_element

    return mixed_element(elements)


def _components(expression: Any, first: int, count: int) -> Any:
    """Return entries `first`... of a vector expression as Components, or one entry where `count` is 0."""
    if not count:
        return Pointwise(expression[first])
    return Components(Pointwise(expression[first + k]) for k in range(count))


class UflOps(Ops):
    """The operators of forms on UFL expressions; products, divergence and hoop term are those of `Ops`."""

    def __init__(self, mesh: ufl.Mesh, axisymmetric: bool, low: Mapping[Any, Any]):
        self.dim, self.axisymmetric, self._low = mesh.geometric_dimension, axisymmetric, low
        self.x = _components(ufl.SpatialCoordinate(mesh), 0, self.dim)
        self.n = _components(ufl.FacetNormal(mesh), 0, self.dim)
        self.h = Pointwise(ufl.MaxCellEdgeLength(mesh))

    def grad(self, field: Any) -> Components:
        """Return the gradient: a vector for a scalar field, a matrix with one row per component for a vector."""
        if isinstance(field, Components):
            return Components(self.grad(item) for item in field.items)
        gradient: Components = _components(ufl.grad(field.expression), 0, self.dim)
        return gradient

    def hess(self, field: Pointwise) -> Components:
        """Return the second derivatives of a scalar field in the plane of the mesh."""
        return self.grad(self.grad(field))

    def laplacian(self, field: Pointwise) -> Any:
        """Return the Laplacian of a scalar field, with its first-derivative term when axisymmetric."""
        return self.div(self.grad(field))

    def low(self, field: Pointwise) -> Pointwise:
        """Return the piecewise linear interpolant of an unknown."""
        return Pointwise(self._low[field.expression])


class UflSystem:
    """Named unknowns on one cell type, the counterpart of `fem.skfem.System`.

    `fields` maps a name to (degree, ncomponents); ncomponents is 0 for a scalar. `state` and `state_low` are the
    coefficients of all unknowns and of their linear interpolants.
    """

    def __init__(self, cell: str, fields: Mapping[str, tuple[int, int]], axisymmetric: bool = False):
        self.cell, self.fields = cell, fields
        dim = ufl.Cell(cell).topological_dimension
        self.mesh = ufl.Mesh(lagrange(cell, 1, dim))
        self.element = mixed([lagrange(cell, *field) for field in fields.values()])
        self.element_low = mixed([lagrange(cell, 1, n) for _, n in fields.values()])
        space = ufl.FunctionSpace(self.mesh, self.element)
        self.state = ufl.Coefficient(space)
        self.state_low = ufl.Coefficient(ufl.FunctionSpace(self.mesh, self.element_low))
        self.unknowns, self.tests = self._split(self.state), self._split(ufl.TestFunction(space))
        size = sum(max(n, 1) for _, n in fields.values())
        self.ops = UflOps(self.mesh, axisymmetric, {self.state[k]: self.state_low[k] for k in range(size)})

    def _split(self, function: Any) -> SimpleNamespace:
        out, first = {}, 0
        for name, (_, ncomponents) in self.fields.items():
            out[name] = _components(function, first, ncomponents)
            first += max(ncomponents, 1)
        return SimpleNamespace(**out)

    def known(self, degree: int, ncomponents: int) -> tuple[ufl.Coefficient, Any]:
        """Return a known finite-element field: the UFL coefficient, and what a form sees of it."""
        coefficient = ufl.Coefficient(ufl.FunctionSpace(self.mesh, lagrange(self.cell, degree, ncomponents)))
        if ncomponents:
            return coefficient, _components(coefficient, 0, ncomponents)
        return coefficient, Pointwise(coefficient)

    def form(
        self,
        form: Callable[..., Any],
        coeffs: Any,
        *,
        order: int,
        rule: tuple[Any, Any] | None = None,
        facets: bool = False,
    ) -> ufl.Form:
        """Return the integral of a form over cells or exterior facets, times 2 pi r when axisymmetric.

        `order` is the degree of the quadrature; a `rule` of reference points (n, dim) and weights replaces it.
        """
        integrand = _expression(form(self.unknowns, self.tests, coeffs, self.ops))
        if self.ops.axisymmetric:
            integrand = 2.0 * np.pi * self.ops.x[0].expression * integrand
        metadata: dict[str, Any] = {"quadrature_degree": order}
        if rule is not None:
            metadata |= {"quadrature_rule": "custom", "quadrature_points": rule[0], "quadrature_weights": rule[1]}
        measure = ufl.ds if facets else ufl.dx
        integral: ufl.Form = integrand * measure(domain=self.mesh, metadata=metadata)
        return integral

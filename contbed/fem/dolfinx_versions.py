"""Differences between versions of DOLFINx, in one place.

Run with 0.5.2 (Debian 12: UFL 2022.2, Basix 0.5, FFCx 0.5, PETSc 3.18). Written for 0.9 to 0.11 from their
documentation and sources; of these only UFL 2026.1, Basix 0.11 and FFCx 0.11 were run (the element functions below and
tests/verification/test_ufl.py), DOLFINx itself was NOT run in any version above 0.5.2.

    meshes     `create_mesh(comm, cells, x, domain)` up to 0.9, `(comm, cells, domain, x)` from 0.10; copies
               of cells of neighbours by `ghost_mode` up to 0.6, by a partitioner since
    elements   `basix.ufl_wrapper` in 0.5, `basix.ufl` since 0.7; a quadrature element of any points since 0.8
    spaces     `fem.FunctionSpace` up to 0.6, `fem.functionspace` since 0.7
    dof lists  an adjacency list up to 0.6, an array since 0.7
    forms      `jit_params` in 0.5, `jit_options` since 0.6
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from inspect import signature
from typing import Any

import numpy as np

from contbed.errors import EngineError

SAME_POINT = 1e-12  # distance of points in a cell of length 1 that differ by rounding alone
HOW = "sudo apt-get install python3-dolfinx and a virtual environment with --system-site-packages, see README"


def modules() -> tuple[Any, Any]:
    """Return DOLFINx and PETSc.

    Raises
    ------
    EngineError : a module is missing, or PETSc computes with complex numbers
    """
    try:
        import dolfinx
        import dolfinx.fem.petsc
        from petsc4py import PETSc
    except ImportError as error:
        raise EngineError(f"the engine dolfinx cannot be loaded ({error}); {HOW}") from error
    if np.issubdtype(PETSc.ScalarType, np.complexfloating):
        raise EngineError(
            "the engine dolfinx needs PETSc with real numbers, found a complex build; "
            "install python3-dolfinx-real, or set PETSC_DIR to the real build"
        )
    return dolfinx, PETSc


def create_mesh(comm: Any, cell: str, cells: Any, points: Any, shared: bool = False) -> Any:
    """Build a mesh of linear cells from each rank's share of arrays (ncells, nv) and (n, dim); shares may be empty.

    With `shared`, each rank has copies of the cells behind its facets.
    """
    import ufl
    from dolfinx import mesh

    dim = points.shape[1]
    if hasattr(ufl, "VectorElement"):  # up to 0.6
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", cell, 1))
        return mesh.create_mesh(comm, cells, points, domain, ghost_mode=_ghosts(shared))
    import basix.ufl

    domain = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
    parts = {"partitioner": mesh.create_cell_partitioner(_ghosts(shared))} if shared else {}
    if list(signature(mesh.create_mesh).parameters)[2] == "x":
        return mesh.create_mesh(comm, cells, points, domain, **parts)
    return mesh.create_mesh(comm, cells, domain, points, **parts)


def _ghosts(shared: bool) -> Any:
    from dolfinx.cpp.mesh import GhostMode

    return GhostMode.shared_facet if shared else GhostMode.none


def lagrange(cell: str, degree: int, ncomponents: int) -> Any:
    """Return the element with equispaced nodes: a vector of `ncomponents`, or a scalar for 0."""
    try:
        import basix.ufl
    except ImportError:
        from basix import LagrangeVariant, ufl_wrapper

        scalar = ufl_wrapper.create_element("P", cell, degree, LagrangeVariant.equispaced)
        return ufl_wrapper.VectorElement(scalar, ncomponents) if ncomponents else scalar
    shape = (ncomponents,) if ncomponents else None
    return basix.ufl.element("P", cell, degree, lagrange_variant=basix.LagrangeVariant.equispaced, shape=shape)


def gauss_polynomials(points: Any) -> tuple[Any, Any]:
    """Return the element of polynomials given by their values at Gauss points (n,) in [0, 1], and its order of them."""
    import basix

    variant, none, degree = basix.LagrangeVariant.gl_warped, basix.DPCVariant.unset, len(points) - 1
    plain = basix.create_element(basix.ElementFamily.P, basix.CellType.interval, degree, variant, none, True)
    distance = np.abs(np.asarray(plain.points) - points)
    if distance.min(axis=1).max() > SAME_POINT:
        raise EngineError("this version of Basix has other Gauss points")
    order = distance.argmin(axis=1)
    try:
        import basix.ufl
    except ImportError:
        from basix import ufl_wrapper

        return ufl_wrapper.create_element("P", "interval", degree, variant, discontinuous=True), order
    element = basix.ufl.element("P", "interval", degree, lagrange_variant=variant, discontinuous=True)
    return element, order


def mixed(elements: list[Any]) -> Any:
    """Return the element of several unknowns."""
    try:
        from basix.ufl import mixed_element
    except ImportError:
        import ufl

        return ufl.MixedElement(elements)  # type: ignore[attr-defined]  # that of Basix 0.5 has no pull-back
    return mixed_element(elements)


def constants(cell: str) -> Any:
    """Return the element of one value in each cell."""
    try:
        import basix.ufl
    except ImportError:
        from basix import LagrangeVariant, ufl_wrapper

        return ufl_wrapper.create_element("P", cell, 0, LagrangeVariant.unset, discontinuous=True)
    return basix.ufl.element("DG", cell, 0)


def quadrature(cell: str, points: Any, weights: Any) -> Any:
    """Return the element of one value at each quadrature point."""
    try:
        from basix.ufl import quadrature_element
    except ImportError:
        return _quadrature_of_05(cell, points)
    return quadrature_element(cell, points=points, weights=weights)


def _quadrature_of_05(cell: str, points: Any) -> Any:
    """Return a quadrature element of any points for FFCx 0.5, which knows its own rules only."""
    import hashlib

    import ufl
    from basix.ufl_wrapper import _BasixElementBase
    from ffcx.element_interface import QuadratureElement  # type: ignore[attr-defined]

    class PointElement(QuadratureElement):  # type: ignore[misc]
        def __init__(self) -> None:
            shape: Any = ufl.Cell(cell)
            self._points, self._cellname, self._family_name = points, cell, "Quadrature"
            counts = [shape.num_vertices(), shape.num_edges(), shape.num_facets()][: shape.topological_dimension()]
            self._entity_counts = [*counts, 1]
            label = f"Quadrature({hashlib.sha256(points.tobytes()).hexdigest()[:16]})"
            _BasixElementBase.__init__(self, label, "quadrature element", cell, (), len(points), "identity")

    return PointElement()


def function_space(mesh: Any, element: Any) -> Any:
    """Return the finite-element space of an element on a mesh."""
    from dolfinx import fem

    make = fem.functionspace if hasattr(fem, "functionspace") else fem.FunctionSpace
    with _quiet():
        return make(mesh, element)


def dof_list(space: Any) -> Any:
    """Return the unknowns of each cell (ncells, n), not unrolled where the space has blocks."""
    found = space.dofmap.list
    if isinstance(found, np.ndarray):
        return found
    cells = len(found.offsets) - 1
    return found.array.reshape(cells, -1)


def geometry_list(mesh: Any) -> Any:
    """Return the geometry nodes of each cell (ncells, nv)."""
    found = mesh.geometry.dofmap
    if isinstance(found, np.ndarray):
        return found
    return found.array.reshape(len(found.offsets) - 1, -1)


def compiled(form: Any) -> Any:
    """Compile a form; wait if another process is compiling the same one."""
    from dolfinx import fem

    options = {"timeout": 900}
    name = "jit_options" if "jit_options" in signature(fem.form).parameters else "jit_params"
    with _quiet():
        return fem.form(form, **{name: options})


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the messages of the form compilers."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)

"""What contbed takes from DOLFINx, in the version that it is tested with.

Tested: 0.5.2, that of Debian 12, with UFL 2022.2, Basix 0.5, FFCx 0.5 and PETSc 3.18.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from contbed.errors import EngineError

TESTED = "0.5"  # major and minor version; later ones have other functions
HOW = "install python3-dolfinx, as `make dolfinx` does; see docs/howto/mpi.md"


def modules() -> tuple[Any, Any]:
    """Return DOLFINx and PETSc.

    Raises
    ------
    EngineError : a module is missing, DOLFINx has another version, or PETSc computes
        with complex numbers
    """
    try:
        import dolfinx
        import dolfinx.fem.petsc
        from petsc4py import PETSc
    except ImportError as error:
        raise EngineError(
            f"the engine dolfinx cannot be loaded ({error}); {HOW}"
        ) from error
    version = str(dolfinx.__version__)
    if version.split(".")[:2] != TESTED.split("."):
        raise EngineError(
            f"the engine dolfinx is tested with DOLFINx {TESTED} only, found "
            f"{version}; {HOW}"
        )
    if np.issubdtype(PETSc.ScalarType, np.complexfloating):
        raise EngineError(
            "the engine dolfinx needs PETSc with real numbers, found a complex build; "
            "install python3-dolfinx-real, or set PETSC_DIR to the real build"
        )
    return dolfinx, PETSc


def create_mesh(comm: Any, cell: str, cells: Any, points: Any) -> Any:
    """Build a mesh of linear cells from each rank's share of arrays (ncells, nv) and
    (n, dim); shares may be empty.
    """
    import ufl
    from dolfinx import mesh
    from dolfinx.cpp.mesh import GhostMode

    domain = ufl.Mesh(ufl.VectorElement("Lagrange", cell, 1))  # type: ignore[attr-defined]
    return mesh.create_mesh(comm, cells, points, domain, ghost_mode=GhostMode.none)


def lagrange(cell: str, degree: int, ncomponents: int) -> Any:
    """Return the element with equispaced nodes: a vector of `ncomponents`, or a
    scalar for 0.
    """
    from basix import LagrangeVariant, ufl_wrapper

    scalar = ufl_wrapper.create_element("P", cell, degree, LagrangeVariant.equispaced)
    return ufl_wrapper.VectorElement(scalar, ncomponents) if ncomponents else scalar


def mixed(elements: list[Any]) -> Any:
    """Return the element of several unknowns."""
    import ufl

    return ufl.MixedElement(elements)  # type: ignore[attr-defined]  # that of Basix has no pull-back


def constants(cell: str) -> Any:
    """Return the element of one value in each cell."""
    from basix import LagrangeVariant, ufl_wrapper

    return ufl_wrapper.create_element(
        "P", cell, 0, LagrangeVariant.unset, discontinuous=True
    )


def quadrature(cell: str, points: Any) -> Any:
    """Return the element of one value at each of our quadrature points; that of FFCx
    knows its own rules only.
    """
    import ufl
    from basix.ufl_wrapper import _BasixElementBase
    from ffcx.element_interface import QuadratureElement  # type: ignore[attr-defined]

    class PointElement(QuadratureElement):  # type: ignore[misc]
        def __init__(self) -> None:
            shape: Any = ufl.Cell(cell)
            self._points, self._cellname, self._family_name = points, cell, "Quadrature"
            counts = [shape.num_vertices(), shape.num_edges(), shape.num_facets()][
                : shape.topological_dimension()
            ]
            self._entity_counts = [*counts, 1]
            label = f"Quadrature({hashlib.sha256(points.tobytes()).hexdigest()[:16]})"
            _BasixElementBase.__init__(
                self, label, "quadrature element", cell, (), len(points), "identity"
            )

    return PointElement()


def function_space(mesh: Any, element: Any) -> Any:
    """Return the finite-element space of an element on a mesh."""
    from dolfinx import fem

    with _quiet():
        return fem.FunctionSpace(mesh, element)


def dof_list(space: Any) -> Any:
    """Return the unknowns of each cell (ncells, n), not unrolled where the space has
    blocks.
    """
    return _rows(space.dofmap.list)


def geometry_list(mesh: Any) -> Any:
    """Return the geometry nodes of each cell (ncells, nv)."""
    return _rows(mesh.geometry.dofmap)


def _rows(adjacency: Any) -> Any:
    return adjacency.array.reshape(len(adjacency.offsets) - 1, -1)


def compiled(form: Any) -> Any:
    """Compile a form; wait if another process is compiling the same one."""
    from dolfinx import fem

    with _quiet():
        return fem.form(form, jit_params={"timeout": 900})


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the messages of the form compilers."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)

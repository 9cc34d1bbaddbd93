"""Versions of contbed and of the libraries that a run has imported."""

from __future__ import annotations

import platform
import sys

from contbed import __version__

_LIBRARIES = (
    "numpy",
    "scipy",
    "skfem",
    "cantera",
    "CoolProp",
    "gmsh",
    "meshio",
    "numba",
    "dolfinx",
    "petsc4py",
)


def versions() -> dict[str, str]:
    """Return the version of each library that is loaded; one that is not loaded was
    not needed.
    """
    loaded = {
        name: getattr(sys.modules[name], "__version__", "?")
        for name in _LIBRARIES
        if name in sys.modules
    }
    return {"contbed": __version__, "python": platform.python_version(), **loaded}

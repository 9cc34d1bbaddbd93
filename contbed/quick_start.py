"""What the process of one command leaves out, as it lives for one command only. In programs of users nothing changes.

- Modules are imported without the collection of reference cycles in between, which finds nothing in them, and they are
  not searched when Python ends: together 0.3 to 0.4 s of 1.4 s of a small run.
- OpenBLAS is loaded for the one thread that runs let it compute on, 0.1 s: others wait for work, busy, from the start.
- matplotlib is imported without the help texts that it composes for every `set` method, 0.1 s.
- Modules that libraries import and that no run uses are loaded when first used, which is never: together 0.04 s.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import LazyLoader
from types import ModuleType
from typing import Any

# scipy copies all names of numpy, those of its compiler of Fortran and of its tests too; matplotlib reads font lists of
# Macs and names of glyphs for TeX, and Pillow names what cameras write
_UNUSED = {"numpy.f2py", "numpy.testing", "plistlib", "fontTools.agl", "PIL.ExifTags"}
_process = {"of_a_command": False, "frozen": False}


def begin() -> None:
    """Postpone the collection of reference cycles and start no threads of BLAS; called before anything is imported."""
    _process["of_a_command"] = True
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.meta_path.insert(0, _WhenUsed())
    gc.disable()


def end() -> None:
    """Leave all that is in memory to the system, which takes it when the process ends."""
    gc.freeze()


class _WhenUsed:
    """Finds modules that few need, and lets them load when one of their names is first asked for."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name in _UNUSED else None
        if spec is not None and spec.loader is not None:
            spec.loader = LazyLoader(spec.loader)
        return spec


@contextmanager
def collecting() -> Iterator[None]:
    """Collect reference cycles for the block, in which a run may take long; what was imported before stays."""
    postponed = not gc.isenabled()
    if postponed and not _process["frozen"]:
        _process["frozen"] = True
        gc.freeze()
    gc.enable()
    try:
        yield
    finally:
        if postponed:
            gc.disable()


@contextmanager
def without_help_texts() -> Iterator[None]:
    """Import parts of matplotlib in the block without composing help texts, in the process of a command only."""
    if not _process["of_a_command"]:
        yield
        return
    from matplotlib import artist

    # `ArtistInspector` stays as it is: axes ask it which arguments their grids take
    module: Any = artist
    kwdoc, compose = artist.kwdoc, module.Artist.__dict__["_update_set_signature_and_docstring"]
    module.kwdoc = lambda artist: ""
    module.Artist._update_set_signature_and_docstring = classmethod(lambda kind: None)
    try:
        yield
    finally:
        module.kwdoc, module.Artist._update_set_signature_and_docstring = kwdoc, compose

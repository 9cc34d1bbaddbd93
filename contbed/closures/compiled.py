"""Closures for compiled kernels: functions of numbers, called by the names of their
arguments.

A kernel is written as a plain function that calls closures by global names. `kernel`
compiles it with the closures that a scene names and keeps the machine code on disk,
next to the kernel's module, for the next process. The entry is new for other closures
and whenever a file changes that one of them comes from.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

from numba import njit

from contbed.closures.binding import BoundClosure, Function


@cache
def compiled(function: Function) -> Function:
    """Compile a closure for numbers, and with it the functions that it calls."""
    known = function.__globals__
    called = {
        name: compiled(known[name])
        for name in function.__code__.co_names
        if isinstance(known.get(name), FunctionType)
    }
    plain = FunctionType(
        function.__code__, known | called, function.__name__, function.__defaults__
    )
    return njit(plain, error_model="numpy")


def own_values(closure: BoundClosure | None) -> tuple[float, ...]:
    """Numbers that a closure takes besides the arguments of a model, in the order of
    `Face`.
    """
    return (
        ()
        if closure is None
        else tuple(float(value) for value in _own(closure).values())
    )


class Face:
    """A function of the arguments `names`, in this order, and of a tuple of
    `own_values`, which passes them to a closure by their names; 0 without a closure.
    """

    def __init__(self, closure: BoundClosure | None, names: tuple[str, ...]):
        self.function = None if closure is None else closure.function
        if closure is None:
            value = "0.0"
        else:
            taken = [f"{name}={name}" for name in names if name in closure.takes]
            own = [f"{name}=own[{k}]" for k, name in enumerate(_own(closure))]
            value = f"closure({', '.join(taken + own)})"
        self.source = f"def face({', '.join(names)}, own):\n    return {value}\n"

    @property
    def key(self) -> str:
        """What the compiled function follows from."""
        if self.function is None:
            return self.source
        return (
            f"{self.function.__name__} {_text(self.function.__code__.co_filename)} "
            f"{self.source}"
        )

    def compile(self) -> Function:
        """Return the compiled function."""
        return _compiled_face(self.function, self.source)


def kernel(
    template: Function, uses: Mapping[str, Face | Function], **constants: Any
) -> Function:
    """Compile a function whose global names in `uses` are closures, and in
    `constants` numbers or switches.
    """
    parts = [f"{name} {_key(use)}" for name, use in uses.items()]
    parts += [f"{name} {value!r}" for name, value in constants.items()]
    key = hashlib.sha1("\n".join(parts).encode()).hexdigest()
    return _kernel(template, key, tuple(uses.items()), tuple(constants.items()))


def _key(use: Face | Function) -> str:
    return use.key if isinstance(use, Face) else _text(use.__code__.co_filename)


_kernels: dict[tuple[Function, str], Function] = {}


def _kernel(template: Function, key: str, uses: Any, constants: Any) -> Function:
    if (template, key) not in _kernels:
        functions = {
            name: use.compile() if isinstance(use, Face) else compiled(use)
            for name, use in uses
        }
        plain = FunctionType(
            template.__code__,
            template.__globals__ | functions | dict(constants),
            template.__name__,
        )
        plain.__qualname__ = f"{template.__qualname__}_{key}"  # names the entry on disk
        _kernels[template, key] = njit(plain, cache=True, nogil=True)
    return _kernels[template, key]


def _own(closure: BoundClosure) -> dict[str, Any]:
    """Parameters of the scene, and options that neither the scene nor the model
    gives.
    """
    options = {
        key: value
        for key, value in closure.sheet.options.items()
        if key not in closure.takes
    }
    return options | closure.parameters


@cache
def _compiled_face(function: Function | None, source: str) -> Function:
    known: dict[str, Any] = {"__name__": __name__}
    if function is not None:
        known["closure"] = compiled(function)
    exec(source, known)
    return njit(known["face"], error_model="numpy")  # type: ignore[no-any-return]


@cache
def _text(file: str) -> str:
    return Path(file).read_text(encoding="utf-8")

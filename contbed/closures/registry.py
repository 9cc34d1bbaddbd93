"""The register of closures: what each one is called, what it returns, where it is valid
and who published it.

A closure stays a plain function. The decorator only hangs a data sheet on it and makes
it known by name:

    @closure(kind="nusselt", ranges={"Re": (15, 8500)}, source="Author year, journal, doi:...")
    def nusselt_author(Re, Pr): ...

A range belongs to an argument, or to the ratio of two arguments ("k_solid/k_fluid");
both bounds are inclusive. Nothing is checked while a closure is evaluated:
`ranges.usage` compares the declared with the used range afterwards.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias, TypeVar

from contbed.closures.arguments import UNITS, argument
from contbed.closures.sheet import Docstring, Interval, Sheet, assembled
from contbed.errors import SceneError

Value: TypeAlias = Any  # a number, an array or a dual number
Function = TypeVar("Function", bound=Callable[..., Any])


_register: dict[str, Callable[..., Any]] = {}


def closure(
    *,
    kind: str,
    ranges: Mapping[str, tuple[float, float]],
    source: str,
    unit: str = "",
    bounds: Mapping[str, str] = MappingProxyType({}),
) -> Callable[[Function], Function]:
    """Register a function as a closure; its data sheet becomes `function.sheet` and, as
    text, its docstring.

    `unit` is that of the kind unless it is given. `bounds` are the values that a scene
    may give to parameters of this law, such as {"exponent_Pr": "[0, inf)"}.
    """

    def decorate(function: Function) -> Function:
        name, returned = function.__name__, unit or UNITS.get(kind, "")
        parameters = inspect.signature(function).parameters
        if name in _register and _register[name].__module__ != function.__module__:
            raise ValueError(f"closure {name}: the name is taken")
        if not returned:
            raise ValueError(f"closure {name}: give the unit of the kind {kind!r}")
        for what, keys in (("range", ranges), ("bound", bounds)):
            for key in keys:
                if not set(key.split("/")) <= set(parameters):
                    raise ValueError(
                        f"closure {name}: {what} {key!r} names no argument; it has "
                        f"{', '.join(parameters)}"
                    )
        shared = {
            key: known.bounds
            for key in parameters
            if (known := argument(key, kind)) and known.bounds
        }
        limits = MappingProxyType(
            {key: Interval.read(text) for key, text in (shared | dict(bounds)).items()}
        )
        doc = Docstring.read(inspect.getdoc(function) or "")
        given = {key: value.default for key, value in parameters.items()}
        required = tuple(
            key for key, default in given.items() if default is inspect.Parameter.empty
        )
        sheet = Sheet(
            name=name,
            kind=kind,
            unit=returned,
            arguments=required,
            options=MappingProxyType(
                {key: value for key, value in given.items() if key not in required}
            ),
            ranges=MappingProxyType(
                {key: (float(low), float(high)) for key, (low, high) in ranges.items()}
            ),
            source=source,
            summary=doc.summary,
            equation=inspect.cleandoc(doc.equation),
            text=assembled(
                doc, kind, returned, tuple(parameters), ranges, limits, source
            ),
            bounds=limits,
        )
        function.sheet = sheet  # type: ignore[attr-defined]
        function.__doc__ = sheet.text
        _register[name] = function
        return function

    return decorate


@cache
def _load() -> None:
    """Import the modules of this package that hold closures; each closure registers
    itself.
    """
    for file in sorted(Path(__file__).parent.glob("*.py")):
        if "\n@closure(" in file.read_text(encoding="utf-8"):
            import_module(f"{__package__}.{file.stem}")


def names(kind: str | None = None) -> tuple[str, ...]:
    """Return the names of all closures, or of one kind, in alphabetical order."""
    _load()
    return tuple(
        sorted(name for name in _register if kind is None or _sheet(name).kind == kind)
    )


def get(name: str, kind: str | None = None) -> Callable[..., Any]:
    """Return the closure of that name; an unknown one, or one of another kind,
    raises SceneError with the nearest.
    """
    _load()
    function = _register.get(name)
    if function is None:
        raise unknown(name, names(kind), kind)
    found = _sheet(name).kind
    if kind is not None and found != kind:
        raise SceneError(
            f"closure {name!r} is of kind {found!r}, wanted kind {kind!r}: "
            f"{', '.join(names(kind))}"
        )
    return function


class DispersionPair(NamedTuple):
    """The two closures of one correlation of dispersion."""

    axial: Callable[..., Any]
    transverse: Callable[..., Any]


def dispersions() -> list[str]:
    """Return the names of the correlations of dispersion, without the direction."""
    axial = (name for name in names("dispersion") if name.endswith("_axial"))
    return [name.removesuffix("_axial") for name in axial]


def dispersion_pair(stem: str) -> DispersionPair:
    """Return the axial and the transverse closure whose names begin with `stem`;
    SceneError names the nearest stems.
    """
    known = dispersions()
    if stem not in known:
        raise unknown(stem, known, "dispersion")
    return DispersionPair(get(f"{stem}_axial"), get(f"{stem}_transverse"))


def sheet(name: str) -> Sheet:
    """Return the data sheet of the closure of that name."""
    get(name)
    return _sheet(name)


def data_sheet(name: str) -> str:
    """Return the data sheet as text: what is registered, then the docstring."""
    facts = sheet(name)
    options = [f"{key}={value:.6g}" for key, value in facts.options.items()]
    head = [
        f"{facts.name}({', '.join([*facts.arguments, *options])})",
        f"kind {facts.kind}, unit [{facts.unit}]",
    ]
    return "\n".join([*head, "", facts.text, ""])


def unknown(name: str, known: Iterable[str], kind: str | None = None) -> SceneError:
    """Return the error for a name that is not among the known ones: the nearest come
    first, else all are listed.
    """
    known = list(known)
    what = f"{kind} closure" if kind else "closure"
    if near := get_close_matches(name, known, n=3, cutoff=0.5):
        return SceneError(f"unknown {what} {name!r}; nearest: {', '.join(near)}")
    return SceneError(f"unknown {what} {name!r}; known: {', '.join(known) or 'none'}")


def _sheet(name: str) -> Sheet:
    found: Sheet = _register[name].sheet  # type: ignore[attr-defined]
    return found

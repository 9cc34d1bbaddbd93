"""The register of closures: what each one is called, what it returns, where it is valid and who published it.

A closure stays a plain function. The decorator only hangs a data sheet on it and makes it known by name:

    @closure(kind="nusselt", unit="-", ranges={"Re": (15, 8500)}, source="Author year, journal, doi:...")
    def nusselt_author(Re, Pr): ...

A range belongs to an argument, or to the ratio of two arguments ("k_solid/k_fluid"); both bounds are inclusive.
Nothing is checked while a closure is evaluated: `usage` compares the declared with the used range afterwards.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from contbed.closures.sheet import Docstring, Interval, Sheet, assembled
from contbed.errors import SceneError

Value: TypeAlias = Any  # a number, an array or a dual number
Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class ArgumentUse:
    """Declared and used range of one argument; `share_outside` is the share of points beyond the bounds or nan."""

    declared: tuple[float, float]
    used: tuple[float, float]
    share_outside: float


@dataclass(frozen=True)
class RangeUse:
    """How one run used one closure."""

    sheet: Sheet
    arguments: Mapping[str, ArgumentUse]

    @property
    def share_outside(self) -> float:
        """The largest share of points that lie outside the range of any one argument."""
        return max((use.share_outside for use in self.arguments.values()), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; a missing bound is None because JSON knows neither inf nor nan."""
        return {
            "name": self.sheet.name,
            "kind": self.sheet.kind,
            "source": self.sheet.source,
            "share_outside": self.share_outside,
            "ranges": {
                name: {
                    "declared": [_finite(bound) for bound in use.declared],
                    "used": [_finite(bound) for bound in use.used],
                    "share_outside": use.share_outside,
                }
                for name, use in self.arguments.items()
            },
        }


_ROUNDING = 1e-9  # relative excess of a value over a bound that is no more than rounding
_register: dict[str, Callable[..., Any]] = {}


def closure(
    *,
    kind: str,
    unit: str,
    ranges: Mapping[str, tuple[float, float]],
    source: str,
    bounds: Mapping[str, str] = MappingProxyType({}),
) -> Callable[[Function], Function]:
    """Register a function as a closure; its data sheet becomes `function.sheet` and, as text, its docstring.

    `bounds` are the values that parameters may have, such as {"emissivity": "(0, 1]"}.
    """

    def decorate(function: Function) -> Function:
        name = function.__name__
        parameters = inspect.signature(function).parameters
        if name in _register and _register[name].__module__ != function.__module__:
            raise ValueError(f"closure {name}: the name is taken")
        for what, keys in (("range", ranges), ("bound", bounds)):
            for key in keys:
                if not set(key.split("/")) <= set(parameters):
                    raise ValueError(
                        f"closure {name}: {what} {key!r} names no argument; it has {', '.join(parameters)}"
                    )
        limits = MappingProxyType({key: Interval.read(text) for key, text in bounds.items()})
        doc = Docstring.read(inspect.getdoc(function) or "")
        given = {key: value.default for key, value in parameters.items()}
        required = tuple(key for key, default in given.items() if default is inspect.Parameter.empty)
        sheet = Sheet(
            name=name,
            kind=kind,
            unit=unit,
            arguments=required,
            options=MappingProxyType({key: value for key, value in given.items() if key not in required}),
            ranges=MappingProxyType({key: (float(low), float(high)) for key, (low, high) in ranges.items()}),
            source=source,
            summary=doc.summary,
            equation=inspect.cleandoc(doc.equation),
            text=assembled(doc, kind, unit, tuple(parameters), ranges, limits, source),
            bounds=limits,
        )
        function.sheet = sheet  # type: ignore[attr-defined]
        function.__doc__ = sheet.text
        _register[name] = function
        return function

    return decorate


@cache
def _load() -> None:
    """Import the modules of this package that hold closures; each closure registers itself."""
    for file in sorted(Path(__file__).parent.glob("*.py")):
        if "\n@closure(" in file.read_text(encoding="utf-8"):
            import_module(f"{__package__}.{file.stem}")


def names(kind: str | None = None) -> tuple[str, ...]:
    """The names of all closures, or of those of one kind, in alphabetical order."""
    _load()
    return tuple(sorted(name for name in _register if kind is None or _sheet(name).kind == kind))


def get(name: str, kind: str | None = None) -> Callable[..., Any]:
    """The closure of that name. An unknown name, or one of another kind, raises SceneError with the nearest names."""
    _load()
    function = _register.get(name)
    if function is None:
        raise unknown(name, names(kind), kind)
    found = _sheet(name).kind
    if kind is not None and found != kind:
        raise SceneError(f"closure {name!r} is of kind {found!r}, wanted kind {kind!r}: {', '.join(names(kind))}")
    return function


class DispersionPair(NamedTuple):
    """The two closures of one correlation of dispersion."""

    axial: Callable[..., Any]
    transverse: Callable[..., Any]


def dispersion_pair(stem: str) -> DispersionPair:
    """The axial and the transverse closure whose names begin with `stem`; SceneError names the nearest stems."""
    known = [name.removesuffix("_axial") for name in names("dispersion") if name.endswith("_axial")]
    if stem not in known:
        raise unknown(stem, known, "dispersion")
    return DispersionPair(get(f"{stem}_axial"), get(f"{stem}_transverse"))


def sheet(name: str) -> Sheet:
    """The data sheet of the closure of that name."""
    get(name)
    return _sheet(name)


def data_sheet(name: str) -> str:
    """The data sheet as text: what is registered, then the docstring."""
    facts = sheet(name)
    options = [f"{key}={value:.6g}" for key, value in facts.options.items()]
    head = [
        f"{facts.name}({', '.join([*facts.arguments, *options])})",
        f"kind {facts.kind}, unit [{facts.unit}]",
    ]
    return "\n".join([*head, "", facts.text, ""])


def usage(function: Callable[..., Any] | str, **arguments: Any) -> RangeUse:
    """Compare the arguments of a call, numbers or arrays that broadcast, with the declared ranges."""
    if isinstance(function, str):
        function = get(function)
    facts: Sheet = function.sheet  # type: ignore[attr-defined]
    bound = inspect.signature(function).bind(**arguments)
    bound.apply_defaults()
    uses = {}
    for key, declared in facts.ranges.items():
        top, _, bottom = key.partition("/")
        values = np.asarray(bound.arguments[top], dtype=float)
        if bottom:
            values = values / np.asarray(bound.arguments[bottom], dtype=float)
        uses[key] = _argument_use(values, declared)
    return RangeUse(sheet=facts, arguments=MappingProxyType(uses))


def unknown(name: str, known: Iterable[str], kind: str | None = None) -> SceneError:
    """The error for a name that is not among the known ones: the nearest come first, else all are listed."""
    known = list(known)
    what = f"{kind} closure" if kind else "closure"
    if near := get_close_matches(name, known, n=3, cutoff=0.5):
        return SceneError(f"unknown {what} {name!r}; nearest: {', '.join(near)}")
    return SceneError(f"unknown {what} {name!r}; known: {', '.join(known) or 'none'}")


def _sheet(name: str) -> Sheet:
    found: Sheet = _register[name].sheet  # type: ignore[attr-defined]
    return found


def _argument_use(values: np.ndarray, declared: tuple[float, float]) -> ArgumentUse:
    if values.size == 0:
        return ArgumentUse(declared, (math.nan, math.nan), 0.0)
    low, high = declared
    # Written as "not inside" so that nan counts as outside. Rounding of a value at a bound is inside.
    outside = ~((values >= low - _ROUNDING * abs(low)) & (values <= high + _ROUNDING * abs(high)))
    return ArgumentUse(declared, (float(values.min()), float(values.max())), float(outside.mean()))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None

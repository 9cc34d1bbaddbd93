"""Closures bound to the places of a scene that name them:
name -> function -> arguments -> value -> range use.

A scene names a closure by a text, "gunn" or "nusselt_gunn", by a table with parameters,
{name = "power", a = 1.1, b = 0.6}, or by a file, {file = "closure.toml"}. `bind`
resolves it once. Every physics states which arguments it gives at a place; what the
closure needs besides has to stand in the scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

from contbed.arrays import Array
from contbed.closures import ranges, registry
from contbed.closures.sheet import Sheet
from contbed.errors import SceneError
from contbed.scene.quantities import ClosureFile, computable
from contbed.scene.tables import Closure

PHASE = "conductivity_phase"

Function = Callable[..., Any]
Spec = str | Closure | ClosureFile
_FACTORS: ContextVar[Mapping[str, float]] = ContextVar("factors of closures by kind")


@contextmanager
def scaled(factors: Mapping[str, float]) -> Iterator[None]:
    """Multiply closures by a factor for each kind that is bound in this context, to
    propagate their uncertainty.

    Closures that are compiled into the loops of two-fluid scenes are not multiplied.
    """
    token = _FACTORS.set(factors)
    try:
        yield
    finally:
        _FACTORS.reset(token)


class BoundClosure:
    """A closure with its own parameters, and the arguments that it takes from what a
    model knows.

    Called with keywords, it takes those that it needs, keeps them as its last
    arguments, and leaves out all others.
    """

    def __init__(
        self, function: Function, parameters: Mapping[str, Any], gives: Iterable[str]
    ):
        self.function = function
        self.sheet: Sheet = function.sheet  # type: ignore[attr-defined]
        accepted = (*self.sheet.arguments, *self.sheet.options)
        given = set(gives)
        self.parameters = {
            key: value for key, value in parameters.items() if key in accepted
        }
        self.takes = tuple(
            key for key in accepted if key in given and key not in self.parameters
        )
        self._factor = _FACTORS.get({}).get(self.sheet.kind, 1.0)
        self._last: dict[str, Any] | None = None
        self._record = ranges.RangeRecord(self.sheet)

    @property
    def name(self) -> str:
        """Name of the closure."""
        return self.sheet.name

    def __call__(self, **known: Any) -> Any:
        """Return the value at a state; `known` holds at least the arguments of the
        closure.
        """
        self._last = {key: known[key] for key in self.takes} | self.parameters
        value = self.function(**self._last)
        return value if self._factor == 1.0 else self._factor * value

    def at(self, state: Any) -> Any:
        """Return the value at a state of a model, whose attributes are the arguments."""
        return self(**{key: getattr(state, key) for key in self.takes})

    def use(self, **known: Any) -> ranges.RangeUse:
        """Return the used ranges: those recorded, else those of `known` or, if that
        is empty, of the last call.
        """
        if not self._record.empty:
            return self._record.use()
        return ranges.usage(self.function, **self._plain(known))

    def record(self, **known: Any) -> None:
        """Add `known` or, if that is empty, the arguments of the last call to the
        record of used ranges.
        """
        if known or self._last is not None:
            self._record.add({**self.sheet.options, **self._plain(known)})

    def state(self) -> Array:
        """Return the record of used ranges for a checkpoint: lowest, highest, points
        outside, points of each range.
        """
        return self._record.rows.copy()

    def restore(self, state: Array) -> None:
        """Resume the record of used ranges of a checkpoint."""
        self._record.rows[:] = state

    def _plain(self, known: Mapping[str, Any]) -> dict[str, Any]:
        """Arguments without derivatives."""
        arguments = (
            {key: known[key] for key in self.takes} | self.parameters
            if known
            else self._last
        )
        assert arguments is not None
        return {key: getattr(value, "value", value) for key, value in arguments.items()}


class BoundDispersion(NamedTuple):
    """The two closures of one correlation of dispersion, along and across the flow."""

    axial: BoundClosure
    transverse: BoundClosure

    @property
    def takes(self) -> tuple[str, ...]:
        """The arguments that one of them takes."""
        return self.axial.takes + self.transverse.takes


def named(spec: object) -> TypeGuard[Spec]:
    """Whether a value of a scene names a closure."""
    return isinstance(spec, str | Closure | ClosureFile)


def is_phase(spec: object) -> bool:
    """Whether the conductivity is that of the phase times its share of the volume,
    which is no closure.
    """
    name = spec.name if isinstance(spec, Closure) else spec
    return name in (PHASE, "phase")


def bind(
    spec: Spec, kind: str, gives: Iterable[str], base: Path = Path()
) -> BoundClosure:
    """Return the closure that a scene names, where a model gives the arguments `gives`.

    A closure's file is looked for in `base`, the folder of the scene.

    Raises
    ------
    SceneError : no such closure or file; a parameter is unknown or out of its bounds;
        an argument is missing
    """
    if isinstance(spec, ClosureFile):
        from contbed.closures.file import closure_of

        function: Function = closure_of(spec.file, base, kind)
        given = set(gives)
        if missing := [key for key in function.sheet.arguments if key not in given]:  # type: ignore[attr-defined]
            raise SceneError(
                f"{spec.file} needs {', '.join(missing)}; given here: "
                f"{', '.join(sorted(given))}"
            )
        return BoundClosure(function, {}, gives)
    name, parameters = _split(spec)
    function = registry.get(_full_name(name, kind, registry.names(kind)), kind)
    _check(name, parameters, [function], gives)
    return BoundClosure(function, parameters, gives)


def bind_dispersion(spec: str | Closure, gives: Iterable[str]) -> BoundDispersion:
    """Return the axial and the transverse closure of the dispersion that a scene
    names; raises what `bind` raises.
    """
    name, parameters = _split(spec)
    stem = _full_name(name, "dispersion", registry.dispersions())
    pair = registry.dispersion_pair(stem)
    _check(name, parameters, list(pair), gives)
    return BoundDispersion(
        *(BoundClosure(function, parameters, gives) for function in pair)
    )


def _split(spec: str | Closure) -> tuple[str, dict[str, Any]]:
    return (
        (spec, {})
        if isinstance(spec, str)
        else (spec.name, dict(spec.model_extra or {}))
    )


def _full_name(name: str, kind: str, known: tuple[str, ...] | list[str]) -> str:
    prefixed = f"{kind}_{name}"
    if name in known or name in registry.names():
        return name
    # An unknown short name is looked for with its prefix, so that the nearest names are
    # found.
    return prefixed if prefixed in known or not name.startswith(f"{kind}_") else name


def _check(
    name: str,
    parameters: Mapping[str, Any],
    functions: list[Function],
    gives: Iterable[str],
) -> None:
    sheets: list[Sheet] = [function.sheet for function in functions]  # type: ignore[attr-defined]
    options = {key: value for sheet in sheets for key, value in sheet.options.items()}
    bounds = {
        key: interval for sheet in sheets for key, interval in sheet.bounds.items()
    }
    arguments = dict.fromkeys(
        argument for sheet in sheets for argument in sheet.arguments
    )
    for key, value in parameters.items():
        if key not in options and key not in arguments:
            known = (
                ", ".join(
                    [*(key for key in arguments if key not in set(gives)), *options]
                )
                or "none"
            )
            raise SceneError(
                f"closure {name!r} has no parameter {key!r}; its parameters: {known}"
            )
        if isinstance(options.get(key), str):
            if not isinstance(value, str):
                raise SceneError(
                    f"parameter {key!r} of closure {name!r} is a text, found {value!r}"
                )
        elif (
            isinstance(value, bool)
            or not isinstance(value, (int, float))
            or not math.isfinite(value)
        ):
            raise SceneError(
                f"parameter {key!r} of closure {name!r} is a finite number in SI, "
                f"found {value!r}"
            )
        elif key in bounds and value not in bounds[key]:
            raise SceneError(
                f"parameter {key!r} of closure {name!r} is in {bounds[key].text}, "
                f"found {value!r}"
            )
        else:
            try:
                computable(value)
            except ValueError as error:
                raise SceneError(
                    f"parameter {key!r} of closure {name!r}: {error}"
                ) from None
    given = set(gives)
    if missing := [
        key for key in arguments if key not in given and key not in parameters
    ]:
        example = ", ".join(f"{key} = ..." for key in missing)
        raise SceneError(
            f'closure {name!r} needs {", ".join(missing)}: {{name = "{name}", '
            f"{example}}}; "
            f"given here: {', '.join(sorted(given)) or 'nothing'}"
        )

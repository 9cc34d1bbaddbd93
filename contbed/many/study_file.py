"""Files of studies: their tables, and every mistake with file, line, key and remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Generic, NoReturn, TypeVar

from pydantic import BaseModel

from contbed.errors import SceneError
from contbed.explain.sheets import unit
from contbed.scene.refusals import mistakes_of, table_of
from contbed.scene.toml_lines import KeyPath, dotted, one_line, parse_key, read
from contbed.scene.units import exponents, number_and_unit, unit_with
from contbed.scene.values import flat, is_constant, value_at

_Table = TypeVar("_Table", bound=BaseModel)
# takes the path below an entry, and what is wrong there
Say = Callable[[KeyPath, str], None]


class StudyFile(Generic[_Table]):
    """A file of a study as its table `settings`; further mistakes are collected by
    `say` and raised by `stop`.

    Raises
    ------
    SceneError : all mistakes of the table, each with file and line
    """

    def __init__(self, path: str | Path, model: type[_Table]):
        self.path = Path(path)
        self.values, self.origin = read(path)
        self.settings = table_of(model, self.values, self.origin)
        self.problems: list[str] = []

    def say(self, path: KeyPath, text: str, shown: str = "") -> None:
        """Note a mistake at a key, which is shown by its name in the scene where it
        has one.
        """
        self.problems.append(
            one_line(f"{self.origin.at(path)}: {shown or dotted(path)}: {text}")
        )

    def say_below(self, path: KeyPath, shown: str = "") -> Say:
        """Return a function that notes a mistake at a path below a key."""
        return lambda below, text: self.say((*path, *below), text, shown)

    def stop(self) -> None:
        """Raise SceneError with all mistakes that were noted."""
        if self.problems:
            raise SceneError(self.problems)

    def fail(self, path: KeyPath, text: str) -> NoReturn:
        """Raise SceneError with a mistake at a key, and all noted before."""
        self.say(path, text)
        raise SceneError(self.problems)

    def file(self, path: KeyPath, name: str) -> Path:
        """Return the file that a key names; one that is absent is a mistake."""
        key = str(path[-1])
        if not name:
            self.say(
                path, f'missing; give the file of the {key}, {key} = "base.toml"', key
            )
        elif not (self.origin.base / name).is_file():
            self.say(path, f'no such file: "{name}", looked for beside this file', key)
        return self.origin.base / name

    def entries(
        self,
        at: KeyPath,
        table: Mapping[str, Any],
        is_entry: Callable[[Any], bool],
        places: dict[str, str],
    ) -> Iterator[tuple[str, KeyPath, Any]]:
        """Yield dotted name, path and entry of each key of a scene below a table,
        and note its place in `places`.
        """
        for below, entry in flat(table, is_entry):
            name, path = ".".join(below), (*at, *below)
            if name in places:
                self.say(path, f"stands twice, also at {places[name]}", name)
                continue
            places[name] = self.origin.at(path)
            yield name, path, entry


def checked(model: type[_Table], entry: Mapping[str, Any], say: Say) -> _Table | None:
    """Return an entry as its table `model`; None after its mistakes were reported to
    `say`.
    """
    found = mistakes_of(model, dict(entry))
    for path, text in found:
        say(path, text)
    return None if found else model.model_validate(entry)


def unit_of(name: str, given: Any = None) -> str | None:
    """Return the SI unit of a dotted key; None if it has none or is not known.

    A constant of a formula or rate law has that of the text which its scene gives,
    "3 1/h"; a plain number has none, as it counts in the unit of the formula or in SI.
    """
    try:
        path = parse_key(name)
        if is_constant(path):
            text = isinstance(given, str)
            return unit_with(exponents(number_and_unit(given)[1])) if text else None
    except ValueError:  # the scene reports what is wrong
        return None
    return unit(path)


def unit_in(scenes: Iterable[Path], name: str) -> str | None:
    """Return the SI unit of a dotted key, see `unit_of`; that of a constant is in the
    first of some scene files that gives it, which are read for constants alone.
    """
    for scene in scenes if is_constant(parse_key(name)) else ():
        try:
            given = value_at(read(scene)[0], name)
        except (SceneError, ValueError):  # reported where the scene is loaded
            continue
        if given is not None:
            return unit_of(name, given)
    return unit_of(name)


def relocated(problem: str, places: Mapping[str, str]) -> tuple[str, str]:
    """Replace an override of a scene in a message by its key and the line of the
    study; "" where there is none.
    """
    text = problem.removeprefix("override: ")
    if text != problem:
        for name in sorted(places, key=len, reverse=True):
            if text.startswith(name):
                return name, f"{places[name]}: {text}"
    return "", problem

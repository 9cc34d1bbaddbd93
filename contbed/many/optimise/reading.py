"""Reading of a design file; mistakes are collected, each with file:line and remedy."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from contbed import fields
from contbed.errors import SceneError
from contbed.loading import load
from contbed.many.derivatives.differences import seeds
from contbed.many.optimise.bounds import DesignKey, is_range, read_key
from contbed.many.optimise.expression import Expression, read_expression
from contbed.many.optimise.problem import (
    Constraint,
    Design,
    is_key,
    plain,
    require_possible,
)
from contbed.many.quantities import unit_of_result
from contbed.many.study_file import StudyFile, relocated
from contbed.many.value_sets import MOST_RUNS
from contbed.models import model_of
from contbed.scene import schema
from contbed.scene.names import nearest_of
from contbed.scene.quantities import Table, Whole
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import KeyPath, parse_key
from contbed.scene.units import exponents, to_si
from contbed.scene.values import flat, value_at

REPEATS = 3  # of a scene with seeds, if the file does not say
_SIGN = re.compile(r"<=|>=|==|<|>|=")
Method = Literal["gradient", "surrogate"]


class Formula(Table):
    """A formula whose numbers have units of their own, such as prices."""

    formula: str
    """formula of results and keys"""
    unit: str | None = None
    """of the value; that of the parts if absent"""


def _form(value: Any) -> str:
    return "text" if isinstance(value, str) else "table"


Objective = Annotated[
    Annotated[str, Tag("text")] | Annotated[Formula, Tag("table")], Discriminator(_form)
]


class DesignTable(Table):
    """The file of a design."""

    kind: ClassVar[str] = "design"

    title: str = ""
    """title of the study, shown in plots and reports"""
    scene: str = ""
    """scene file, path relative to this file"""
    minimise: Objective | None = None
    """result or formula that is minimised"""
    maximise: Objective | None = None
    """result or formula that is maximised"""
    constraints: tuple[str, ...] = ()
    """inequalities between results, keys and numbers"""
    keys: dict[str, Any] = Field(default_factory=dict)
    """keys of the scene that are varied, each with its bounds"""
    runs: Annotated[Whole, Field(ge=1, le=MOST_RUNS)] = 200
    """most points that are computed"""
    method: Method | None = None
    """how the optimum is searched; absent: by gradients unless results scatter"""
    repeats: Annotated[Whole, Field(ge=1, le=100)] | None = None
    """seeds at a point"""


def read_design(
    path: str | Path, trust: bool = False, allow_large: bool = False
) -> Design:
    """Read a design file; flags as in `contbed.loading.load`.

    Raises
    ------
    SceneError : with file:line, all mistakes of the file, or if it has none those of
        its scene
    """
    file = StudyFile(path, DesignTable)
    settings = file.settings
    scene_file = file.file(("scene",), settings.scene)
    file.stop()
    make = partial(load, scene_file, trust=trust, allow_large=allow_large)
    scene = make()
    method = _method(file, model_of(scene).scatters)
    repeats = _repeats(file, method, bool(seeds(scene)))
    keys = _keys(file, scene)
    file.stop()
    try:
        make({key.name: plain(key, key.start) for key in keys})
    except SceneError as error:
        places = {key.name: key.at for key in keys}
        raise SceneError(
            [relocated(text, places)[1] for text in error.problems]
        ) from None
    formulas = _Formulas(file, partial(_unit, scene, {key.name: key for key in keys}))
    aim = _aim(file)
    objective = formulas.objective(aim)
    constraints = formulas.constraints()
    if method == "surrogate":
        _refuse_equalities(file, constraints)
    file.stop()
    assert objective is not None
    found = Design(
        file.path, settings.title, scene_file, scene, keys, objective, file.origin.at((aim,)), aim == "maximise",
        constraints, settings.runs, method, repeats,
    )  # fmt: skip
    require_possible(found)
    return found


def _unit(scene: SceneBase, keys: Mapping[str, DesignKey], name: str) -> str:
    """Return the unit of a name in a formula."""
    if name in keys:
        return keys[name].unit
    if is_key(name):
        path = parse_key(name)
        if not isinstance(value_at(scene, name), int | float):
            numbers = [*keys, *_numbers(scene)]
            raise SceneError(
                f"the scene has no number {name!r}; {nearest_of(name, numbers)}"
            )
        return schema.unit(schema.of(type(scene)), path) or "1"
    unit = unit_of_result(name, scene)
    if unit is None:
        raise SceneError(
            f"{name!r} is neither a named result nor a key; "
            f"{nearest_of(name, [*fields.RESULTS, *keys])}"
        )
    return unit


def _numbers(scene: SceneBase) -> list[str]:
    """Return the dotted keys of all numbers of a scene."""
    return [
        ".".join(path)
        for path, value in flat(scene.model_dump(exclude_none=True))
        if isinstance(value, int | float) and not isinstance(value, bool)
    ]


def _keys(file: StudyFile[DesignTable], scene: SceneBase) -> tuple[DesignKey, ...]:
    """Return the keys that may change."""
    table = file.settings.keys
    if not table:
        file.say(
            ("keys",),
            'missing; give bounds: [keys], mesh.length = { from = "0.2 m", to = "2 m" }',
        )
    found = []
    for name, path, entry in file.entries(("keys",), table, is_range, {}):
        key = read_key(
            name, entry, scene, file.origin.at(path), file.say_below(path, name)
        )
        if key is not None:
            found.append(key)
    return tuple(found)


def _method(file: StudyFile[DesignTable], scatters: bool) -> Method:
    """Return the method: what the file says, or by whether the results of the scene
    scatter.
    """
    given = file.settings.method
    if given == "gradient" and scatters:
        file.say(("method",), "results of particles and of two fluids scatter, so that "
                              "there are no gradients to "
                 'follow; leave it out, or give "surrogate"')  # fmt: skip
    return "surrogate" if scatters or given == "surrogate" else "gradient"


def _repeats(file: StudyFile[DesignTable], method: Method, seeded: bool) -> int:
    """Return the number of runs at a point."""
    default = REPEATS if seeded and method == "surrogate" else 1
    found = file.settings.repeats or default
    if found > 1 and method == "gradient":
        file.say(
            ("repeats",),
            'a search by gradients runs a point once; give method = "surrogate"',
        )
    elif found > 1 and not seeded:
        file.say(
            ("repeats",),
            "the scene has no seed, so that a repeated run would be the same; leave it "
            "out",
        )
    return found


def _aim(file: StudyFile[DesignTable]) -> str:
    """Return which key holds the objective.

    Raises
    ------
    SceneError : neither of them is given, or both
    """
    given = [key for key in ("minimise", "maximise") if key in file.values]
    if not given:
        file.fail(("minimise",), "missing; a result, a key, or a formula of them")
    if len(given) > 1:
        file.fail((given[-1],), "give only one of minimise and maximise")
    return given[0]


def _refuse_equalities(
    file: StudyFile[DesignTable], constraints: tuple[Constraint, ...]
) -> None:
    """Note equality constraints, which no point with scatter fulfils."""
    for one in constraints:
        if one.sign == "==":
            path: KeyPath = ("constraints", file.settings.constraints.index(one.text))
            file.say(
                path,
                f'"{one.text}": without gradients no point fulfils it; give two '
                "limits, with <= and >=",
            )


class _Formulas:
    """Reader of objective and constraints; None where they have mistakes, which are
    noted.
    """

    def __init__(self, file: StudyFile[DesignTable], unit_of: Callable[[str], str]):
        self.file, self.unit_of = file, unit_of

    def objective(self, aim: str) -> Expression | None:
        """Return the objective."""
        entry: str | Formula = getattr(self.file.settings, aim)
        if isinstance(entry, Formula):
            return self.expression((aim,), entry.formula, entry.unit)
        return self.expression((aim,), entry)

    def expression(
        self, path: KeyPath, text: str, unit: str | None = None
    ) -> Expression | None:
        """Return a formula."""
        try:
            return read_expression(text, self.unit_of, unit)
        except SceneError as error:
            self.file.say(path, f'"{text}": {error}')
            return None

    def constraints(self) -> tuple[Constraint, ...]:
        """Return all constraints."""
        found = (
            self.constraint(("constraints", k), text)
            for k, text in enumerate(self.file.settings.constraints)
        )
        return tuple(one for one in found if one is not None)

    def constraint(self, path: KeyPath, text: str) -> Constraint | None:
        """Return one constraint."""
        signs = _SIGN.findall(text)
        if len(signs) != 1 or signs[0] not in ("<=", ">=", "=="):
            what = (
                f"{text!r}: expected one of <=, >= and == between two sides, "
                '"pressure_drop_Pa <= 2 kPa"'
            )
            self.file.say(path, what)
            return None
        left_text, right_text = (side.strip() for side in text.split(signs[0]))
        left = self.expression(path, left_text)
        if left is None:
            return None
        if not left.names:
            self.file.say(
                path,
                f'"{text}": the left side is a number; begin with the result or key',
            )
            return None
        right = self.side(path, text, right_text, left.unit)
        return (
            None
            if right is None
            else Constraint(text, left, signs[0], right, self.file.origin.at(path))
        )

    def side(
        self, path: KeyPath, text: str, right: str, unit: str
    ) -> float | Expression | None:
        """Return the right side of a constraint: a quantity in the unit of the left
        side, or a formula.
        """
        try:
            return float(right)
        except ValueError:
            pass
        if right[:1].isdigit() or right[:1] in "+-.":
            try:
                return to_si(right, unit)
            except ValueError as error:
                if re.fullmatch(r"[-+.\d\s%a-zA-Z/]*", right):
                    self.file.say(path, f'"{text}": {error}')
                    return None
        found = self.expression(path, right)
        if (
            found is not None
            and found.names
            and exponents(found.unit) != exponents(unit)
        ):
            self.file.say(
                path,
                f'"{text}": the left side is in {unit}, the right one in {found.unit}',
            )
            return None
        return found

"""Scenes from TOML, text or dicts. All mistakes are collected and reported at once,
each with file, line, key and remedy.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from contbed.errors import SceneError
from contbed.models import MODELS, kind_of, names
from contbed.scene import schema
from contbed.scene.checking import mistakes
from contbed.scene.inputs import unusable_files
from contbed.scene.names import near_names, nearest
from contbed.scene.other_models import (
    bottom_of_a_bubbling_bed,
    take_keys_of_others,
)
from contbed.scene.physical import states_are_of_a_bed
from contbed.scene.property_table import files_of, read_files
from contbed.scene.refusals import line, own, translate
from contbed.scene.renames import renamed, take_former_keys
from contbed.scene.size import too_large
from contbed.scene.tables import SceneBase
from contbed.scene.toml_lines import (
    KeyPath,
    Origin,
    dotted,
    parse,
    parse_key,
    read,
)
from contbed.scene.values import at

_STUDY = "a study; run it with `contbed {} FILE`, which checks it first"
_NO_SCENE = {  # keys of other files, and what these are
    "packings": _STUDY.format("cascade"),
    "minimise": _STUDY.format("optimise"),
    "maximise": _STUDY.format("optimise"),
    "experiment": _STUDY.format("calibrate"),
    "parameters": _STUDY.format("sweep"),
    "sample": _STUDY.format("sweep"),
    "format": "a closure; name it in one, such as closures.nusselt = { file = ... }",
}


def load(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    *,
    trust: bool = False,
    allow_large: bool = False,
) -> SceneBase:
    """Return the scene of a file or of nested dicts, whose tables name its kind; see
    `contbed.models.MODELS`.

    Parameters
    ----------
    source : a TOML file, or its tables as dicts, whose files are looked for in the
        working directory
    overrides : such as {"mesh.refine": 2}, replace values before anything is checked
    trust : files that the scene names may run programs: a geometry of gmsh, a mechanism
        of Cantera
    allow_large : sizes beyond what this computer or contbed's limits hold are meant

    Raises
    ------
    SceneError : all mistakes, each with file and line
    TypeError : overrides are no mapping

    Examples
    --------
    >>> from contbed.models import MODELS
    >>> scene = load(MODELS["packed_bed"].template, {"mesh.length": "1 m"})
    >>> scene.mesh.length
    1.0
    """
    if not isinstance(overrides or {}, Mapping):
        raise TypeError(
            f'overrides = {overrides!r}: give {{"mesh.refine": 2}} or the like'
        )
    if isinstance(source, Mapping):
        values, origin = deepcopy(dict(source)), Origin("scene", Path.cwd())
    else:
        values, origin = read(source)
    return _build(
        values, replace(origin, trust=trust, allow_large=allow_large), overrides or {}
    )


def loads(
    text: str,
    name: str = "scene.toml",
    overrides: Mapping[str, Any] | None = None,
    base: str | Path = ".",
    *,
    trust: bool = False,
    allow_large: bool = False,
) -> SceneBase:
    """`load` for a TOML text; `name` stands in messages and a mesh file is looked
    for in `base`.
    """
    values, origin = parse(text, name, Path(base).absolute())
    return _build(
        values, replace(origin, trust=trust, allow_large=allow_large), overrides or {}
    )


def from_dict(
    values: Mapping[str, Any],
    name: str = "scene",
    base: str | Path = ".",
    *,
    trust: bool = False,
    allow_large: bool = False,
) -> SceneBase:
    """`load` for plain nested dicts, as `resolved` returns them."""
    origin = Origin(name, Path(base).absolute(), trust=trust, allow_large=allow_large)
    return _build(deepcopy(dict(values)), origin, {})


def _build(
    values: dict[str, Any], origin: Origin, overrides: Mapping[str, Any]
) -> SceneBase:
    problems: list[tuple[KeyPath, str]] = []
    origin = _override(values, origin, overrides, problems)
    if not values:
        raise SceneError(
            f"{origin.name}:1: the scene is empty; it needs [mesh], [gas], "
            "[solids.NAME] and [packed_bed]"
        )
    _require_a_scene(values, origin)
    _require_a_model(values, origin)
    kind = kind_of(values)
    model, checks = MODELS[kind].scene, MODELS[kind].find("checks", "CHECKS")
    tables = files_of(values)
    problems += read_files(values, origin)
    parts, broken, ignored = _validate(model, values, problems, origin.base)
    refused = [*unusable_files(parts, origin), *too_large(parts, origin)]
    problems += refused
    broken.update(str(path[0]) for path, _ in refused)
    problems += mistakes(parts, broken, origin, checks)
    if problems:
        from contbed.explain.closure_keys import right_keys

        problems = [
            (
                path,
                _in_other_models(kind, path)
                or text + right_keys(model, path, at(values, path)),
            )
            for path, text in problems
        ]
        problems.sort(key=lambda problem: origin.line(problem[0]))
        raise SceneError(line(origin, values, path, text) for path, text in problems)
    scene: SceneBase = model(
        **{name: part for name, part in parts.items() if part is not None}
    )
    scene._origin = origin
    scene._ignored = ignored
    scene._tables = tables
    remarks = mistakes(parts, set(), origin, MODELS[kind].find("checks", "WARNINGS"))
    remarks += states_are_of_a_bed(parts, origin.base)
    # a table of another model, such as [two_fluid], is meant for that
    remarks += [
        (path, "is ignored: only other models have this key")
        for path in ignored
        if len(path) > 1
    ]
    remarks += [
        (path, f"is ignored: {model.refused[str(path[0])]}")
        for path in ignored
        if path[0] in model.refused and len(path) == 1
    ]
    if "H2O" in str(getattr(parts.get("gas"), "composition", "")):
        from contbed.materials.condensation import water_condenses

        remarks += water_condenses(parts)
    remarks.sort(key=lambda remark: origin.line(remark[0]))
    scene._warnings = tuple(line(origin, values, path, text) for path, text in remarks)
    return scene


def _in_other_models(kind: str, path: KeyPath) -> str:
    """Say which models have the table that a kind of scenes does not; empty where none
    has it, or the path is no table.
    """
    scene = MODELS[kind].scene
    tables = scene.model_fields
    if len(path) != 1 or path[0] in tables or path[0] in scene.refused:
        return ""
    others = [
        name for name, each in MODELS.items() if path[0] in each.scene.model_fields
    ]
    if not others:
        return ""
    return (
        f"unknown table; {kind} does not have it, but {', '.join(sorted(others))}; "
        f"allowed: {', '.join(tables)}"
    )


def _require_a_model(values: Mapping[str, Any], origin: Origin) -> None:
    """Refuse a name of a model that does not exist, and tables of two without a name.

    Raises
    ------
    SceneError : it is not clear which model the scene is for
    """
    named = values.get("model")
    own = [name for name in names() if name != "radiation" and name in values]
    if named is None and len(own) > 1:
        tables = " and ".join(f"[{name}]" for name in own)
        raise SceneError(
            f"{origin.at((own[1],))}: {tables}: tables of several models; "
            f'say which one to run, such as model = "{own[0]}"'
        )
    if named is not None and named not in names():
        text = f"unknown choice; {nearest(str(named), names())}"
        if named in MODELS:
            kind = MODELS[named]
            text = f'write model = "{kind.name}"; it is a {named} by {kind.decides}'
        raise SceneError(line(origin, dict(values), ("model",), text))


def _schemas_of_others(model: Any) -> list[schema.Node]:
    """Return the JSON schemas of the other models; those of the same name are one."""
    own = next(each for each in MODELS.values() if each.scene is model)
    return [schema.of(each.scene) for each in MODELS.values() if each.name != own.name]


def _require_a_scene(values: Mapping[str, Any], origin: Origin) -> None:
    """Refuse a file that is meant for another place or command."""
    meant = [key for key in _NO_SCENE if key in values]
    if meant and not any(
        values.keys() & (model.scene.model_fields.keys() - {"title"})
        for model in MODELS.values()
    ):
        raise SceneError(
            f"{origin.at((meant[0],))}: {meant[0]}: this is no scene but "
            f"{_NO_SCENE[meant[0]]}"
        )


def _override(
    values: dict[str, Any],
    origin: Origin,
    overrides: Mapping[str, Any],
    problems: list[tuple[KeyPath, str]],
) -> Origin:
    """Put the overrides into `values`, creating tables on the way."""
    paths: list[KeyPath] = []
    for key, value in overrides.items():
        try:
            path = parse_key(key)
        except ValueError:
            path = (key,)
        paths.append(path)
        table: Any = values
        for step in path[:-1]:
            table = table.setdefault(step, {}) if isinstance(table, dict) else None
        if isinstance(table, dict):
            # numpy's numbers become Python's
            table[str(path[-1])] = value.item() if hasattr(value, "item") else value
        else:
            problems.append(
                (
                    path,
                    "cannot be set: one of the keys before its last dot is not a table",
                )
            )
    return replace(origin, overrides=tuple(paths))


def _validate(
    model: Any,
    values: dict[str, Any],
    problems: list[tuple[KeyPath, str]],
    folder: Path,
) -> tuple[dict[str, Any], set[str], tuple[KeyPath, ...]]:
    """Validate each table separately, so that one mistake does not hide others.

    Returns
    -------
    tables by name, the names of those with mistakes, and keys of other models
    """
    current = deepcopy(values)
    ignored: tuple[KeyPath, ...] = ()
    scene, errors = _checked(model, current, folder)
    if "model" in values and any(
        error["type"] == "extra_forbidden" for error in errors
    ):
        others = _schemas_of_others(model)
        ignored = tuple(take_keys_of_others(current, schema.of(model), others))
        ignored += bottom_of_a_bubbling_bed(current, ignored)
    former = take_former_keys(current, renamed(model.kind))
    if ignored or former:
        scene, errors = _checked(model, current, folder)
    problems += former
    if scene is not None and not former:
        return (
            {name: getattr(scene, name) for name in model.model_fields},
            set(),
            ignored,
        )
    broken = {str(path[0]) for path, _ in former}
    if former:  # what is absent may stand under a former name
        broken.update(name for name in model.model_fields if name not in current)
    parts: dict[str, Any] = {}
    for error in errors:
        path, text = translate(error, current, schema.of(model))
        if len(path) == 1 and error["type"] == "extra_forbidden":
            text = model.refused.get(str(path[0]), text)
        if error["type"].startswith("union_tag") and dotted(path) in model.refused:
            text = f"{text}; {model.refused[dotted(path)]}"
        if not (former and error["type"] == "missing"):
            problems.append((path, text))
        # A misspelt table is not an absent one: what it breaks is reported once.
        broken.update(
            {str(path[0]), *near_names(str(path[0]), list(model.model_fields))}
        )
    for name, field in model.model_fields.items():
        if name in broken:
            continue
        if name in current:
            # the annotation without its field description is all that a table needs
            parts[name] = TypeAdapter(field.rebuild_annotation()).validate_python(
                current[name], context={"folder": folder}
            )
        else:
            parts[name] = field.get_default(call_default_factory=True)
    return parts, broken, ignored


def _checked(
    model: Any, values: dict[str, Any], folder: Path
) -> tuple[Any, list[Mapping[str, Any]]]:
    """Return the scene of a file in a folder, None if the schema of its model refuses
    it, and the mistakes.
    """
    try:
        return model.model_validate(values, context={"folder": folder}), []
    except ValidationError as invalid:
        return None, own(invalid.errors(include_url=False))

"""Location of a Cantera mechanism, and whether reading it would run code; Cantera
itself is not imported.

A mechanism file can name extensions, Python modules that Cantera imports when it reads
the file.
"""

from __future__ import annotations

import os
import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

# the key as it is, or text that is written with escapes
_ALIAS = re.compile(rb"(?:^|[\s\[{,:-])\*\w")
_ANCHOR = re.compile(rb"(?:^|[\s\[{,:-])&\w")
# nodes in memory for each that is written
MOST_COPIES = 100
MECHANISM = (".yaml", ".yml")
# Cantera's programs for mechanisms of CHEMKIN and of its own older versions
CONVERTERS = {".inp": "ck2yaml --input=", ".cti": "cti2yaml ", ".xml": "ctml2yaml "}
_EXTENSIONS = re.compile(rb"extensions|\\")


def changed_at(mechanism: str) -> int:
    """Return when the file of a mechanism was changed [ns]; 0 of Cantera's own."""
    path = Path(mechanism)
    return path.stat().st_mtime_ns if path.is_file() else 0


def mechanism_folders(base: Path) -> list[Path]:
    """Return the folders searched for a mechanism, in order: beside the scene, then
    Cantera's own.
    """
    named = os.environ.get("CANTERA_DATA", "")
    folders = [
        base,
        Path(),
        *(Path(folder) for folder in named.split(os.pathsep) if folder),
    ]
    spec = find_spec("cantera")
    if spec is not None and spec.submodule_search_locations:
        folders += [Path(folder) / "data" for folder in spec.submodule_search_locations]
    return folders


def mechanism_file(name: str, base: Path) -> Path | None:
    """Return the file of a mechanism; None if there is none."""
    if "\0" in name:
        return None
    return next(
        (
            folder / name
            for folder in mechanism_folders(base)
            if (folder / name).is_file()
        ),
        None,
    )


def find_mechanism(name: str, base: Path) -> str:
    """Return the path of a mechanism for Cantera, or its name where no such file is
    found.
    """
    path = mechanism_file(name, base)
    return name if path is None else str(path.absolute())


def aliases_that_multiply(path: Path) -> str:
    """Return what in a mechanism file would grow beyond all memory when it is read:
    aliases of aliases; empty if nothing does.
    """
    data = path.read_bytes()
    if _ALIAS.search(data) is None or _ANCHOR.search(data) is None:
        return ""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        node = YAML(typ="safe", pure=True).compose(data)
    except YAMLError:
        return ""  # whoever reads it says so
    written: dict[int, int] = {}
    if node is None or _expanded(node, written) <= MOST_COPIES * len(written):
        return ""
    return f"{path.name}: aliases of aliases multiply to more than a computer holds"


def _expanded(node: Any, known: dict[int, int]) -> int:
    """Return the number of nodes below one of a YAML file, those of aliases counted
    each time; `known` are the numbers of those that are written.
    """
    if id(node) in known:
        return known[id(node)]
    known[id(node)] = 1
    children = node.value if isinstance(node.value, list) else []
    for child in children:
        for each in child if isinstance(child, tuple) else (child,):
            known[id(node)] += _expanded(each, known)
    return known[id(node)]


def other_format(path: Path) -> str:
    """Return that a mechanism is no YAML file, and what converts it; empty if it is
    one.
    """
    suffix = path.suffix.lower()
    if suffix in MECHANISM:
        return ""
    text = f"{path.name}: a mechanism is a YAML file of Cantera"
    command = CONVERTERS.get(suffix)
    return f"{text}; convert it: {command}{path.name}" if command else text


def code_in_mechanism(path: Path) -> str:
    """Return what in a mechanism file would run code, with its line; empty if
    nothing does.
    """
    data = path.read_bytes()
    if b"\0" in data:
        return f"{path.name}: no UTF-8 text"
    found = _EXTENSIONS.search(data)
    if found is None:
        return ""
    line = data.count(b"\n", 0, found.start()) + 1
    try:
        from ruamel.yaml import YAML

        content = YAML(typ="safe", pure=True).load(data)
    # of many kinds; what cannot be read here is not known to be safe
    except Exception as error:
        return (
            f"{path.name}:{line}: cannot be looked through: "
            f"{' '.join(str(error).split())}"
        )
    if isinstance(content, dict) and "extensions" not in content:
        return ""
    return f"{path.name}:{line}: extensions import Python modules"

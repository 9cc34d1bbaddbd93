"""Scan of gmsh geometries for commands that do more than make a mesh, without running them.

The language of .geo files can start programs, write and delete files and read any other file. The scan reads the words
of a file as gmsh's own scanner does (src/parser/Gmsh.l) and looks for the commands of src/parser/Gmsh.y that do so.
Three features of gmsh would escape a scan that only leaves out comments and strings, and are taken into account:

* loops, macros and included files continue at the start of a line, so the inside of a comment or string of several
  lines may run: where a file has such jumps each of its lines is also read by itself;
* options in a file of the same name with .opt are read with a geometry, as commands;
* a string of 1023 characters or more ends there, and its rest is read as commands: such a string is refused.

A name that is put together at run time cannot be known here: such names are refused where they matter.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

LONGEST_STRING = 1022  # characters that gmsh takes as one string

_COMMANDS = {
    "System": "runs a program",
    "SystemCall": "runs a program",
    "NonBlockingSystemCall": "runs a program",
    "OnelabRun": "runs a program",
    "ExternalProcess": "runs a program",
    "CommandLine": "names a program to run",
    "Solver": "names programs to run",
    "Plugin": "runs a plugin, which may write files",
    "Save": "writes a file",
    "Print": "writes a file",
    "SendToServer": "sends data to another program",
    "CreateDir": "makes a folder",
    "Exit": "ends the program that reads it",
    "Sleep": "makes the program that reads it wait",
    "StringToName": "makes a command from a text",
    "S2N": "makes a command from a text",
}
_READS = ("Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile", "ListFromFile")
_REDIRECTED = ("Printf", "Error", "Warning")
_JUMPS = re.compile(r"For|Macro|Function|Call|Include|Merge")
# formats that gmsh knows by the end of the name and that hold no commands; all other files may be read as commands
_DATA = {
    *(".step", ".stp", ".iges", ".igs", ".brep", ".brp", ".stl", ".xao", ".unv", ".vtk", ".obj", ".off", ".ply"),
    *(".med", ".cgns", ".mesh", ".bdf", ".nas"),
}
_SCRIPTS = {".geo", ".geo_unrolled", ".msh", ".pos", ".txt", ".dat", ".inc", ".i", ".opt", ""}
_WORD = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?(?:\*/|\Z))
      | (?P<text>"[^"]*(?:"|\Z)|'[^']*(?:'|\Z))
      | (?P<name>[A-Za-z_][A-Za-z_0-9]*)
      | (?P<number>[0-9]+\.?[0-9]*(?:[Ee][-+]?[0-9]+)?|\.[0-9]+(?:[Ee][-+]?[0-9]+)?)
      | (?P<other>>>|\S)""",
    re.DOTALL | re.VERBOSE,
)


@dataclass
class Scan:
    """Files that a geometry reads, itself first, and what is not safe in them, each "file:line: what"."""

    inputs: list[Path] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Word:
    kind: str
    text: str
    line: int


def scan(path: Path, folder: Path | None = None) -> Scan:
    """Scan a geometry and all that it includes; files outside of `folder`, its own if absent, are problems."""
    found = Scan()
    _scan(path, (folder or path.parent).resolve(), found)
    options = path.with_name(path.name + ".opt")
    if options.is_file():
        _scan(options, (folder or path.parent).resolve(), found)
    found.problems = list(dict.fromkeys(found.problems))
    return found


def _scan(path: Path, folder: Path, found: Scan) -> None:
    found.inputs.append(path)
    try:
        text = path.read_bytes().decode("latin-1")
    except OSError as error:
        found.problems.append(f"{path}: cannot be read: {error.strerror or error}")
        return
    where = path.name if path.resolve().parent == folder else str(path)
    if "\0" in text:
        found.problems.append(f"{where}:{_line(text, text.index(chr(0)))}: a zero byte, which ends texts too early")
        return
    for words in _readings(text):
        for place, problem in _unsafe(words):
            found.problems.append(f"{where}:{place}: {problem}")
        for line, command, name in _files_read(words):
            _follow(path, folder, found, f"{where}:{line}: {command}", name)


def _readings(text: str) -> Iterator[list[_Word]]:
    """Yield the words of a text, and those of each line by itself where gmsh may jump to the start of a line."""
    text = text.replace("\r\n", "\n")
    whole = _words(text, 1)
    yield whole
    if "\r" in text:  # gmsh's scanner and its comments differ on where such a line ends
        yield _words(text.replace("\r", "\n"), 1)
    if _JUMPS.search(text):
        yield [word for number, line in enumerate(re.split(r"\n|\r", text), 1) for word in _words(line, number)]


def _words(text: str, first: int) -> list[_Word]:
    words, line, at = [], first, 0
    for match in _WORD.finditer(text):
        line += text.count("\n", at, match.start())
        at = match.start()
        if match.lastgroup != "comment":
            words.append(_Word(str(match.lastgroup), match.group(), line))
    return words


def _unsafe(words: list[_Word]) -> Iterator[tuple[int, str]]:
    """Yield line and description of the commands that do more than make a mesh."""
    for index, word in enumerate(words):
        before = words[index - 1].text if index else ""
        after = words[index + 1].text if index + 1 < len(words) else ""
        if word.kind == "text" and len(word.text) - 2 > LONGEST_STRING:
            yield word.line, f"a text of {len(word.text) - 2} characters, of which gmsh runs the end as commands"
        elif word.kind == "text" and word.text[1:-1] == "ExternalProcess":
            yield word.line, "ExternalProcess runs a program"
        elif word.kind != "name":
            continue
        elif before == "." and word.text.endswith("FileName"):
            yield word.line, f"the option {word.text} names a file to read, write or delete"
        elif word.text in _COMMANDS and (word.text == "CommandLine" or before != "."):
            if word.text == "Print" and after == ".":  # the options of pictures
                continue
            yield word.line, f"{word.text} {_COMMANDS[word.text]}"
        elif word.text in _REDIRECTED and _behind(words, index + 1) in (">", ">>"):
            yield word.line, f"{word.text} writes into a file"


def _behind(words: list[_Word], opening: int) -> str:
    """Return the word behind the parenthesis that closes the one at `opening`."""
    depth = 0
    for index in range(opening, len(words) - 1):
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(words[index].text, 0)
        if depth <= 0:
            return words[index + 1].text
    return ""


def _files_read(words: list[_Word]) -> Iterator[tuple[int, str, str | None]]:
    """Yield line, command and name of each file that is read; None for a name that is not one plain text."""
    for index, word in enumerate(words):
        if word.kind != "name" or word.text not in _READS or (index and words[index - 1].text == "."):
            continue
        rest = words[index + 1 : index + 4]
        if rest and rest[0].text in ("(", "["):
            rest = rest[1:]
        plain = len(rest) > 1 and rest[0].kind == "text" and rest[1].text in (";", ")", "]")
        yield word.line, word.text, rest[0].text[1:-1] if plain else None


def _follow(path: Path, folder: Path, found: Scan, what: str, name: str | None) -> None:
    """Scan a file that another one reads."""
    if name is None:
        found.problems.append(f"{what} of a name that is put together while it runs")
        return
    target = path.parent / name
    ending = target.suffix.lower()
    if not target.resolve().is_relative_to(folder):
        found.problems.append(f"{what} of {name!r}, which is outside of the scene's folder")
    elif ending not in _DATA | _SCRIPTS:
        found.problems.append(f"{what} of {name!r}, which gmsh may hand to another program")
    elif not target.is_file():
        return  # gmsh says so
    elif target not in found.inputs:
        if ending in _DATA:
            found.inputs.append(target)
        else:
            _scan(target, folder, found)


def _line(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1

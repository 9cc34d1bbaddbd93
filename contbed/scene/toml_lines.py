"""TOML with line numbers: tomllib gives the values, a small scanner gives the line
of every key.
"""

from __future__ import annotations

import json
import re
import stat
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contbed.errors import SceneError

KeyPath = tuple[str | int, ...]
_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BLANK = re.compile(r"[ \t]*")
_STRINGS = [
    re.compile(r'"""(?:[^\\]|\\.)*?"{3,5}', re.DOTALL),
    re.compile(r"'''.*?'{3,5}", re.DOTALL),
    re.compile(r'"(?:[^"\\\n]|\\.)*"'),
    re.compile(r"'[^'\n]*'"),
]
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}#\n]*")
_LONGEST = 20_000_000  # bytes of a TOML file
_TWICE = re.compile(r"Cannot declare \((.+)\) twice")
_HEADER = re.compile(r"\s*\[([\w.-]+)\]")
_BRACES = re.compile(r"\s*([\w.-]+)\s*=\s*\{")
_DUPLICATE = re.compile(r"Cannot (?:overwrite a value|mutate immutable namespace)")


@dataclass(frozen=True)
class Origin:
    """Where the values of a scene come from; it is ignored in comparisons, so equal
    values are equal scenes.
    """

    name: str = field(default="scene", compare=False)
    base: Path = field(default=Path(), compare=False)
    lines: Mapping[KeyPath, int] = field(default_factory=dict, compare=False)
    overrides: tuple[KeyPath, ...] = field(default=(), compare=False)
    # files of the scene may run programs
    trust: bool = field(default=False, compare=False)
    # a size above the default limit is intended
    allow_large: bool = field(default=False, compare=False)

    def line(self, path: KeyPath) -> int:
        """Return the line of a key, or of the nearest table around it; 0 where an
        override has set it.
        """
        for key in self.overrides:
            if path[: len(key)] == key or (
                key[: len(path)] == path and path not in self.lines
            ):
                return 0
        return next(
            (
                self.lines[path[:end]]
                for end in range(len(path), 0, -1)
                if path[:end] in self.lines
            ),
            1,
        )

    def at(self, path: KeyPath) -> str:
        """Return "file:line" of a key, or "override"."""
        line = self.line(path)
        return f"{self.name}:{line}" if line else "override"

    def place(self, path: KeyPath) -> str:
        """Return "file:line: key", as messages begin."""
        return f"{self.at(path)}: {dotted(path)}"

    @contextmanager
    def blamed(self, *path: str) -> Iterator[None]:
        """Put the place of a key before errors of what it names, such as a file."""
        try:
            yield
        except SceneError as error:
            where = f"{self.place(path)}: "
            raise SceneError(
                [
                    text
                    if text.startswith((f"{self.name}:", "override"))
                    else where + text
                    for text in error.problems
                ]
            ) from None


def parse(text: str, name: str, base: Path = Path()) -> tuple[dict[str, Any], Origin]:
    """Return the values of a TOML text and where they stand; raise SceneError with
    file:line if it is not TOML.
    """
    text = text.replace("\r\n", "\n")
    try:
        values = tomllib.loads(text)
        lines = key_lines(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(_syntax(str(error), text, name)) from None
    except ValueError:
        long = re.search(r"\d{4301}", text)
        line = text.count("\n", 0, long.start()) + 1 if long else 1
        raise SceneError(
            f"{name}:{line}: an integer with more than 4300 digits"
        ) from None
    except RecursionError:
        raise SceneError(f"{name}:1: arrays or tables are nested too deeply") from None
    return values, Origin(name, base, lines)


def read(path: str | Path) -> tuple[dict[str, Any], Origin]:
    """Read a TOML file like `parse`; raise SceneError if it cannot be read."""
    path = Path(path)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode) and not stat.S_ISDIR(status.st_mode):
            raise SceneError(f"{path}:1: is a pipe or a device; give a file")
        if status.st_size > _LONGEST:
            raise SceneError(
                f"{path}:1: {status.st_size / 1e6:.0f} MB; a TOML file has at most "
                f"{_LONGEST / 1e6:.0f} MB"
            )
        data = path.read_bytes()
    except FileNotFoundError:
        raise SceneError(f"{path}:1: no such file") from None
    except IsADirectoryError:
        raise SceneError(
            f"{path}:1: is a directory; give the TOML file in it"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(one_line(f"{path}:1: cannot be read: {reason}")) from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(
            f"{path}:{line}: not UTF-8 text (byte 0x{data[error.start]:02x}); save it "
            "as UTF-8"
        ) from None
    return parse(text, str(path), path.absolute().parent)


def dotted(path: KeyPath) -> str:
    """Return a key path as it is written in TOML: boundary.left.gas, mesh.cells[1]."""
    shown = ""
    for key in path:
        if isinstance(key, int):
            shown += f"[{key}]"
        else:
            shown += ("." if shown else "") + (
                key if BARE_KEY.fullmatch(key) else json.dumps(key)
            )
    return shown


def one_line(text: str) -> str:
    """Return the text without line breaks, control characters and the like."""
    return "".join(letter if letter.isprintable() else " " for letter in text)


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line, from 1, of every key, table header and array item of a valid
    TOML text.
    """
    return _Scanner(text).lines


def parse_key(text: str) -> KeyPath:
    """Return a dotted key, quotes allowed, as a path; raise ValueError if it is not
    one.
    """
    scanner = _Scanner(text, scan=False)
    path = scanner.key()
    if scanner.position != len(text) or len(path) != scanner.dots + 1:
        raise ValueError(f"not a dotted key: {text!r}")
    return path


def _syntax(message: str, text: str, name: str) -> str:
    found = re.search(
        r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)", message
    )
    line = int(found[1]) if found and found[1] else text.rstrip("\n").count("\n") + 1
    if found:
        message = message[: found.start()]
    if _DUPLICATE.match(message):
        message = "this key stands twice in its table"
    if twice := _TWICE.match(message):
        message = _table_twice(re.findall(r"'([^']*)'", twice[1]), text)
    return one_line(
        f"{name}:{line}: not valid TOML: {message[:1].lower()}{message[1:]}"
    )


def _table_twice(path: list[str], text: str) -> str:
    """Return what is wrong with the header of a table that tomllib has seen before: it
    stands twice, or a table around it is written in braces, which are complete.
    """
    table, header = ".".join(path), ""
    for line in text.splitlines():
        if found := _HEADER.match(line):
            header = f"{found[1]}."
        elif found := _BRACES.match(line):
            outer = header + found[1]
            if f"{table}.".startswith(f"{outer}."):
                return (
                    f"{outer} = {{...}} is complete and [{table}] cannot add to it; "
                    f"write [{outer}] in place of the braces"
                )
    return f"the table [{table}] stands twice"


class _Scanner:
    """One pass over text that tomllib has accepted, so that no error handling is
    needed.
    """

    def __init__(self, text: str, scan: bool = True):
        self.text = text
        self.position = 0
        self.dots = 0
        self.counted = (0, 1)
        self.lines: dict[KeyPath, int] = {}
        self.arrays: dict[KeyPath, int] = {}
        if scan:
            self.document()

    def document(self) -> None:
        table: KeyPath = ()
        while True:
            self.skip(_SPACE)
            if self.position >= len(self.text):
                return
            if self.text[self.position] == "[":
                table = self.header()
            else:
                self.pair(table)

    def skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.position)
        if not match:
            return ""
        self.position = match.end()
        return match.group()

    def note(self, path: KeyPath) -> None:
        position, line = self.counted
        line += self.text.count("\n", position, self.position)
        self.counted = (self.position, line)
        for end in range(1, len(path) + 1):
            self.lines.setdefault(path[:end], line)

    def header(self) -> KeyPath:
        double = self.text.startswith("[[", self.position)
        self.position += 2 if double else 1
        # A parent that is an array of tables means its latest item.
        path: KeyPath = ()
        keys = self.key()
        for key in keys[:-1]:
            path += (key,)
            if path in self.arrays:
                path += (self.arrays[path],)
        path += keys[-1:]
        if double:
            self.arrays[path] = self.arrays.get(path, -1) + 1
            path += (self.arrays[path],)
        self.note(path)
        # A header is the best place to point at, even if a table below it came first.
        self.lines[path] = self.counted[1]
        self.position += 2 if double else 1
        return path

    def key(self) -> KeyPath:
        path: KeyPath = ()
        while True:
            self.skip(_BLANK)
            if self.text.startswith(('"', "'"), self.position):
                path += (self.unquoted(),)
            else:
                path += tuple(filter(None, [self.skip(BARE_KEY)]))
            self.skip(_BLANK)
            if not self.text.startswith(".", self.position):
                return path
            self.position += 1
            self.dots += 1

    def unquoted(self) -> str:
        quoted = self.skip(_STRINGS[2]) or self.skip(_STRINGS[3])
        if not quoted:
            self.position += 1
            return ""
        return str(tomllib.loads(f"key = {quoted}")["key"])

    def pair(self, table: KeyPath) -> None:
        path = table + self.key()
        self.note(path)
        self.position += 1  # the equals sign
        self.value(path)

    def value(self, path: KeyPath) -> None:
        self.skip(_SPACE)
        opening = self.text[self.position]
        if opening in "\"'":
            any(self.skip(pattern) for pattern in _STRINGS)
        elif opening in "[{":
            self.collection(path, opening)
        else:
            self.skip(_SCALAR)

    def collection(self, path: KeyPath, opening: str) -> None:
        self.position += 1
        item = 0
        while True:
            self.skip(_SPACE)
            if self.text[self.position] in "]}":
                self.position += 1
                return
            if self.text[self.position] == ",":
                self.position += 1
            elif opening == "{":
                self.pair(path)
            else:
                self.note((*path, item))
                self.value((*path, item))
                item += 1

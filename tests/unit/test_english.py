"""Words and phrases that the package and its manual do not use, each with the plain
one that takes its place.
"""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

import contbed

PACKAGE = Path(contbed.__file__).parent
DOCS = PACKAGE.parent / "docs"
INSTEAD = {
    r"told": "reported, warned, called with",
    r"tells?": "says, reports, determines",
    r"(goes|go) on": "resumes, continues",
    r"lies? at rest": "is stationary",
    r"kinds? of particles": "solid phases",
    r"film alone": "external film only",
    r"inside of (the )?particles": "intraparticle",
    r"first rank": "rank 0",
    r"without a word": "silently",
    r"takes? no part": "is ignored",
    r"(read )?once more": "again",
    r"what is held": "content",
    r"of those of": "name the thing",
    r"whole numbers?": "integers",
    r"as such": "itself, unchanged",
    r"by itself": "alone, separately, stand-alone",
    r"what is not there": "absent",
    r"what there is": "amount",
    r"to and fro": "in both directions",
    r"cells that follow": "adaptive cells",
    r"halves of halves": "repeatedly bisected",
    r"from there on": "beyond",
}
FORBIDDEN = re.compile("|".join(rf"\b{phrase}\b" for phrase in INSTEAD), re.IGNORECASE)


def prose_of(path: Path) -> list[tuple[int, str]]:
    """Return the lines and texts of comments, docstrings and messages of a file;
    names in backticks are left out.
    """
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        found = list(enumerate(source.splitlines(), 1))
    else:
        found = [
            (node.lineno, node.value)
            for node in ast.walk(ast.parse(source))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        tokens = tokenize.generate_tokens(io.StringIO(source).readline)
        found += [
            (token.start[0], token.string)
            for token in tokens
            if token.type == tokenize.COMMENT
        ]
    return [(line, re.sub(r"`[^`]*`", "", text)) for line, text in found]


def test_phrases_are_found():
    assert FORBIDDEN.search("A warning is told\nwithout a word")
    assert not FORBIDDEN.search("retold, goes one way")


FILES = [
    *PACKAGE.rglob("*.py"),
    *DOCS.glob("*.md"),
    *DOCS.glob("howto/*.md"),
    *DOCS.glob("tutorial/*.md"),
    DOCS.parent / "CONTRIBUTING.md",
]


@pytest.mark.parametrize(
    "folder",
    sorted({path.parent.relative_to(PACKAGE.parent).as_posix() for path in FILES}),
)
def test_plain_words(folder):
    wrong = []
    for path in FILES:
        if path.parent != PACKAGE.parent / folder:
            continue
        for line, text in prose_of(path):
            for match in FORBIDDEN.finditer(" ".join(text.split())):
                wrong.append(f"{path.name}:{line}: {match[0]}")
    assert wrong == []

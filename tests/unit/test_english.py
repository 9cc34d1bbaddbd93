"""Words and phrases that the package and its manual do not use, each with the plain
one that takes its place; articles and doubled words.
"""

import ast
import io
import re
import tokenize
from functools import cache
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


@cache
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
    *DOCS.glob("[!_g]*/*.md"),
    *PACKAGE.parent.glob("*.md"),
]
STUDIES = [*(PACKAGE.parent / "studies").glob("**/README.md")]
DOUBLED = re.compile(
    r"\b(a|an|and|by|for|in|is|of|or|the|to|with)(?: |\n\s*)\1\b", re.IGNORECASE
)
ARTICLE = re.compile(r"(?<![\w./'-])(a [aeio][a-z]{2,}|an [bcdfgjkpqtvwz][a-z]{2,})\b")
# a word that sounds unlike its letter, or a symbol called a
BEFORE_A = re.compile(r"a (?:one|once|and|are)\b")


def faults_of(text: str) -> list[str]:
    """Return doubled words and wrong articles of a text."""
    found = [match[0] for match in DOUBLED.finditer(text)]
    articles = [match[0] for match in ARTICLE.finditer(text)]
    return found + [each for each in articles if not BEFORE_A.match(each)]


FOLDERS = sorted({path.parent.relative_to(PACKAGE.parent).as_posix() for path in FILES})


@pytest.mark.parametrize("folder", FOLDERS)
def test_plain_words(folder):
    wrong = []
    for path in FILES:
        if path.parent != PACKAGE.parent / folder:
            continue
        for line, text in prose_of(path):
            for match in FORBIDDEN.finditer(" ".join(text.split())):
                wrong.append(f"{path.name}:{line}: {match[0]}")
    assert wrong == []


def test_faults_are_found():
    assert faults_of("It separates the the bed by a oven and an valve") == [
        "the the",
        "a oven",
        "an valve",
    ]
    assert faults_of("the separate vessel: a one-way valve, an oven") == []


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=str(path.relative_to(PACKAGE.parent))) for path in STUDIES],
)
def test_articles_of_studies(path):
    assert [
        f"{line}: {fault}" for line, text in prose_of(path) for fault in faults_of(text)
    ] == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_articles(folder):
    wrong = [
        f"{path.name}:{line}: {fault}"
        for path in FILES
        if path.parent == PACKAGE.parent / folder
        for line, text in prose_of(path)
        for fault in faults_of(text)
    ]
    assert wrong == []

"""Equations as docstrings write them, `d(eps rho h)/dt + div(G h) = h a (T_s - T_f)`, as TeX for the manual.

A docstring stays the one source of an equation; this module only sets it. What it cannot read is shown as it stands.
"""

from __future__ import annotations

import re

GREEK = {
    "alpha": r"\alpha", "beta": r"\beta", "gamma": r"\gamma", "delta": r"\delta", "eps": r"\varepsilon", "eta": r"\eta",
    "theta": r"\theta", "Theta": r"\Theta", "kappa": r"\kappa", "lambda": r"\lambda", "mu": r"\mu", "nu": r"\nu",
    "pi": r"\pi", "rho": r"\rho", "sigma": r"\sigma", "tau": r"\tau", "phi": r"\phi", "Phi": r"\Phi", "psi": r"\psi",
    "omega": r"\omega", "xi": r"\xi", "chi": r"\chi", "Delta": r"\Delta", "inf": r"\infty", "Sigma": r"\Sigma",
}  # fmt: skip
OPERATORS = {"grad": r"\nabla", "div": r"\nabla\cdot", "lap": r"\nabla^2", "int": r"\int", "sum": r"\sum"}
SYMBOLS = {"cp", "dp", "gs"}  # of two letters, which are no words
FUNCTIONS = {"exp", "ln", "log", "sin", "cos", "tan", "tanh", "sinh", "cosh", "min", "max", "erf", "erfc", "arctan"}
RELATIONS = {
    "<=": r"\le",
    ">=": r"\ge",
    "->": r"\to",
    "<->": r"\leftrightarrow",
    "+-": r"\pm",
    "~": r"\sim",
    "<": "<",
    ">": ">",
}
CLOSING = {"(": ")", "[": "]"}
_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+\.?\d*(?:e[+-]?\d+)?)|(?P<name>[A-Za-z]+\d?(?:_[A-Za-z0-9]+(?:,[A-Za-z]\b)?)*'*)"
    r"|(?P<sign><->|<=|>=|->|\+-|\.\.\.|_[A-Za-z0-9]+|[-+*/^=()\[\],:.|<>~'!]))"
)
_PARTIAL = re.compile(r"\bd ?([A-Za-z]+\d?(?:_[A-Za-z0-9]+)*)/d([a-z])\b")
_WORDS = re.compile(r"\b[a-z]{2,}(?:'s)?(?: [a-z]{2,}(?:'s)?)+\b(?![_(])")
_PROSE = re.compile(
    r"(?:,\s+| )((?:(?:which|where|with|without|an?|of|on|the|is|in|n|at|else|up|then|for|not|outward|from|upward"
    r"|downward|or|and|to) )+[A-Za-z][A-Za-z' ]+)$"
)
_MATERIAL = re.compile(r"\bD ([A-Za-z]+(?:_[A-Za-z0-9]+)*)/dt\b")


class Unreadable(ValueError):
    """A text is no equation that can be set."""


def equations(lines: list[str]) -> list[str]:
    """Return the TeX of the equations of an indented block; continued lines are joined to the one before.

    Raises
    ------
    Unreadable : a line is no equation
    """
    base = min(len(line) - len(line.lstrip()) for line in lines)
    joined: list[str] = []
    for line in lines:
        text = line[base:]
        starts = len(text) - len(text.lstrip())
        continues = re.match(r"[-+*/] ", text.strip()) or (joined and re.search(r"[-+*/=]$", joined[-1]))
        if joined and (continues or (starts >= 8 and "=" not in text.split("  ")[0])):
            joined[-1] += " " + text.strip()
        else:
            joined.append(text.strip())
    return [line_of(text) for text in joined]


def line_of(text: str) -> str:
    """Return the TeX of one line: formulas and remarks, which two or more blanks part."""
    # columns of equals signs are aligned with blanks
    text = re.sub(r"\s{2,}([-+=<>] )", r" \1", text)
    found = []
    for part in re.split(r"\s{2,}", text.strip()):
        if re.search(r"[=<>]|->", part):
            found += [_clause(clause) for clause in re.split(r",\s+(?=[^()]*[=<>])", part)]
        else:
            found.append(rf"\text{{{_escaped(part)}}}")
    return r" \qquad ".join(found)


def _clause(text: str) -> str:
    """Return the TeX of one formula, with a place before a colon, "z = 0:", and a text behind it kept as such."""
    place, colon, rest = text.partition(": ")
    if colon and len(place) < 12:
        return rf"{_clause(place)}: \quad {_clause(rest)}"
    words = _PROSE.search(text)
    if words:
        return rf"{formula(text[: words.start()])} \quad \text{{{_escaped(words[1])}}}"
    return formula(text)


def _escaped(text: str) -> str:
    return re.sub(r"([_#$%&{}^])", r"\\\1", text.replace("\\", ""))


def formula(text: str) -> str:
    """Return the TeX of a formula.

    Raises
    ------
    Unreadable : brackets do not close or a sign is not known
    """
    words: list[str] = []

    def keep(match: re.Match[str]) -> str:
        known = {*GREEK, *OPERATORS, *FUNCTIONS, *SYMBOLS}
        if any(word in known for word in match[0].split()):
            return match[0]
        words.append(match[0])
        return f"WORDSX{chr(64 + len(words))}"

    text = _WORDS.sub(keep, text)
    text = _MATERIAL.sub(r"MATERIALX(\1)", text)
    text = _PARTIAL.sub(r"PARTIALX(\1)(\2)", text)
    text = _with_groups(text)
    tokens: list[tuple[str, str]] = []
    position = 0
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if match is None:
            raise Unreadable(text)
        tokens.append((match.lastgroup or "", match[match.lastgroup or ""]))
        position = match.end()
    items, rest = _items(tokens, 0, None)
    if rest != len(tokens):
        raise Unreadable(text)
    found = _joined(items)
    for k, run in enumerate(words):
        found = found.replace(rf"\mathrm{{WORDSX{chr(65 + k)}}}", rf"\text{{ {_escaped(run)} }}")
    return found


def _with_groups(text: str) -> str:
    """Mark the partial derivatives of brackets, d(...)/dt, as functions of two arguments."""
    while (found := re.search(r"\bd\(", text)) is not None:
        depth = 0
        for k in range(found.end() - 1, len(text)):
            depth += {"(": 1, ")": -1}.get(text[k], 0)
            if depth == 0:
                break
        tail = re.match(r"\)/d([a-z])\b", text[k:])
        if tail is None:
            return text
        text = f"{text[: found.start()]}PARTIALX({text[found.end() : k]})({tail[1]}){text[k + tail.end() :]}"
    return text


Item = tuple[str, str]


def _items(tokens: list[tuple[str, str]], k: int, close: str | None) -> tuple[list[Item], int]:
    """Return the items up to a closing bracket: ("atom", TeX), ("group", TeX inside of brackets), ("sign", TeX)."""
    items: list[Item] = []
    while k < len(tokens):
        kind, text = tokens[k]
        if kind == "sign" and text == close:
            return items, k + 1
        if kind == "sign" and text in CLOSING:
            inner, k = _items(tokens, k + 1, CLOSING[text])
            items.append(("group" if text == "(" else "square", _joined(inner)))
            continue
        if kind == "sign" and text == "^":
            power, k = _power(tokens, k + 1)
            if not items or items[-1][0] == "sign":
                raise Unreadable("a power without a base")
            items[-1] = ("atom", f"{_plain(items[-1])}^{{{power}}}")
            continue
        if kind == "name" and text in ("PARTIALX", "MATERIALX"):
            what, k = _items(tokens, k + 2, ")")
            if text == "MATERIALX":
                items.append(("atom", rf"\frac{{D {_joined(what)}}}{{D t}}"))
                continue
            by, k = _items(tokens, k + 1, ")")
            inside = _joined(what)
            shown = inside if len(what) == 1 else rf"\left({inside}\right)"
            items.append(("atom", rf"\frac{{\partial {shown}}}{{\partial {_joined(by)}}}"))
            continue
        if kind == "name" and text == "sqrt" and k + 1 < len(tokens) and tokens[k + 1][1] == "(":
            inner, k = _items(tokens, k + 2, ")")
            items.append(("atom", rf"\sqrt{{{_joined(inner)}}}"))
            continue
        k += 1
        if kind == "number":
            items.append(("atom", _number(text)))
        elif kind == "name":
            items.append(_name(text))
        elif text == ".":
            items.append(("sign", r"\cdot"))
        elif text == "...":
            items.append(("sign", r"\dots"))
        elif text.startswith("_"):
            if not items or items[-1][0] == "sign":
                raise Unreadable("an index without a symbol")
            items[-1] = ("atom", f"{_plain(items[-1])}_{{{_subscript(text[1:])}}}")
        elif text == "'":
            if not items:
                raise Unreadable("a prime without a symbol")
            items[-1] = ("atom", f"{_plain(items[-1])}'")
        elif text in ")]":
            raise Unreadable("a bracket that was not opened")
        else:
            items.append(("sign", RELATIONS.get(text, r"\," if text == "*" else text)))
    if close is not None:
        raise Unreadable("a bracket does not close")
    return items, k


def _power(tokens: list[tuple[str, str]], k: int) -> tuple[str, int]:
    """Return an exponent, without its brackets."""
    if k >= len(tokens):
        raise Unreadable("a power without exponent")
    kind, text = tokens[k]
    if text == "(":
        inner, k = _items(tokens, k + 1, ")")
        return _joined(inner), k
    if text == "-" and k + 1 < len(tokens):
        rest, k = _power(tokens, k + 1)
        return f"-{rest}", k
    return (_number(text) if kind == "number" else _plain(_name(text))), k + 1


def _number(text: str) -> str:
    mantissa, e, power = text.partition("e")
    return rf"{mantissa} \cdot 10^{{{int(power)}}}" if e else mantissa


def _name(text: str) -> Item:
    primes = len(text) - len(text.rstrip("'"))
    text = text.rstrip("'")
    base, *subs = text.split("_", 1)
    if base[-1].isdigit() and base not in GREEK:  # g0, p0
        base, subs = base[:-1], [",".join([base[-1], *subs])]
    if base in OPERATORS:
        below = f"_{{{_subscript(subs[0])}}}" if subs else ""
        return "sign", OPERATORS[base] + below
    if base in FUNCTIONS and not subs:
        return "sign", rf"\{base}" if base not in ("erf", "erfc") else rf"\mathrm{{{base}}}"
    symbol = GREEK.get(base) or (base if len(base) == 1 else rf"\mathrm{{{base}}}")
    return "atom", symbol + (f"_{{{_subscript(subs[0])}}}" if subs else "") + "'" * primes


def _subscript(text: str) -> str:
    parts = []
    for part in re.split(r"([_,])", text):
        if part in ("_", ","):
            parts.append(",")
        else:
            parts.append(GREEK.get(part) or (part if len(part) == 1 else rf"\mathrm{{{part}}}"))
    return "".join(parts)


def _plain(item: Item) -> str:
    kind, text = item
    if kind == "group":
        return rf"\left({text}\right)"
    if kind == "square":
        return rf"\left[{text}\right]"
    return text


def _joined(items: list[Item]) -> str:
    """Return the TeX of items in a row, with fractions where a stroke stands between two of them."""
    out: list[Item] = []
    k = 0
    while k < len(items):
        if (
            items[k] == ("sign", "/")
            and out
            and k + 1 < len(items)
            and out[-1][0] != "sign"
            and items[k + 1][0] != "sign"
        ):
            out[-1] = ("atom", rf"\frac{{{out[-1][1]}}}{{{items[k + 1][1]}}}")
            k += 2
        else:
            out.append(items[k])
            k += 1
    return r" ".join((rf"{_plain(item)}" + (r"\," if _product(out, n) else "")) for n, item in enumerate(out))


def _product(items: list[Item], n: int) -> bool:
    """Return whether a thin space belongs between an item and the next one, which are multiplied."""
    return n + 1 < len(items) and items[n][0] != "sign" and items[n + 1][0] != "sign"

"""Formulas that a scene writes: "k*c_A/(1 + K*p_B)" as a function of named values,
nothing else is evaluated.

Numbers, names, + - * / **, parentheses and the functions of `FUNCTIONS` are allowed.
Powers that are no integer are odd about zero, |x|^n with the sign of x, so that what is
slightly negative within an iteration pulls back.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from keyword import iskeyword
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.scene.names import nearest

TINY = 1e-14  # below which a power that is no integer is a straight line
LONGEST = 2000  # characters
DEEPEST = 100  # of parts within each other
_ALLOWED = (
    "only numbers, names, + - * / ** and functions of one value may stand in a formula"
)
# "900 K"
_WITH_UNIT = re.compile(r"(?<![\w.])\d+\.?\d*(?:[eE][+-]?\d+)? *([A-Za-z_%]\w*)")
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "exp": np.exp,
    "log": np.log,
    "sqrt": lambda x: odd_power(x, 0.5),
    "tanh": np.tanh,
    "abs": np.abs,
    "max": np.maximum,
    "min": np.minimum,
}
_OPERATORS: Mapping[type, Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: _numpy(a) / b,
    ast.Pow: lambda a, b: power(a, b),
}


def odd_power(x: Any, exponent: float, small: Any = TINY) -> Any:
    """Return |x|^n with the sign of x, a straight line below `small`."""
    return x * (x * x + small * small) ** (0.5 * (exponent - 1.0))


def _numpy(x: Any) -> Any:
    """Return a number as one whose quotient by zero is infinite, as that of arrays
    is.
    """
    return np.float64(x) if isinstance(x, int | float) else x


def power(x: Any, exponent: Any) -> Any:
    """Return x^n; odd about zero where n is a number that is not whole, and infinite
    there where it is negative.
    """
    if isinstance(exponent, int | float):
        if float(exponent).is_integer() or isinstance(x, int | float):
            return _numpy(x) ** exponent
        return (
            odd_power(x, float(exponent))
            if exponent > 0.0
            else 1.0 / odd_power(x, -float(exponent))
        )
    return x**exponent


@dataclass(frozen=True)
class Formula:
    """A formula of named values; call it with a mapping that holds them."""

    text: str
    names: frozenset[str]
    tree: Any

    def __call__(
        self,
        values: Mapping[str, Any],
        small: float = 0.0,
        sizes: Mapping[str, Any] | None = None,
    ) -> Any:
        """Return the value of the formula, which is not finite where it divides by
        zero.

        Powers between 0 and 1 are straight lines below a share `small` of what they are
        taken of at `sizes`.
        """
        with np.errstate(all="ignore"):
            return (
                _value(self.tree, values)
                if sizes is None
                else _Smoothed(values, small, sizes)(self.tree)
            )

    def has_roots(self, parameters: Mapping[str, float]) -> bool:
        """Return whether it has powers between 0 and 1, numbers or parameters, whose
        slopes are infinite at zero.
        """
        return any(_root(node, parameters) is not None for node in ast.walk(self.tree))


def parse_formula(text: str) -> Formula:
    """Read a formula.

    Raises
    ------
    SceneError : it is no formula, or uses what is not allowed in one
    """
    if len(text) > LONGEST:
        raise SceneError(
            f"a formula has at most {LONGEST} characters; this one has {len(text)}"
        )
    try:
        tree = ast.parse(text.replace("^", "**").strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        if (found := _WITH_UNIT.search(text)) and not iskeyword(found[1]):
            raise SceneError(
                f"{found[0]!r}: a number in a formula has no unit; write it in SI"
            ) from None
        reason = getattr(error, "msg", None) or str(error)
        raise SceneError(
            f"cannot be read as a formula ({reason}); write it as in k*c_A*(1 - "
            "X)**(2/3)"
        ) from None
    names: set[str] = set()
    _check(tree, names)
    return Formula(text, frozenset(names), tree)


def _check(node: ast.AST, names: set[str], depth: int = 0) -> None:
    """Raise SceneError for what is not allowed in a formula, and collect its names."""
    if depth > DEEPEST:
        raise SceneError(f"parts of a formula may be nested {DEEPEST} times at most")
    depth += 1
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            raise SceneError(
                f"{node.value!r} has no place in a formula; numbers and names only"
            )
    elif isinstance(node, ast.Name):
        names.add(node.id)
    elif isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        first, rest = _chain(node)
        _check(first, names, depth)
        for operator, part in rest:
            if operator not in _OPERATORS:
                raise SceneError(_ALLOWED)
            _check(part, names, depth)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        _check(node.operand, names, depth)
    elif (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and not node.keywords
    ):
        if node.func.id not in FUNCTIONS:
            raise SceneError(
                f"there is no function {node.func.id!r} for formulas; "
                f"{nearest(node.func.id, list(FUNCTIONS))}"
            )
        needed = 2 if node.func.id in ("max", "min") else 1
        if len(node.args) != needed:
            raise SceneError(
                f"{node.func.id} takes {needed} value{'s' if needed > 1 else ''}, "
                f"found {len(node.args)}"
            )
        for argument in node.args:
            _check(argument, names, depth)
    else:
        raise SceneError(_ALLOWED)


def _chain(node: ast.BinOp) -> tuple[ast.expr, list[tuple[type, ast.expr]]]:
    """Return the first part of a chain such as a + b - c, and its further parts, each
    with the operator before it: Python nests them one within the other.
    """
    rest: list[tuple[type, ast.expr]] = [(type(node.op), node.right)]
    first = node.left
    if not isinstance(node.op, ast.Pow):
        while isinstance(first, ast.BinOp) and not isinstance(first.op, ast.Pow):
            rest.append((type(first.op), first.right))
            first = first.left
    return first, rest[::-1]


def _value(node: Any, values: Mapping[str, Any]) -> Any:
    return _combined(node, values, lambda part: _value(part, values))


def _combined(node: Any, values: Mapping[str, Any], value: Callable[[Any], Any]) -> Any:
    """Return the value of a node from those of its parts."""
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.BinOp):
        first, rest = _chain(node)
        result = value(first)
        for operator, part in rest:
            result = _OPERATORS[operator](result, value(part))
        return result
    if isinstance(node, ast.UnaryOp):
        return (
            -value(node.operand)
            if isinstance(node.op, ast.USub)
            else value(node.operand)
        )
    return FUNCTIONS[node.func.id](*(value(argument) for argument in node.args))


def _root(node: Any, values: Mapping[str, Any]) -> tuple[Any, float] | None:
    """Return what a power between 0 and 1 is taken of, and its exponent, a number;
    None for all else.
    """
    if (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "sqrt"
    ):
        return node.args[0], 0.5
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        try:
            exponent = _value(node.right, values)
        except KeyError:  # of a name that is no parameter
            return None
        return (
            (node.left, float(exponent))
            if isinstance(exponent, int | float) and 0.0 < exponent < 1.0
            else None
        )
    return None


class _Smoothed:
    """Value of a formula whose powers between 0 and 1 are straight lines near zero;
    see `Formula`.
    """

    def __init__(
        self, values: Mapping[str, Any], small: float, sizes: Mapping[str, Any]
    ):
        self.values, self.small, self.sizes = values, small, sizes

    def __call__(self, node: Any) -> Any:
        root = _root(node, self.values)
        if root is not None and not isinstance(base := self(root[0]), int | float):
            return odd_power(
                base,
                root[1],
                np.maximum(self.small * np.abs(_value(root[0], self.sizes)), TINY),
            )
        return _combined(node, self.values, self)


def require_names(formula: Formula, known: Iterable[str]) -> None:
    """Raise SceneError for a name that has no value."""
    known = list(known)
    for name in sorted(formula.names):
        if name not in known:
            raise SceneError(
                f"{name!r} is not known in this formula; {nearest(name, known)}"
            )

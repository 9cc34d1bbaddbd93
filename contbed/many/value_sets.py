"""The values of a design: lists, ranges and samples, read from the tables of a study
and turned into SI.

    ["3 mm", "6 mm"]                                            a list, as it is
    { from = "3 mm", to = "12 mm", count = 4 }                  even steps, both ends exact
    { from = 0.01, to = 100, count = 5, spacing = "log" }       even ratios, both ends exact; ends of one sign
    { distribution = "uniform", from = 0.36, to = 0.44 }        in a sample; also "log_uniform"
    { from = 10, to = 20, integer = true }                      integers, each as likely as the others
    { distribution = "normal", mean = "6 mm", deviation = "0.2 mm" }
    { distribution = "log_normal", median = "5 W/m/K", factor = 1.3 }   two of three are within 5/1.3 to 5*1.3

A sample is a set of points in the unit cube, Latin hypercube or scrambled Sobol, that
each distribution maps to its values. The Latin hypercube has one point in each of
`count` slices of equal probability, for every parameter (McKay, Beckman & Conover 1979,
doi:10.1080/00401706.1979.10489755); the Sobol points fill all dimensions evenly if
`count` is a power of two (Owen 1998, doi:10.1006/jcom.1998.0487).

Mistakes are reported to `say(path below the table, text)`; what could not be read is
None.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.many.distributions import Distribution
from contbed.many.study_file import Say, checked
from contbed.scene.names import nearest
from contbed.scene.quantities import Switch, Table, Whole

Method = Literal["latin_hypercube", "sobol", "sobol_indices", "morris"]

MOST_RUNS = 100_000
# methods whose points belong together, one group for each of `count`
BY_THEMSELVES = ("sobol_indices", "morris")
LEVELS = 4  # of a Morris design, as its authors take
# probability below and above the values of a normal distribution in a Morris design,
# which has ends
TAIL = 0.05
MAGNITUDE = re.compile(r"^[\s+-]*[\d.]+(?:[eE][+-]?\d+)?")
# distributions that are known by a key of theirs
_BY_KEY = {"mean": "normal", "median": "log_normal"}


class Ends(Table):
    """Two ends, numbers in the unit of the key or with a unit."""

    kind: ClassVar[str] = "values"

    low: Any = Field(None, alias="from")
    """lowest value"""
    high: Any = Field(None, alias="to")
    """highest value"""


class Range(Ends):
    """Values from one end to the other."""

    count: Annotated[Whole, Field(ge=2, le=MOST_RUNS)]
    """number of values"""
    spacing: Literal["linear", "log"] = "linear"
    """even differences or even ratios"""


class Even(Ends):
    """An even distribution, of the value or of its logarithm."""

    distribution: Literal["uniform", "log_uniform"] = "uniform"
    """even in the value or in its logarithm"""


class EvenIntegers(Ends):
    """An even distribution, of integers if so asked."""

    distribution: Literal["uniform"] = "uniform"
    """integers, each as likely as the others"""
    integer: Switch = False
    """whether the values are integers"""


class Normal(Table):
    """A normal distribution."""

    kind: ClassVar[str] = "values"

    distribution: Literal["normal"] = "normal"
    """normal distribution"""
    mean: Any = None
    """mean"""
    deviation: Any = None
    """standard deviation"""


class LogNormal(Table):
    """A normal distribution of the logarithm."""

    kind: ClassVar[str] = "values"

    distribution: Literal["log_normal"] = "log_normal"
    """log-normal distribution"""
    median: Any = None
    """median"""
    factor: Any = None
    """ratio to the median at one standard deviation of the logarithm"""


DISTRIBUTIONS: dict[str, type[Table]] = {
    "uniform": Even,
    "log_uniform": Even,
    "normal": Normal,
    "log_normal": LogNormal,
}


def is_values(entry: Any) -> bool:
    """Return whether an entry of [parameters] holds values, and not keys further
    down.
    """
    return is_distribution(entry) or bool({"count", "spacing"} & entry.keys())


def is_distribution(entry: Any) -> bool:
    """Return whether an entry of [sample.parameters] holds a distribution, and not
    keys further down.
    """
    return (
        not isinstance(entry, Mapping)
        or not entry
        or bool({"distribution", "from", "to", "mean", "median"} & entry.keys())
    )


def is_log(entry: Any) -> bool:
    """Return whether the values of a range or distribution are even in their
    logarithm.
    """
    return isinstance(entry, Mapping) and "log" in {
        entry.get("spacing"),
        str(entry.get("distribution"))[:3],
    }


def values(entry: Any, unit: str | None, say: Say) -> list[Any] | None:
    """Return the values of a list or range whose key has the SI unit `unit`."""
    if isinstance(entry, list):
        if not entry:
            say((), "an empty list; give at least one value")
            return None
        return entry
    if not isinstance(entry, Mapping):
        say((), "expected a list of values, or a range { from, to, count }")
        return None
    if not {"from", "to"} & entry.keys() and {"distribution", *_BY_KEY} & entry.keys():
        say(
            (),
            "is a distribution, which a sample is drawn from; give it under "
            "[sample.parameters]",
        )
        return None
    table = checked(Range, entry, say)
    ends = _ends(entry, unit, entry.get("spacing") == "log", say)
    if table is None or ends is None:
        return None
    steps = np.geomspace if table.spacing == "log" else np.linspace
    with np.errstate(over="ignore", invalid="ignore"):
        found = steps(*ends, table.count)
    if not np.isfinite(found).all():
        say((), "the range is too wide for a computer's numbers")
        return None
    if (
        all(isinstance(entry[key], int) for key in ("from", "to"))
        and (found == found.round()).all()
    ):
        return [int(value) for value in found]  # of a key that counts
    return [ends[0], *map(tidy, found[1:-1]), ends[1]]


def distribution(
    entry: Any, unit: str | None, say: Say, counts: bool = False
) -> Distribution | None:
    """Return the map from (0, 1) to the values of a distribution, which may be
    integers for keys that `counts`.
    """
    if not isinstance(entry, Mapping):
        say(
            (),
            "expected a distribution: { from, to }, { mean, deviation } or { median, "
            "factor }",
        )
        return None
    usual = next((name for key, name in _BY_KEY.items() if key in entry), "uniform")
    name = str(entry.get("distribution", usual))
    if name not in DISTRIBUTIONS:
        say(
            ("distribution",),
            f"distribution is {name!r}; {nearest(name, list(DISTRIBUTIONS))}",
        )
        return None
    may_count = counts and name == "uniform"
    table = checked(EvenIntegers if may_count else DISTRIBUTIONS[name], entry, say)
    if table is None:
        return None
    if name == "normal":
        return _normal(entry, unit, say)
    if name == "log_normal":
        return _log_normal(entry, unit, say)
    ends = _ends(entry, unit, name == "log_uniform", say)
    if ends is None:
        return None
    # by size, as negative logarithms go
    if ends[0] > ends[1] and not (name == "log_uniform" and ends[0] < 0.0):
        say((), f"from {ends[0]:g} to {ends[1]:g}; give the lower end first")
        return None
    integers = isinstance(table, EvenIntegers) and table.integer
    if integers and not (ends[0].is_integer() and ends[1].is_integer()):
        say((), f"integers from {ends[0]:g} to {ends[1]:g}; give integers")
        return None
    return Distribution(
        *ends, even=True, logarithmic=name == "log_uniform", whole=integers
    )


def tidy(value: float) -> float:
    """Round to 14 digits, because the last ones differ between computers and would
    make another scene.
    """
    return float(f"{value:.14g}")


def sample(method: str, count: int, seed: int, dimensions: int) -> Array:
    """Return the points of a design in the unit cube, (runs, dimensions); the same for
    the same seed.

    "sobol_indices" has `count` groups of dimensions + 2 points (Saltelli et al. 2010,
    doi:10.1016/j.cpc.2009.09.018), "morris" `count` ways of dimensions + 1 points that
    differ in one coordinate each (Morris 1991, doi:10.1080/00401706.1991.10484804); any
    other `count` points.

    Raises
    ------
    ContbedError : SALib is needed and not installed

    >>> points = sample("latin_hypercube", 5, seed=1, dimensions=2)
    >>> [sorted(int(5 * u) for u in column) for column in points.T]
    [[0, 1, 2, 3, 4], [0, 1, 2, 3, 4]]
    """
    import warnings

    from scipy.stats import qmc

    random = np.random.default_rng(seed)
    if method in BY_THEMSELVES:
        # SALib's seeds have 32 bits
        return _with_salib(method, count, seed % 2**32, dimensions)
    if method == "latin_hypercube":
        points: Array = qmc.LatinHypercube(dimensions, seed=random).random(count)
        return points
    with warnings.catch_warnings():
        # on counts that are no power of two, which the study reports
        warnings.simplefilter("ignore", UserWarning)
        points = qmc.Sobol(dimensions, scramble=True, seed=random).random(count)
    return points


def _with_salib(method: str, count: int, seed: int, dimensions: int) -> Array:
    try:
        from SALib.sample import morris, sobol
    except ImportError:
        raise ContbedError(
            f"method = \"{method}\" needs SALib: pip install 'contbed[calibrate]'"
        ) from None
    import warnings

    problem = unit_cube(dimensions)
    with warnings.catch_warnings():
        # on counts that are no power of two, which the study reports
        warnings.simplefilter("ignore", UserWarning)
        if method == "sobol_indices":
            return np.asarray(
                sobol.sample(problem, count, calc_second_order=False, seed=seed)
            )
        return np.asarray(morris.sample(problem, count, num_levels=LEVELS, seed=seed))


def unit_cube(dimensions: int) -> dict[str, Any]:
    """Return what SALib calls a problem: parameters between 0 and 1."""
    return {
        "num_vars": dimensions,
        "names": [str(k) for k in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }


def within_tails(u: Array, spread: Distribution) -> Array:
    """Return the coordinates of a Morris design, of which a normal distribution
    takes those within its tails.
    """
    return u if spread.even else TAIL + (1.0 - 2.0 * TAIL) * u


def _ends(
    entry: Mapping[str, Any], unit: str | None, logarithmic: bool, say: Say
) -> tuple[float, float] | None:
    low, high = (number(entry, key, unit, say) for key in ("from", "to"))
    if low is None or high is None:
        return None
    if low == high:
        say((), f"an empty range, from and to are both {low:g}")
    elif logarithmic and (low == 0.0 or high == 0.0 or (low > 0.0) != (high > 0.0)):
        say(
            (),
            f"a logarithmic range from {low:g} to {high:g}; its ends must have the "
            "same sign and not be 0",
        )
    else:
        return low, high
    return None


def _normal(
    entry: Mapping[str, Any], unit: str | None, say: Say
) -> Distribution | None:
    mean = number(entry, "mean", unit, say)
    deviation = number(entry, "deviation", unit, say, difference=True)
    if mean is None or deviation is None:
        return None
    if deviation <= 0.0:
        say(("deviation",), f"deviation is {deviation:g}; allowed: a number > 0")
        return None
    return Distribution(mean, mean + deviation, even=False)


def _log_normal(
    entry: Mapping[str, Any], unit: str | None, say: Say
) -> Distribution | None:
    median = number(entry, "median", unit, say)
    factor = number(entry, "factor", "1", say)
    if median is None or factor is None:
        return None
    if median == 0.0 or factor <= 1.0:
        key, value, allowed = (
            ("factor", factor, "> 1") if median else ("median", median, "that is not 0")
        )
        say((key,), f"{key} is {value:g}; allowed: a number {allowed}")
        return None
    return Distribution(median, median * factor, even=False, logarithmic=True)


def number(
    entry: Mapping[str, Any],
    key: str,
    unit: str | None,
    say: Say,
    difference: bool = False,
) -> float | None:
    """Return a number in SI; a `difference` of temperatures does not move with the
    zero of its scale.
    """
    value = entry.get(key)
    if isinstance(value, str) and unit is not None:
        from contbed.scene.units import to_si

        try:
            return to_si(value, unit) - (
                to_si(MAGNITUDE.sub("0 ", value), unit) if difference else 0.0
            )
        except ValueError as error:
            say((key,), f"{key}: {error}")
            return None
    if (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and math.isfinite(value)
    ):
        return float(value)
    plain = (
        "a plain number, this key has no unit"
        if isinstance(value, str)
        else "a finite number"
    )
    say(
        (key,) if key in entry else (),
        f"{key} is {_shown(entry, key)}; allowed: {plain}",
    )
    return None


def _shown(entry: Mapping[str, Any], key: str) -> str:
    return "missing" if key not in entry else repr(entry[key])

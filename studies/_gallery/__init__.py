"""What every study shares: tables, figures in one style, timing, peer programs and the
command line.

A study is a folder with scenes, a README and `study.py`, which has three functions:

    compute() -> {"results": Table, ...}      our numbers beside those of `reference`; written as results.csv, ...
    reference(...)                            exact, published or peer numbers, for one scene where there are several
    plot(tables) -> {"profiles": Figure, ...} drawn from the tables alone; written as profiles.png, ...

`compute` may take `cases` where a part of the runs can be chosen. Further scripts of a
folder with the same functions are studies of their own, `FOLDER/SCRIPT`.
"""

from studies._gallery.figures import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALETTE,
    PURPLE,
    SKY,
    VERMILION,
    YELLOW,
    figure,
    label,
    label_line,
    order_line,
    shades,
    ticks,
)
from studies._gallery.overrides import merged
from studies._gallery.sweeps import swept
from studies._gallery.table import Table, Tables, updated
from studies._gallery.timing import Timed, cpu, cpu_of, in_turn, machine, user_time

__all__ = [
    "BLACK",
    "BLUE",
    "GREEN",
    "GREY",
    "ORANGE",
    "PALETTE",
    "PURPLE",
    "SKY",
    "VERMILION",
    "YELLOW",
    "Table",
    "Tables",
    "Timed",
    "cpu",
    "cpu_of",
    "figure",
    "in_turn",
    "label",
    "label_line",
    "machine",
    "merged",
    "order_line",
    "shades",
    "swept",
    "ticks",
    "updated",
    "user_time",
]

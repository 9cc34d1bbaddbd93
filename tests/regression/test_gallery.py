"""Every study has its README, its functions and scenes that are accepted; short ones
give their tables again.
"""

import ast
import inspect
import re
import tomllib
from types import ModuleType

import matplotlib
import pytest

import contbed as cb
from contbed.many.sweep.study import read_study
from studies._gallery import Table, merged
from studies._gallery.catalogue import FUNCTIONS, STUDIES, studies
from studies._gallery.command import README, listing, with_list

ALL = studies()
FOLDERS = sorted(
    path for path in STUDIES.iterdir() if path.is_dir() and path.name[0] not in "_."
)
SCENES = sorted({scene for study in ALL.values() for scene in study.scenes})
# programs that are not part of the project
NEEDS = {"scaling": "DOLFINx", "two_energy_benchmark": "NGSolve"}


def name_of(path):
    return str(path.relative_to(STUDIES))


def test_every_folder_is_a_study():
    assert {path.name for path in FOLDERS} == {name for name in ALL if "/" not in name}


@pytest.mark.parametrize("study", ALL.values(), ids=list(ALL))
def test_study_has_its_functions(study):
    assert all(callable(getattr(study.module, name)) for name in FUNCTIONS)
    assert study.module.__doc__


@pytest.mark.parametrize("study", ALL.values(), ids=list(ALL))
def test_what_a_study_takes_of_other_modules_is_there(study):
    """A function that was renamed is missed here, not after hours of a run."""
    known = {
        name: item
        for name, item in vars(study.module).items()
        if isinstance(item, ModuleType)
    }
    for node in ast.walk(ast.parse(inspect.getsource(study.module))):
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id in known
        ):
            assert hasattr(known[node.value.id], node.attr), (
                f"line {node.lineno}: {node.value.id}.{node.attr}"
            )


@pytest.mark.parametrize("study", ALL.values(), ids=list(ALL))
def test_readme_states_figure_tolerance_and_cost(study):
    assert study.readme.startswith("# ")
    pictures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", study.readme)
    assert pictures and all((study.folder / name).is_file() for name in pictures)
    assert 0 < study.tolerance < 0.1
    assert study.seconds > 0, "the README names no run of this study with its CPU"


def settles(path):
    """Whether the plan of a scene settles a packing first, which takes long."""
    return "count" in tomllib.loads(path.read_text(encoding="utf-8")).get(
        "particles", {}
    )


@pytest.mark.parametrize("path", SCENES, ids=name_of)
def test_scenes_are_checked(path):
    cb.load(path)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=name_of(path), marks=[pytest.mark.slow] * settles(path))
        for path in SCENES
    ],
)
def test_scenes_are_planned(path):
    plan = cb.plan(cb.load(path))
    assert plan.unknowns() or "closed form" in str(plan)


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*/sweep*/*.toml")), ids=name_of)
def test_sweeps_are_read(path):
    found = read_study(path)
    assert found.cases and found.qoi and not found.warnings


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*/closures/*.toml")), ids=name_of)
def test_closure_files_are_toml(path):
    assert tomllib.loads(path.read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize("study", ALL.values(), ids=list(ALL))
def test_figures_are_drawn_from_the_committed_tables(study, tmp_path):
    """Every figure is one that the README shows."""
    before = dict(matplotlib.rcParams)
    for path in study.draw(study.tables(), tmp_path):
        assert path.stat().st_size > 5_000
        assert f"]({path.name})" in study.readme
    assert dict(matplotlib.rcParams) == before


def test_the_readme_lists_the_studies():
    text = README.read_text(encoding="utf-8")
    assert with_list(text) == text
    assert all(name in listing() for name in ALL)


def test_a_table_keeps_what_it_writes(tmp_path):
    table = Table(
        {"case": "", "x [m]": ".3g", "n": "d"},
        [("a, b", 0.12345, 1), ("c", None, 2), ("a, b", 2.0, 3)],
    )
    table.write(tmp_path / "t.csv")
    assert (
        tmp_path / "t.csv"
    ).read_text() == 'case,x [m],n\n"a, b",0.123,1\nc,,2\n"a, b",2,3\n'
    again = Table.read(tmp_path / "t.csv")
    assert again.rows == table.rows and not again.differences(table, 0.0)
    assert again.where({"case": "a, b", "n": 3})["x [m]"].tolist() == [2.0]
    assert again.values("case") == ["a, b", "c"]
    other = Table({"case": "", "x [m]": ".3g", "n": "d"}, [("c", 5.0, 2)])
    assert again.updated(other, ["case"]).rows == [
        ("a, b", "0.123", "1"),
        ("c", "5", "2"),
        ("a, b", "2", "3"),
    ]
    with pytest.raises(ValueError):
        Table({"a": "", "b": ""}, [(1,)])


def test_rows_of_one_case_are_replaced_together():
    """At the place of the first one, however many they were and are; those of a new
    case come last.
    """
    columns = {"case": "", "t [s]": ".3g"}
    old = Table(columns, [("a", 0.0), ("b", 0.0), ("b", 1.0), ("c", 0.0)])
    new = Table(columns, [("d", 5.0), ("b", 2.0), ("b", 3.0), ("b", 4.0)])
    wanted = Table(
        columns,
        [("a", 0.0), ("b", 2.0), ("b", 3.0), ("b", 4.0), ("c", 0.0), ("d", 5.0)],
    )
    assert old.updated(new, ["case"]).rows == wanted.rows


def test_tables_differ_beyond_tolerance_and_last_digit():
    one, other = (Table({"a": ""}, [(text,)]) for text in ("1.000", "1.001"))
    assert not one.differences(other, 0.0)
    assert one.differences(Table({"a": ""}, [("1.010",)]), 1e-3)
    assert not one.differences(Table({"a": ""}, [("1.010",)]), 1e-2)
    assert not one.differences(Table({"a": ""}, [("9",)]), 0.0, skip=["a"])
    assert one.differences(Table({"b": ""}, [("1.000",)]), 1.0)


def test_a_table_that_is_not_committed_is_a_difference():
    study = ALL["measured_beds"]
    committed = study.tables()
    assert study.differences(committed) == []
    other = {"other": next(iter(committed.values()))}
    assert study.differences(committed | other) == ["other.csv, not committed"]


def test_changes_are_laid_over_a_scene():
    assert merged({"a": {"b": 1, "c": 2}, "d": 3}, {"a": {"b": 4}}) == {
        "a": {"b": 4, "c": 2},
        "d": 3,
    }
    assert merged({"a": {"type": "wall", "x": 1}}, {"a": {"type": "inlet"}}) == {
        "a": {"type": "inlet"}
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    "study",
    [study for study in ALL.values() if not study.is_long],
    ids=lambda study: study.name,
)
def test_short_studies_give_their_tables_again(study):
    if study.name in NEEDS:
        pytest.skip(f"needs {NEEDS[study.name]}")
    assert study.differences(study.compute()) == []

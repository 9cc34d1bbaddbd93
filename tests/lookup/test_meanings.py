"""Every key of scenes and of files of studies has a meaning, which `contbed explain`
and the manual show.
"""

import importlib
import pkgutil

import pytest

import contbed.many
from contbed.explain import catalogue
from contbed.scene import schema
from contbed.scene.quantities import Table, meanings


def has_meaning(node):
    """Whether a key, or the table that it holds, is described."""
    return any(option.get("description") for option in (node, *schema.options(node)))


def test_every_key_of_a_scene_has_a_meaning():
    without = [
        name
        for name, nodes in catalogue.keys().items()
        for node in nodes
        if not has_meaning(node)
    ]
    assert without == []


def tables_below(table):
    """Yield the tables that are made from one."""
    for each in table.__subclasses__():
        yield each
        yield from tables_below(each)


@pytest.fixture(scope="module")
def study_tables():
    """The tables of files of studies, without those of physics."""
    for module in pkgutil.walk_packages(contbed.many.__path__, "contbed.many."):
        importlib.import_module(module.name)
    return {
        table
        for table in tables_below(Table)
        if table.__module__.startswith("contbed.many.")
    }


def test_every_key_of_a_study_has_a_meaning(study_tables):
    without = []
    for table in study_tables:
        described = meanings(table)
        for key, field in table.model_fields.items():
            named = [
                table
                for table in study_tables
                if table.__doc__ and table.__name__ in str(field.annotation)
            ]
            if key not in described and not named:
                without.append(f"{table.__name__}.{key}")
    assert study_tables and without == []

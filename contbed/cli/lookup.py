"""Commands that look something up: data sheets, lists, closures for a place, the
JSON schema, a scene to begin with.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Argument, Option


def _names(incomplete: str) -> list[str]:
    """Names of data sheets, for the completion of a shell."""
    from contbed.explain.sheets import entries

    return [name for name in entries() if name.startswith(incomplete)]


def _kinds(incomplete: str) -> list[str]:
    """Kinds of scenes, for the completion of a shell."""
    from contbed.models import MODELS

    return [kind for kind in MODELS if kind.startswith(incomplete)]


def _places(incomplete: str) -> list[str]:
    """Places that take closures, for the completion of a shell."""
    from contbed.explain.closure_keys import closure_keys

    return [place for place in closure_keys() if place.startswith(incomplete)]


KindOrNone = Annotated[
    str | None,
    Argument(
        metavar="KIND", help="kind of scene, such as packed_bed", autocompletion=_kinds
    ),
]


def new(
    kind: KindOrNone = None,
    out: Annotated[
        Path | None,
        Option("--out", metavar="FILE", help="file to write; absent: print"),
    ] = None,
) -> None:
    """Write a commented scene to begin with.

    It runs as it is. Without KIND the kinds of scenes are listed.
    """
    from contbed.explain import editor
    from contbed.models import MODELS

    if kind is None:
        for name in MODELS:
            print(f"{name:18} {editor.summary(name)}")
        return
    text = editor.template(kind)
    if out is None:
        print(text, end="")
        return
    try:
        with open(out, "x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise typer.BadParameter(
            f"{out} is there already; choose another name", param_hint="--out"
        ) from None
    print(f"{out} is written; contbed run {out} solves it")


def schema(kind: KindOrNone = None) -> None:
    """Print the JSON schema of scenes.

    Editors complete and check scenes by it. Without KIND it covers all kinds.
    """
    import json

    from contbed.explain.editor import json_schema

    print(json.dumps(json_schema(kind), indent=1))


def explain(
    context: typer.Context,
    name: Annotated[
        list[str],
        Argument(
            metavar="NAME",
            help="nusselt_gunn, closures.nusselt, calcination, materials",
            autocompletion=_names,
        ),
    ],
) -> None:
    """Show the data sheet of a name, or of each of several.

    A name of a closure, model, table, key, result, reaction, material, term or command.
    """
    from contbed.errors import SceneError
    from contbed.explain import sheets
    from contbed.scene.names import first_paragraph

    commands = getattr(context.find_root().command, "commands", {})
    about = {key: first_paragraph(command.help) for key, command in commands.items()}
    try:
        print(sheets.explain(" ".join(name), about))
    except SceneError:
        # several names, if no name is made of these words
        print("\n".join(sheets.explain(each, about) for each in name))


def closures(
    place: Annotated[
        str,
        Option(
            "--for",
            metavar="PLACE",
            help="key that names a closure, closures.drag; or a kind",
            autocompletion=_places,
        ),
    ],
    at: Annotated[
        str | None,
        Option(
            "--at",
            metavar="CONDITIONS",
            help='such as "d_p=300 um, rho_s=2600, T=850 degC"',
        ),
    ] = None,
) -> None:
    """Rank the closures for a key of a scene.

    They are ranked by their declared ranges.
    """
    from contbed.explain.rank_closures import table

    print(table(place, at))


def list_() -> None:
    """List models, closures, materials and tables.

    Closures by kind, and tables of each kind of scene.
    """
    from contbed.explain.sheets import listing

    print(listing())


COMMANDS: tuple[Callable[..., Any], ...] = (new, explain, closures, list_, schema)
"""Commands that `contbed.cli.commands` registers."""

"""The command line.

`commands` and `studies` run scenes, `lookup` shows data sheets, `terminal` holds what
they share.
"""

from contbed.cli.commands import app, main

__all__ = ["app", "main"]

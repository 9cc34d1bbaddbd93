"""The command line as a user types it."""

import shlex

from contbed.cli import main


def command(line: str) -> int:
    """Run `contbed` with the words of a line; return the exit code."""
    return main(shlex.split(line))

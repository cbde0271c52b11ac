"""The command line: parse, call, print.

Results go to standard output (with ``--json`` one JSON document and nothing else), progress to standard error.
Exit codes: 0 done, 1 the answer is no (not positive real, infeasible), 2 bad input.
"""

from __future__ import annotations

import os
import sys
from typing import Annotated, Any

import typer

from posreal import __version__
from posreal.cli import bounds, designs, devices, listings, searches
from posreal.cli.options import DEVICE_FIRST
from posreal.errors import PosrealError

_UsageError: Any = typer.BadParameter.__base__  # of click, or of typer's own copy of it

app = typer.Typer(
    name="posreal",
    help="The best passive suspension device that can exist for a vehicle, and how to build it from springs, dampers "
    "and inerters.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> None:
    if asked:
        print(f"posreal {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """What every command shares."""


app.command()(listings.problems)
app.command()(listings.layouts)
app.command(context_settings=DEVICE_FIRST)(designs.evaluate)
app.command()(designs.optimise)
app.command()(designs.synthesise)
app.command(context_settings=DEVICE_FIRST)(devices.realise)
app.command(context_settings=DEVICE_FIRST)(devices.check)
app.command()(searches.search)
app.command()(bounds.bound)
app.command("check-bound")(bounds.check_bound)
app.command()(designs.compare)
app.command()(designs.reproduce)


def main() -> None:
    """Entry point of the ``posreal`` command."""
    try:
        sys.exit(app(standalone_mode=False))
    except _UsageError as error:
        text = error.format_message()  # the help, if nothing was given at all
        print(text if "\n" in text else f"posreal: {text}", file=sys.stderr)
        sys.exit(2)
    except PosrealError as error:
        print(f"posreal: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        print("posreal: interrupted", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)

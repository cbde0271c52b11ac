"""The command line: parse, call, print.

Results go to standard output (with ``--json`` one JSON document and nothing else), progress to standard error.
Exit codes: 0 done, 1 the answer is no (not positive real, infeasible), 2 bad input.
"""

from __future__ import annotations

import os
import sys
import warnings
from contextlib import suppress
from typing import Annotated, Any

import typer

from posreal import __version__
from posreal.cli import bounds, designs, devices, listings, robustness, searches, studies, tracks
from posreal.cli.examples import epilog
from posreal.cli.options import DEVICE_FIRST
from posreal.errors import PosrealError, plain

_LONGEST = 1000  # characters of a message, where input is quoted more than once
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
app.command()(studies.design)
app.command()(listings.layouts)
app.command()(listings.vehicle)
app.command()(listings.ranges)
app.command()(tracks.track)
app.command(context_settings=DEVICE_FIRST)(designs.evaluate)
app.command()(designs.optimise)
app.command()(designs.synthesise)
app.command(context_settings=DEVICE_FIRST)(devices.realise)
app.command(context_settings=DEVICE_FIRST)(devices.check)
app.command()(searches.search)
app.command()(bounds.bound)
app.command("check-bound")(bounds.check_bound)
app.command()(studies.compare)
app.command(context_settings=DEVICE_FIRST)(robustness.tolerance)
app.command(context_settings=DEVICE_FIRST)(robustness.preferred)
app.command(context_settings=DEVICE_FIRST)(robustness.simulate)
app.command()(studies.reproduce)

for _command in app.registered_commands:
    assert _command.callback is not None
    _command.epilog = epilog(_command.name or _command.callback.__name__)


def main() -> None:
    """Entry point of the ``posreal`` command."""
    with warnings.catch_warnings():
        if not sys.warnoptions:  # figures are confirmed or refused; how the arithmetic got there is not for the user
            warnings.simplefilter("ignore", RuntimeWarning)
        code = _run()
    sys.exit(code)


def _run() -> int:
    """Do what is asked; every error of the user's or of the system's is one sentence."""
    try:
        code = app(standalone_mode=False)
        sys.stdout.flush()  # a full disk shows here, and not when Python has already decided on the exit code
        return int(code or 0)
    except _UsageError as error:
        text = error.format_message()  # the help, if nothing was given at all
        return _failed(text, 2, whole=type(error).__name__ == "NoArgsIsHelpError")
    except PosrealError as error:
        return _failed(str(error), error.exit_code)
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, ValueError) and type(error).__name__ != "LinAlgError":
            raise
        return _failed(f"these numbers are too far apart for floating-point arithmetic, which gave up: {error}", 1)
    except KeyboardInterrupt:
        return _failed("interrupted", 130)
    except (BrokenPipeError, SystemExit) as error:  # of a broken pipe, typer makes an exit with code 1
        if not isinstance(error.__context__ if isinstance(error, SystemExit) else error, BrokenPipeError):
            raise
        _discard_output()  # whoever read the output has seen enough
        return 0
    except OSError as error:
        _discard_output()
        return _failed(f"cannot write the output: {error.strerror or error}", 2)


def _failed(message: str, code: int, *, whole: bool = False) -> int:
    with suppress(OSError):
        sys.stdout.flush()
    with suppress(OSError):
        print(message if whole else f"posreal: {plain(message, _LONGEST)}", file=sys.stderr, flush=True)
    return code


def _discard_output() -> None:
    """What is left in the buffer goes nowhere, so that Python does not try to write it again at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

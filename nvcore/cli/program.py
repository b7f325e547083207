"""Error messages and exit codes of the program, for all commands.

0    fine
1    the audit found errors, or a rule of the gate does not hold
2    bad input, or an output that cannot be written
3    a fault of the program, or too little memory
130  interrupted (128 + SIGINT)
141  the reader of the output is gone (128 + SIGPIPE)
"""

from __future__ import annotations

import errno
import os
import shlex
import shutil
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import click

from nvcore.cli.remedies import error_text
from nvcore.common.errors import NvcoreError
from nvcore.common.wording import one_line
from nvcore.inputs.files.pipes import pipes_kept

NAME: Final = "nvcore"
EXIT_BAD_INPUT: Final = 2
EXIT_FAULT: Final = 3
EXIT_INTERRUPTED: Final = 130
EXIT_PIPE: Final = 141


class BadInput(click.ClickException):
    """Error that the user can fix."""

    exit_code = EXIT_BAD_INPUT


class _Fault(click.ClickException):
    """Error that only the programmers or a larger machine can fix."""

    exit_code = EXIT_FAULT


class Program(click.Group):
    """Command group that ends with the exit codes of this module, whatever happens."""

    def main(  # type: ignore[override]
        self, args: Sequence[str] | None = None, *, standalone_mode: bool = True, **options: Any
    ) -> Any:
        """Parse the command line, run the command and exit."""
        if sys.stdout is None:  # closed by the shell: >&-
            click.echo("Error: there is no standard output to write to", err=True)
            sys.exit(EXIT_BAD_INPUT)
        if not standalone_mode:
            return super().main(args, standalone_mode=False, **options)
        try:
            code = super().main(args, standalone_mode=False, **options)
        except click.Abort:  # by ^C
            click.echo("Stopped.", err=True)
            sys.exit(EXIT_INTERRUPTED)
        except click.ClickException as error:
            error.show()
            sys.exit(error.exit_code)
        sys.exit(code)

    def make_context(self, *arguments: Any, **options: Any) -> click.Context:
        """Parse the command line, and print requested help."""
        with _shown_errors():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command."""
        with _shown_errors(), pipes_kept():
            super().invoke(ctx)


@contextmanager
def _shown_errors() -> Iterator[None]:
    """Convert errors to the exceptions that `Program.main` shows."""
    try:
        yield
    except (click.ClickException, click.Abort, click.exceptions.Exit):
        raise
    except NvcoreError as error:
        raise BadInput(one_line(error_text(error))) from error
    except MemoryError as error:
        raise _Fault(
            "too little memory for these inputs; compare fewer recordings at a time, or use a "
            "larger machine"
        ) from error
    except OSError as error:
        if error.errno == errno.EPIPE:
            _forget_output()
            raise SystemExit(EXIT_PIPE) from error
        if error.errno == errno.ENOSPC and error.filename is None:
            _forget_output()
            raise BadInput("the output cannot be written: no space is left") from error
        raise _fault() from error
    except Exception as error:
        raise _fault() from error


def program() -> str:
    """Return the program's name or path, as it was called, for suggested commands."""
    called = sys.argv[0]
    is_by_path = Path(called).stem == NAME and shutil.which(NAME) != shutil.which(called)
    return shlex.quote(called) if is_by_path else NAME


def _fault() -> _Fault:
    click.echo(traceback.format_exc(), err=True)
    return _Fault("this is a fault of the program, not of your data; please report the lines above")


def _forget_output() -> None:
    """Discard unwritten output, so that flushing it at exit raises no error."""
    with open(os.devnull, "w") as nowhere:  # noqa: PTH123
        os.dup2(nowhere.fileno(), sys.stdout.fileno())

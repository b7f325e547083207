"""Progress of a command: a bar on a terminal, occasional lines elsewhere, as in a log."""

from __future__ import annotations

import sys
import time
from typing import Any, Final

import click

from nvcore.common.progress import SOON, Progress
from nvcore.common.wording import one_line


def _end(bar: Any, *, is_done: bool) -> None:
    """Close a progress bar. It only jumps to its end if the work is done."""
    if bar is None:
        return
    if is_done:
        bar.finish()
    bar.__exit__(None, None, None)


class _Lines:
    """Occasional lines on an error stream that is not a terminal."""

    APART_S = 30.0

    def __init__(self, patience_s: float):
        self.next_s = time.monotonic() + patience_s
        self.is_shown = not sys.stderr.isatty()

    def tell(self, text: str) -> bool:
        """Write the line unless it is too early. Return whether it was written."""
        if not self.is_shown or time.monotonic() < self.next_s:
            return False
        click.echo(one_line(text), err=True)
        self.next_s = time.monotonic() + self.APART_S
        return True


def step_lines() -> Progress:
    """Return a progress callback that prints each step on a terminal, elsewhere occasional ones."""
    last = ""
    lines = _Lines(_Lines.APART_S)

    def show(_share: float, what: str) -> None:
        nonlocal last
        if what != last and not lines.is_shown:
            click.echo(one_line(what), err=True)
        lines.tell(what)
        last = what

    return show


class TerminalProgress:
    """Progress by steps on the error stream: a bar after the first second, or lines."""

    PATIENCE_S = 1.0

    def __init__(self, n_steps: int):
        self.n_steps = n_steps
        self.done = 0
        self.started = time.monotonic()
        self.bar: Any = None
        self.lines = _Lines(_Lines.APART_S)

    def __enter__(self) -> TerminalProgress:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        _end(self.bar, is_done=error is None)

    def __call__(self, _share: float, what: str) -> None:
        """Begin a step, if used as a progress callback."""
        self.begin(what)

    def begin(self, label: str) -> None:
        """Go on to the next step."""
        is_late = time.monotonic() - self.started > self.PATIENCE_S
        if self.bar is None and is_late and sys.stderr.isatty():
            self.bar = click.progressbar(length=self.n_steps, file=sys.stderr, width=24)
            self.bar.__enter__()
            self.bar.update(self.done)
        if self.bar is not None:
            self.bar.label = one_line(label).ljust(28)
            self.bar.update(1)
        self.done += 1
        self.lines.tell(f"step {self.done} of {self.n_steps}: {label}")


class ShareProgress:
    """Progress by the completed share on the error stream: a bar, or lines.

    Lines come at the beginning, once the remaining time is known, and at every tenth.
    """

    PARTS = 1000
    MARKS: Final = (0.0, SOON, *(tenth / 10 for tenth in range(1, 10)))

    def __init__(self) -> None:
        self.done = 0
        self.bar: Any = None
        self.lines = _Lines(TerminalProgress.PATIENCE_S)
        self.next_mark = 0.0

    def __enter__(self) -> ShareProgress:
        if sys.stderr.isatty():
            self.bar = click.progressbar(length=self.PARTS, file=sys.stderr, width=24)
            self.bar.show_eta = False  # the label has it
            self.bar.__enter__()
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        _end(self.bar, is_done=error is None)

    def __call__(self, share: float, words: str) -> None:
        """Show the completed share, 0 to 1, with a label."""
        if self.bar is not None:
            done = int(share * self.PARTS)
            self.bar.label = one_line(words).ljust(56)
            self.bar.update(max(0, done - self.done))
            self.done = max(done, self.done)
        elif share >= self.next_mark and self.lines.tell(
            words if share < SOON else f"{share:.0%} done: {words}"
        ):
            self.next_mark = min((mark for mark in self.MARKS if mark > share), default=2.0)

"""Progress of a command on the terminal."""

from __future__ import annotations

import sys
import time
from typing import Any

import click

from nvcore.wording import one_line


def _end(bar: Any, *, is_done: bool) -> None:
    """Leave the line of a bar; one of work that was stopped stays where it was."""
    if bar is None:
        return
    if is_done:
        bar.finish()
    bar.__exit__(None, None, None)


class TerminalProgress:
    """A bar on the error stream, shown once the work has taken a second."""

    PATIENCE_S = 1.0

    def __init__(self, n_steps: int):
        self.n_steps = n_steps
        self.done = 0
        self.started = time.monotonic()
        self.bar: Any = None

    def __enter__(self) -> TerminalProgress:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        _end(self.bar, is_done=error is None)

    def __call__(self, _share: float, what: str) -> None:
        """Progress of a part of the steps: one of them begins."""
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


class ShareProgress:
    """A bar on the error stream for work that says which share is done; for terminals alone."""

    PARTS = 1000

    def __init__(self) -> None:
        self.done = 0
        self.bar: Any = None

    def __enter__(self) -> ShareProgress:
        if sys.stderr.isatty():
            self.bar = click.progressbar(length=self.PARTS, file=sys.stderr, width=24)
            self.bar.show_eta = False  # the words say it
            self.bar.__enter__()
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        _end(self.bar, is_done=error is None)

    def __call__(self, share: float, words: str) -> None:
        """Progress of the work."""
        if self.bar is not None:
            done = int(share * self.PARTS)
            self.bar.label = one_line(words).ljust(56)
            self.bar.update(max(0, done - self.done))
            self.done = max(done, self.done)

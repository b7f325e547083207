"""Progress of commands: a bar on a terminal, seldom a line in a log."""

from __future__ import annotations

import io
import sys
from types import SimpleNamespace

import pytest

from nvcore.cli.progress import ShareProgress, TerminalProgress, step_lines


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("patience_s", "is_shown"), [(-1.0, True), (3600.0, False)])
def test_the_progress_bar_appears_only_when_the_work_takes_long_and_is_finished_by_an_error(
    monkeypatch: pytest.MonkeyPatch, patience_s: float, is_shown: bool
):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(TerminalProgress, "PATIENCE_S", patience_s)
    steps = TerminalProgress(2)

    def work() -> None:
        with steps:
            steps(0.0, "reading fir")
            steps.begin("analysing")
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        work()
    assert ("analysing" in terminal.getvalue()) == is_shown
    if is_shown:
        assert terminal.getvalue().endswith("\n")
        assert steps.bar.finished


def test_progress_on_a_terminal_says_what_is_left(monkeypatch: pytest.MonkeyPatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with ShareProgress() as progress:
        for done in range(3):
            progress(done / 2, f"night: {done} of 2 pictures, {2 - done} s left")
    assert "night: 1 of 2 pictures, 1 s left" in terminal.getvalue()
    assert "100%" in terminal.getvalue()


def test_progress_that_is_stopped_stays_where_it_was(monkeypatch: pytest.MonkeyPatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    progress = ShareProgress()
    progress.__enter__()
    progress(0.5, "night: 1 of 2 pictures")
    progress.__exit__(KeyboardInterrupt, None, None)
    assert " 50%" in terminal.getvalue()
    assert "100%" not in terminal.getvalue()


class Log:
    """A stream that is no terminal, and a clock that is set by hand."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.seconds = 0.0
        self.stream = io.StringIO()
        monkeypatch.setattr(sys, "stderr", self.stream)
        clock = SimpleNamespace(monotonic=lambda: self.seconds)
        monkeypatch.setattr("nvcore.cli.progress.time", clock)

    @property
    def lines(self) -> list[str]:
        return self.stream.getvalue().splitlines()


def test_in_a_log_long_work_writes_a_line_at_the_beginning_and_at_every_tenth(
    monkeypatch: pytest.MonkeyPatch,
):
    log = Log(monkeypatch)
    with ShareProgress() as progress:
        for second in range(1001):
            log.seconds = float(second)
            progress(second / 1000, f"{1000 - second} s left")
    assert log.lines[:3] == ["999 s left", "3% done: 969 s left", "10% done: 900 s left"]
    assert log.lines[-1] == "90% done: 100 s left"
    assert len(log.lines) == 11
    assert "\r" not in log.stream.getvalue()


def test_in_a_log_lines_are_half_a_minute_apart_and_short_work_writes_none(
    monkeypatch: pytest.MonkeyPatch,
):
    log = Log(monkeypatch)
    with ShareProgress() as progress:
        for second in range(101):
            log.seconds = float(second)
            progress(second / 100, "night")
    assert log.lines == ["night", "31% done: night", "61% done: night", "91% done: night"]
    log = Log(monkeypatch)
    with ShareProgress() as progress:
        for share in (0.0, 0.5, 1.0):
            progress(share, "night")
    assert log.lines == []


def test_in_a_log_steps_are_written_once_the_command_takes_long(monkeypatch: pytest.MonkeyPatch):
    log = Log(monkeypatch)
    with TerminalProgress(4) as steps:
        for second, label in ((0, "reading fir"), (29, "auditing"), (31, "analysing"), (60, "end")):
            log.seconds = float(second)
            steps.begin(label)
    assert log.lines == ["step 3 of 4: analysing"]


def test_steps_that_are_lines_are_all_written_on_a_terminal_and_seldom_in_a_log(
    monkeypatch: pytest.MonkeyPatch,
):
    log = Log(monkeypatch)
    show = step_lines()
    for second in range(65):
        log.seconds = float(second)
        show(0.0, f"step {second // 20}")
    assert log.lines == ["step 1", "step 3"]
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    show = step_lines()
    for what in ("a", "a", "b"):
        show(0.0, what)
    assert terminal.getvalue() == "a\nb\n"

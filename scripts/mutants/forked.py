"""Pytest in a forked process, which may hang, crash or take too long without harming its parent.

A test that takes too long ends its process. Raising an exception from outside would not work: it
may strike while a thread is waited for, after which the executor waits for all its remaining work,
and other threads wait for ever. The log of the process shows the state of each thread.
"""

from __future__ import annotations

import faulthandler
import os
import resource
import signal
import sys
import time
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

COLLECTION_S = 120.0
"""Processor time for the imports of the tests."""
MEMORY_BYTES = 8 * 2**30
"""Maximum memory of one process, as some mutants allocate everything."""
CRASHES = [-number for number in (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE)]
"""Exit codes of a process that crashed, as opposed to being killed."""


@dataclass(frozen=True)
class Task:
    """Task for pytest in a copy of the project.

    Attributes
    ----------
    arguments
        Arguments of pytest: files, options.
    limits
        Maximum processor seconds of each test.
    limit
        Maximum for tests that are not in `limits`.
    only
        Tests to run, in this order. None: all but those in `without`.
    coverage
        File that records which test ran which lines of the library. None: no recording.
    """

    arguments: Sequence[str]
    limits: Mapping[str, float] = field(default_factory=dict)
    limit: float = 30.0
    only: Sequence[str] | None = None
    without: Sequence[str] = ()
    coverage: Path | None = None


@dataclass
class Outcome:
    """Results of the tests.

    Attributes
    ----------
    seconds
        Processor time of each test that passed.
    failed
        Failed tests in order, or "collection" if something failed outside of tests.
    stopped_in
        Test that ended the process, or "collection". Empty if none did.
    why
        "failure", or "time" or "crash" if the process ended.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    stopped_in: str = ""
    why: str = "failure"


class Narrator:
    """Pytest plugin that selects tests, limits their processor time, and reports results."""

    def __init__(self, task: Task, parent: Connection, coverage: Coverage | None) -> None:
        self.task = task
        self.parent = parent
        self.coverage = coverage
        self.outcomes: list[str] = []

    def pytest_sessionstart(self) -> None:
        """Use the same examples in every run, without shrinking, which takes long."""
        from hypothesis import Phase, settings

        settings.register_profile(
            "mutants",
            deadline=None,
            derandomize=True,
            database=None,
            phases=[Phase.explicit, Phase.generate],
        )
        settings.load_profile("mutants")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        only, without = self.task.only, set(self.task.without)
        if only is None:
            items[:] = [item for item in items if item.nodeid not in without]
        else:
            place = {test: number for number, test in enumerate(only)}
            chosen = [item for item in items if item.nodeid in place]
            items[:] = sorted(chosen, key=lambda item: place[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        test = item.nodeid
        self.outcomes = []
        self.parent.send(("begins", test))
        if self.coverage:
            self.coverage.switch_context(test)
        started = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, self.task.limits.get(test, self.task.limit))
        result = yield
        signal.setitimer(signal.ITIMER_PROF, 0)
        self.parent.send((self.outcome(), test, time.process_time() - started))
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.outcomes.append(report.outcome)

    def outcome(self) -> str:
        """Return the worst outcome of setup, call and teardown."""
        return next((o for o in ("failed", "skipped") if o in self.outcomes), "passed")


def in_child(tree: Path, task: Task, parent: Connection) -> None:
    """Run pytest in a copy, with the log beside its files."""
    os.setsid()
    os.chdir(tree)
    log = os.open("pytest.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    # at the end of its time the process logs its threads, then ends as by default
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    faulthandler.register(signal.SIGPROF, log, all_threads=True, chain=True)
    signal.setitimer(signal.ITIMER_PROF, COLLECTION_S)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    sys.path.insert(0, str(tree))
    coverage = None
    if task.coverage:
        coverage = Coverage(task.coverage, config_file=False, source=["nvcore"])
        coverage.set_option("run:relative_files", True)
        coverage.start()
    options = ["-q", "--tb=short", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
    options += [f"-pno:{plugin}" for plugin in ("cacheprovider", "xdist", "cov")]
    code = pytest.main([*options, *task.arguments], [Narrator(task, parent, coverage)])
    if coverage:
        coverage.stop()
        coverage.save()
    parent.send(("ends", int(code)))
    os._exit(0)


def run_pytest(tree: Path, task: Task) -> Outcome:
    """Run a task in its own process. Raise `RuntimeError` if pytest cannot run at all."""
    fork = get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)
    child = fork.Process(target=in_child, args=(tree, task, sender))
    child.start()
    sender.close()
    outcome = Outcome(stopped_in="collection", why="time")
    limit = COLLECTION_S
    try:
        # the processor is shared, so only a very long time shows that a process is blocked
        while receiver.poll(120 + 20 * limit):
            event, *values = receiver.recv()
            if event == "ends":
                check_ending(values[0], outcome, tree)
                return outcome
            test = outcome.stopped_in = values[0]
            limit = task.limits.get(test, task.limit)
            if event == "passed":
                outcome.seconds[test] = values[1]
            elif event == "failed":
                outcome.failed.append(test)
        os.kill(child.pid or 0, signal.SIGPROF)  # it is blocked, so let it log where
        child.join(10)
    except EOFError:
        child.join()
        if child.exitcode == 1:  # pytest raises at its very end after errors outside of tests
            check_ending(pytest.ExitCode.INTERNAL_ERROR, outcome, tree)
        elif child.exitcode in CRASHES:
            outcome.why = "crash"
        elif child.exitcode != -signal.SIGPROF:
            raise RuntimeError(f"pytest was ended: see {tree / 'pytest.log'}") from None
    finally:
        if child.is_alive() and child.pid:
            os.killpg(child.pid, signal.SIGKILL)
        child.join()
        receiver.close()
    return outcome


def check_ending(code: int, outcome: Outcome, tree: Path) -> None:
    """Update the outcome from the exit code of pytest."""
    if code == pytest.ExitCode.USAGE_ERROR:
        raise RuntimeError(f"pytest could not run: see {tree / 'pytest.log'}")
    outcome.stopped_in, outcome.why = "", "failure"
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        # with -x, a file that cannot be collected ends a run like a failed test
        outcome.failed = outcome.failed or ["collection"]

"""Startup and shutdown of the server, and its work in the background.

An invalid configuration stops the start, before any visitor can run into it. The results that the
first visitor needs are computed in the background.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import logging
import os
import signal
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import cache
from itertools import chain
from types import FrameType
from typing import Any, Final

from nvcore.common.errors import InputError, NvcoreError
from nvcore.comparison.compare import compare
from nvcore.evidence.companions import find_companions
from nvcore.evidence.units import find_units
from nvcore.inputs.files.find import find_all
from nvcore.inputs.session.toml import read_session
from ui.access.files import local_root
from ui.confined import process
from ui.jobs import companions
from ui.jobs.computed import MOST
from ui.serving.connections import guard_connections
from ui.session import lifetime
from ui.session.results import cached_evidence, cached_findings, cached_miss_rate, comparison_key
from ui.session.state import kept_result, shared_start
from ui.settings.limits import limits_of_environment
from ui.settings.start import start_file
from ui.subject import subject_pages

_shutdown = threading.Event()
EVERY_S: Final = 3600.0
"""Interval of deletions, short enough to delete a study on the day it ends."""
_LOG = logging.getLogger("nvcore.ui")


def is_shutting_down() -> bool:
    """Whether the server was told to stop and only finishes its pending answers."""
    return _shutdown.is_set()


def watch_for_shutdown() -> None:
    """Notice SIGINT and SIGTERM, and pass them on to the handlers installed before."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _noting_shutdown(signal.getsignal(number)))


def _noting_shutdown(handler: Any) -> Callable[[int, FrameType | None], Any]:
    def handle(number: int, frame: FrameType | None) -> Any:
        _shutdown.set()
        if callable(handler):
            return handler(number, frame)
        if handler != signal.SIG_IGN:  # the system's default action
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        return None

    return handle


@asynccontextmanager
async def lifespan(_app: Any) -> AsyncIterator[None]:
    """Start the server's background work. At shutdown, stop it and remove all uploads."""
    lifetime.close_sessions_on(asyncio.get_running_loop())
    watch_for_shutdown()
    guard_connections()
    # early visitors wait for results that are not ready yet
    threading.Thread(target=_prepare, name="prepare", daemon=True).start()
    deleting = asyncio.create_task(keep_deleting_ended())
    try:
        yield
    finally:
        deleting.cancel()
        lifetime.remove_own()


def check_start() -> None:
    """Check limits, session, local folder, and the folders for uploads and answers.

    Also removes uploads left behind by servers that were killed.

    Raises
    ------
    InputError
        If one of them cannot be used.
    """
    limits_of_environment()
    local_root()
    session = start_file()
    if session is not None:
        find_all(read_session(session))
    for studies in chain(*(subject.studies() for subject in subject_pages())):
        if os.environ.get(studies.variable):
            studies.store()
    try:
        lifetime.process_folder(lifetime.base_folder())
    except OSError as error:
        raise InputError(
            f"uploads cannot be kept there ({error.strerror}); name a folder that the server may "
            f"write to: {lifetime.UPLOAD_FOLDER}",
            file=error.filename,
        ) from error


@cache
def settle_memory() -> None:
    """Exempt the objects that the first page has loaded from garbage collection.

    Streamlit collects garbage after every run, which then takes a third of the time.
    """
    gc.collect()
    gc.freeze()


def _prepare() -> None:
    with contextlib.suppress(NvcoreError, OSError):  # reported when a visitor needs it
        prepare_start()
        process.warm_up()


def prepare_start() -> None:
    """Compare and audit the start data, which also compiles the kernels."""
    shared = shared_start()
    shared.new_pictures()
    opened, cached = shared.opened, shared.cached
    dataset, protocol, settings = opened.dataset, opened.session.protocol, opened.params
    x, y = dataset.compared()
    if x is None or y is None:
        return
    result = kept_result(cached, settings, x, y, lambda: compare(dataset, settings, x=x, y=y))
    evidence = cached_evidence(cached, result, protocol)
    if companions.is_quick(result):
        cached(
            companions.RUN.name,
            comparison_key(result, protocol),
            lambda: find_companions(
                result,
                evidence,
                protocol,
                miss_rate=cached_miss_rate(cached, result, find_units(result), protocol),
            ),
            most=MOST,
        )
    cached_findings(cached, dataset, settings, x, y)


async def keep_deleting_ended() -> None:
    """Delete finished studies now and every hour, until cancelled."""
    while True:
        await asyncio.to_thread(delete_ended)
        await asyncio.sleep(EVERY_S)


def delete_ended() -> None:
    """Delete finished studies with all their answers."""
    for studies in chain(*(subject.studies() for subject in subject_pages())):
        if not studies.file().is_file():
            continue
        try:
            studies.store()  # opening it deletes them
        except InputError as error:
            _LOG.warning("Could not delete the answers of finished studies: %s", error)

"""Computes what the first visitor would otherwise wait for, while the server starts."""

from __future__ import annotations

import contextlib
import gc
import threading
from functools import cache

from nvcore.comparison import compare
from nvcore.errors import NvcoreError
from nvcore.evidence.companions import find_companions
from nvcore.evidence.units import find_units
from ui.confined import process
from ui.jobs import companions
from ui.session.results.comparison import result_kept_by
from ui.session.results.evidence import comparison_key, evidence_kept_by, miss_rate_kept_by
from ui.session.results.findings import findings_kept_by
from ui.session.state import shared_start


@cache
def settle_memory() -> None:
    """After the first page, once: what it has loaded stays, and is not looked through any more.

    Streamlit collects garbage after every run, which then takes a third of the time.
    """
    gc.collect()
    gc.freeze()


def start_preparing() -> None:
    """Prepare in a background thread; early visitors wait for whatever is not ready yet."""
    threading.Thread(target=_prepare, name="prepare", daemon=True).start()


def _prepare() -> None:
    with contextlib.suppress(NvcoreError, OSError):  # reported when a visitor needs it
        prepare_start()
        process.warm_up()


def prepare_start() -> None:
    """Compare and audit what every visitor starts with, which also compiles the kernels."""
    shared = shared_start()
    shared.new_pictures()
    opened, cached = shared.opened, shared.cached
    dataset, protocol, settings = opened.dataset, opened.session.protocol, opened.params
    x, y = dataset.compared()
    if x is None or y is None:
        return
    result = result_kept_by(cached, settings, x, y, lambda: compare(dataset, settings, x=x, y=y))
    evidence = evidence_kept_by(cached, result, protocol)
    if companions.is_quick(result):
        cached(
            companions.KIND,
            comparison_key(result, protocol),
            lambda: find_companions(
                result,
                evidence,
                protocol,
                miss_rate=miss_rate_kept_by(cached, result, find_units(result), protocol),
            ),
            most=companions.MOST,
        )
    findings_kept_by(cached, dataset, settings, x, y)

"""What the first visitor would have to wait for, made while the server starts."""

from __future__ import annotations

import contextlib
import threading

from nvcore.comparison import compare
from nvcore.errors import NvcoreError
from ui.confined import process
from ui.session.evidence import evidence_kept_by
from ui.session.state import shared_start


def begin_to_prepare() -> None:
    """Prepare in a thread of its own: visitors who come before it is done wait for the rest."""
    threading.Thread(target=_prepare, name="prepare", daemon=True).start()


def _prepare() -> None:
    with contextlib.suppress(NvcoreError, OSError):  # what fails now is said when it is needed
        prepare_start()
        process.warm_up()


def prepare_start() -> None:
    """Compare what every visitor starts with; by the way this compiles the loops."""
    shared = shared_start()
    dataset, protocol = shared.opened.dataset, shared.opened.session.protocol
    x, y = dataset.compared()
    if x is None or y is None:
        return
    settings = dataset.params_of()
    result = shared.cached("result", (settings, x, y), lambda: compare(dataset, settings, x=x, y=y))
    evidence_kept_by(shared.cached, result, protocol)

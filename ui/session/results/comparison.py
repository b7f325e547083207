"""The cached comparison of X and Y."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nvcore.comparison import Result
from nvcore.params import Params
from nvcore.stages import SALIENT, THRESHOLD

Cached = Callable[..., Any]
"""`ui.session.cache.Caching.cached`."""


def result_kept_by(
    cached: Cached, params: Params, x: str, y: str, make: Callable[[], Result]
) -> Result:
    """The comparison, computed by `make` unless `cached` has it."""
    result: Result = cached("result", (params, x, y), make)
    return result


def of_boxes(settings: Params) -> Params:
    """Settings that move boxes, matches or most salient misses.

    The others have their defaults: drawn boxes stay valid while only those others change.
    """
    return settings.only_for(THRESHOLD, SALIENT)

"""The tests of the Ratings page fit and correlate the same ratings once, and quickly."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

from nvcore.comparison.compare import Result
from nvcore.subjects.ratings import fit as fitting
from nvcore.subjects.ratings.agreement import Agreement, measure_agreement
from nvcore.subjects.ratings.validation import correlate
from ui.subjects.ratings import fit, results

_made: dict[Any, Any] = {}


def fit_once(result: Result, clips: pd.DataFrame, **options: Any) -> Any:
    key = fitting.HEIGHT_SHARES, result.dataset.fingerprint, result.params, clips.to_csv()
    if key not in _made:
        _made[key] = fitting.fit_saliency(result, clips, **options)
    return _made[key]


def correlate_once(saliency_s: np.ndarray, mean_rank: np.ndarray) -> Any:
    key = saliency_s.tobytes(), mean_rank.tobytes()
    if key not in _made:
        _made[key] = correlate(saliency_s, mean_rank)
    return _made[key]


def agree_once(ranks: pd.DataFrame) -> Agreement:
    key = ranks.to_csv()
    if key not in _made:
        _made[key] = measure_agreement(ranks)
    return _made[key]


@pytest.fixture(autouse=True)
def made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit, "fit_saliency", fit_once)
    monkeypatch.setattr(results, "correlate", correlate_once)
    monkeypatch.setattr(results, "measure_agreement", agree_once)


@pytest.fixture
def few_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit tries the settings only that fit the sample's ratings best, and some beside them."""
    monkeypatch.setattr(fitting, "HEIGHT_SHARES", (0.075,))
    monkeypatch.setattr(fitting, "TOLERANCES", (0.05, 0.1))

"""What the driver adds to the verdict, the terminal's report and the first page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.comparison import Result
from nvcore.dataset import Dataset
from nvcore.driver.comparison.columns import driver_views
from nvcore.driver.comparison.doubts import is_stated, is_weighted
from nvcore.driver.comparison.steps import driver_in
from nvcore.driver.comparison.texts import (
    describe_basis,
    describe_doubt,
    describe_driver,
    describe_weighting,
    regions_text,
    weighting,
)
from nvcore.measures.entry import Measure
from nvcore.report.remarks import Remarks
from nvcore.report.verdict import PointOf
from nvcore.wording import capitalised

POINTS: Final = (
    PointOf("Weighting", describe_weighting, after="Operating points", is_warning=True),
    PointOf("The driver", describe_driver, after="Time left"),
)


def lines(result: Result) -> list[str]:
    """Who sees the encounters, and on whose word, for the terminal."""
    if not driver_in(result).has_any:
        return []
    basis = describe_basis(result)
    return [
        f"encounters seen by: {regions_text(result)}",
        f"the driver: {basis[0].lower()}{basis[1:-1]}",
    ]


def _limits(result: Result) -> tuple[str, ...]:
    return (
        describe_doubt(result) or _estimated(result),
        " ".join(describe_weighting(result)),
    )


def _estimated(result: Result) -> str:
    """Why what is said of the driver is to be doubted; empty: nothing is known, or nothing said."""
    estimate = result.dataset.of("driver")
    if not driver_in(result).has_any or estimate is None or is_stated(result):
        return ""
    if not estimate.caution:
        return ""
    return result.objects.say(
        "{What} the driver sees is estimated: {caution}.", caution=estimate.caution
    )


def _of_claims(result: Result, measures: Sequence[Measure]) -> str:
    """That claims are of measures weighted by what the driver does not see; empty: none is."""
    if not is_weighted(result):
        return ""
    if not any(measure.depends_on("driver_weighting") for measure in measures):
        return ""
    return " (similarity, saliency and severity weighted by 1 - detectability)"


def _views(dataset: Dataset) -> list[str]:
    """What is known of the driver's view of each recording, in words; empty: nothing."""
    views = driver_views(dataset)
    words_of = {
        "pictures of visible light": views["has_visible"],
        "light meter": views["light_by"] == "meter",
        "gaze": views["has_gaze"],
    }
    return [
        capitalised(", ".join(text for text, is_there in words_of.items() if is_there[i]))
        for i in range(len(dataset.recordings))
    ]


REMARKS: Final = Remarks(weighting, _limits, _of_claims, ("Driver's view", _views))

"""All maps in one table, and every map in words and in a figure whatever the data are."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pandas as pd
import pytest
from builders import Place, at, make_dataset, result_of
from scenes import draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import map_stability
from nvcore.evidence.stability.notes import (
    CRITERIA,
    describe_chance,
    describe_stability,
    share_text,
)
from nvcore.evidence.stability.scores import Criterion
from nvcore.evidence.stability.survey import (
    SURVEY_PLANES,
    SurveyRow,
    held_text,
    survey_stability,
    survey_table,
)
from nvcore.evidence.table import evidence_table
from nvcore.figures.maps import stability_map
from nvcore.settings.params import Params

ONE = [at(0, 50, score=0.5), at(0, 20, score=0.2)]
CASES: dict[str, Result] = {
    "no frames": result_of(make_dataset(n_frames=0)),
    "no boxes": result_of(make_dataset(n_frames=3)),
    "one frame": result_of(make_dataset([at(0, 50)], ONE, ONE)),
    "no scores": result_of(make_dataset([at(0, 50)], [at(0, 50)], [])),
    "scores of one only": result_of(make_dataset([at(0, 50)], ONE, [at(0, 50)])),
    "all distant": compare(make_dataset([at(0, 50, h=1.0)], ONE, []), Params()),
    "two heights": compare(
        make_dataset(
            [at(0, 50, recording=0), at(0, 50, recording=1)], ONE, ONE,
            places=[Place([0], height=100), Place([0], height=300)],
        ),
        Params(),
    ),
    "threshold above all": result_of(make_dataset([at(0, 50)], ONE, ONE), threshold_x=2.0),
    "scene": compare(draw_scene(44).dataset(), Params()),
}  # fmt: skip
WITHOUT_THRESHOLDS = {"no frames", "no boxes", "no scores"}
AS_ANALYSED = "as analysed"
OVERTURNING = "nearest that overturns it"


@pytest.mark.parametrize("case", CASES)
def test_every_map_is_told_and_drawn(case: str) -> None:
    result = CASES[case]
    evidence = evidence_table(result)
    for plane in get_args(Plane):
        if plane == "thresholds" and case in WITHOUT_THRESHOLDS:
            continue
        for criterion in get_args(Criterion):
            stability = map_stability(result, plane, criterion, n_points=5)
            chance = describe_chance(stability, evidence)
            sentences = (*describe_stability(stability), *filter(None, [chance]))
            assert sentences[0].startswith("As analysed")
            assert all(sentence.endswith(".") and "  " not in sentence for sentence in sentences)
            drawn = stability_map(stability, theme="dark").to_plotly_json()
            text = str(drawn["layout"])
            if not np.isfinite(stability.difference).any():
                assert "The comparison is undefined here" in text
                continue
            assert f"Who is better by {CRITERIA[criterion]}" in text
            held = f"holds in {share_text(stability.share_held)} of the plausible range"
            assert (held in text) == np.isfinite(stability.share_held)
            marked = {part["name"] for part in drawn["data"]} & {AS_ANALYSED, OVERTURNING}
            expected = {AS_ANALYSED: np.isfinite(stability.present_difference),
                        OVERTURNING: stability.overturn is not None}  # fmt: skip
            assert marked == {name for name, is_there in expected.items() if is_there}


@pytest.mark.parametrize("case", ["no frames", "no scores", "scores of one only", "two heights"])
def test_every_map_has_a_row(case: str) -> None:
    table = survey_table(survey_stability(CASES[case]))
    assert len(table) == len(SURVEY_PLANES) * len(get_args(Criterion))
    assert (table[["verdict", "share", "nearest"]] != "").all(axis=None)
    no_map = table["share"] == "no such map"
    assert set(table.loc[no_map, "plane"]) == (
        {"thresholds"} if case in WITHOUT_THRESHOLDS else set()
    )


def test_the_row_says_what_the_map_says() -> None:
    # X - Y = 0.5 - 1.5 alpha
    data = make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)])
    table = survey_table(survey_stability(result_of(data))).set_index(["plane", "criterion"])
    row = table.loc[("alpha-midpoint", "similarity")]
    assert row["settings"] == "Alpha and what counts as near"
    assert row["by"] == "mean similarity"
    assert row["verdict"] == "Y has the higher mean similarity, by 0.8500"
    assert row["share"] == "all"
    assert row["nearest"].startswith("alpha 0.3333, where it turns to X, outside the plausible")
    assert table.loc[("edge-weight-alpha", "encounters"), "share"] == "does not depend on them"


def test_a_verdict_is_undefined_where_its_map_is() -> None:
    rows = survey_stability(CASES["all distant"])
    assert {held_text(row) for row in rows if row.criterion == "encounters"} == {"undefined"}
    near = compare(make_dataset([at(0, 50, h=5.0)], [at(0, 50, h=5.0)], []), Params(midpoint=4.0))
    stability = map_stability(near, "alpha-midpoint", "encounters")  # 100 px high picture
    assert held_text(SurveyRow("alpha-midpoint", "encounters", stability)) == "undefined there"


def test_progress_runs_over_all_maps() -> None:
    shares: list[float] = []
    survey_stability(CASES["one frame"], progress=lambda share, _what: shares.append(share))
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0, 1)


def evidence(**p_of_figures: float) -> pd.DataFrame:
    """Corrected p by figure."""
    rows = [
        {"figure": figure, "p": p, "p_corrected": min(2 * p, 1), "n": 12, "note": "too few; x"}
        for figure, p in p_of_figures.items()
    ]
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("criterion", "p_of_figures", "text"),
    [
        ("similarity", {"mean_similarity": 0.58},
         "This difference is not shown to be more than chance (12 recordings, p = 0.58; 1 "
         "after correction for all measures). A verdict that holds at other settings is no "
         "evidence against chance."),
        ("saliency", {"saliency": 0.02},
         "This difference is unlikely to be chance (12 recordings, p = 0.02; 0.04 after "
         "correction for all measures). The verdict decides whether it may be claimed."),
        # encounters are alike within recordings: McNemar's test of them one by one says nothing
        ("encounters", {"encounters_detected": 0.01, "encounters_detected_by_unit": 0.3},
         "not shown to be more than chance (12 recordings, p = 0.3; 0.6 after"),
        ("similarity", {"mean_similarity": np.nan},
         "It cannot be tested here whether this difference is more than chance (too few). A"),
    ],
)  # fmt: skip
def test_what_p_says_of_the_difference_stands_with_the_map(
    criterion: Criterion, p_of_figures: dict[str, float], text: str
) -> None:
    stability = map_stability(CASES["no scores"], "edge-weight", criterion)  # X is better
    assert text in describe_chance(stability, evidence(**p_of_figures))


def test_a_tie_has_no_evidence() -> None:
    stability = map_stability(CASES["one frame"], "edge-weight", "similarity")
    assert stability.verdict == "even"
    assert describe_chance(stability, evidence(mean_similarity=1.0)) == ""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import NAN
from drives import at_thresholds, by_figure, drives, turned_by_strict_pairing

from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.claims import find_claims
from nvcore.evidence.companions import find_companions
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.evidence.paired_tests import holm
from nvcore.evidence.pairwise import (
    CLAIMED,
    COLUMNS,
    SYSTEM_COLUMNS,
    pairwise_table,
    systems_of,
    thresholds_in_use,
)
from nvcore.evidence.table import evidence_table
from nvcore.settings.params import Params


def three() -> Dataset:
    """Systems x, y, and z, which detects what y detects in the first half of the recordings."""
    dataset = drives(12)
    boxes = dataset.boxes
    of_y = boxes[(boxes["source"] == 2) & (boxes["frame_index"] < 120)].assign(source=3, score=0.5)
    return dataset_from_tables(
        dataset.recordings, [np.arange(20)] * 12, pd.concat([boxes, of_y]), ["x", "y", "z"]
    )


def test_every_two_systems_have_the_measures_of_their_comparison() -> None:
    dataset = three()
    table = pairwise_table(dataset)
    assert tuple(table.columns) == COLUMNS
    assert table[["x", "y"]].to_numpy().tolist() == [["x", "y"], ["x", "z"], ["y", "z"]]
    for row in table.to_dict("records"):
        alone = by_figure(compare(dataset, Params(), x=row["x"], y=row["y"]))
        encounters, similarity = alone.loc["encounters_detected"], alone.loc["mean_similarity"]
        assert row["mcnemar_p"] == encounters["p"]
        assert row["difference"] == encounters["difference"]
        assert row["odds_ratio"] == encounters["effect"]
        assert row["similarity_difference"] == similarity["difference"]
        by_unit = alone.loc["encounters_detected_by_unit"]
        assert row["similarity_low"] == similarity["low"]
        assert row["detected_by_unit_high"] == by_unit["high"]
        # without scores no threshold sets the third system like the others
        p = [NAN, NAN] if row["is_unequal"] else [similarity["p"], by_unit["p"]]
        assert [row["similarity_p"], row["detected_by_unit_p"]] == pytest.approx(p, nan_ok=True)


def test_a_note_stands_at_its_own_measure_and_speaks_of_no_x_and_y() -> None:
    dataset = three()
    boxes = dataset.boxes[dataset.boxes["source"] != 3]
    of_y = boxes[boxes["source"] == 2]
    # z shows what y shows, and false boxes: it detects the same encounters
    of_z = [of_y.assign(source=3), of_y.assign(source=3, x=0.0, w=1.0)]
    names = ["x", "y", "z"]
    with_false = dataset_from_tables(
        dataset.recordings, [np.arange(20)] * 12, pd.concat([boxes, *of_z]), names
    )
    (row,) = pairwise_table(with_false, systems=["y", "z"]).to_dict("records")
    assert (row["difference"], row["similarity_difference"] != 0) == (0, True)
    assert row["detected_by_unit_note"].startswith("the two are the same in all recordings; ")
    why = "neither has scores that differ, so that no threshold sets the two alike"
    assert row["similarity_note"] == why


def test_holm_corrects_over_the_pairs_and_both_measures() -> None:
    table = pairwise_table(three())
    names = ["detected_by_unit_p", "similarity_p"]
    together = holm(np.concatenate([table[name] for name in names]))
    corrected = np.concatenate([table[f"{name}_holm"] for name in names])
    assert corrected.tolist() == pytest.approx(together.tolist(), nan_ok=True)
    assert "mcnemar_p_holm" not in table


def test_each_system_has_its_own_threshold() -> None:
    dataset = three()
    table = pairwise_table(dataset, thresholds={"z": 0.6})
    assert table["detected_y"].tolist()[1:] == [0, 0]
    assert table["detected_x"].iloc[0] == pairwise_table(dataset)["detected_x"].iloc[0]


def test_systems_can_be_chosen_and_ordered() -> None:
    table = pairwise_table(three(), systems=["z", "x"])
    assert table[["x", "y"]].to_numpy().tolist() == [["z", "x"]]


@pytest.mark.parametrize("systems", [[], ["x"], ["x", "x"]])
def test_fewer_than_two_systems_are_told(systems: list[str]) -> None:
    with pytest.raises(InputError, match="needs two systems or more, each once"):
        pairwise_table(three(), systems=systems)


def test_unknown_systems_are_told() -> None:
    with pytest.raises(InputError, match="no system 'w'"):
        pairwise_table(three(), systems=["x", "w"])
    with pytest.raises(InputError, match="no system 'w'"):
        pairwise_table(three(), thresholds={"w": 0.5})


def with_fewer_alarms(dataset: Dataset) -> Dataset:
    """The dataset without the false alarms of X in the first two recordings."""
    boxes = dataset.boxes
    is_gone = (boxes["source"] == 1) & (boxes["x"] > 70) & (boxes["frame_index"] < 40)
    frames = [np.arange(20)] * len(dataset.recordings)
    return dataset_from_tables(dataset.recordings, frames, boxes[~is_gone], ["x", "y"])


def test_what_is_claimed_of_a_pair_is_what_its_own_verdict_claims() -> None:
    dataset = with_fewer_alarms(drives(12))
    (row,) = pairwise_table(dataset).to_dict("records")
    assert not row["is_unequal"]
    result = compare(dataset, Params())
    evidence = evidence_table(result)
    claims = find_claims(result, evidence, find_companions(result, evidence)).claims
    winners = {claim.key: claim.winner for claim in claims}
    assert row["detects_more"] == winners["encounters_detected_by_unit"] == "x"
    assert row["higher_similarity"] == winners["mean_similarity"] == "x"
    assert row["withheld"] == ""


def test_a_winner_with_more_false_alarms_is_withheld_by_its_name() -> None:
    (row,) = pairwise_table(drives(12)).to_dict("records")
    assert row["similarity_p_holm"] <= 0.05
    assert (row["detects_more"], row["higher_similarity"]) == ("", "")
    why = (
        "(X also has more false alarms, and without scores that differ the two cannot be set to "
        "equal false alarms)"
    )
    assert row["withheld"] == f"encounters detected {why}; mean similarity {why}"


def test_a_difference_that_strict_pairing_turns_is_withheld() -> None:
    dataset = turned_by_strict_pairing()
    (row,) = pairwise_table(dataset).to_dict("records")
    assert row["similarity_p_holm"] <= 0.05
    assert row["higher_similarity"] == ""
    assert "mean similarity (" in row["withheld"]


def test_a_pair_at_unequal_operating_points_is_tested_at_equal_false_alarms() -> None:
    result = at_thresholds()
    (row,) = pairwise_table(result.dataset).to_dict("records")
    assert row["is_unequal"]
    assert row["x_only"] == result.venn.x_only
    assert row["false_alarms_per_frame_x"] > 1.5 * row["false_alarms_per_frame_y"]
    evidence = evidence_table(find_equal_alarms(result), has_intervals=False).set_index("figure")
    p = [row["detected_by_unit_p"], row["similarity_p"]]
    assert p == pytest.approx(evidence.loc[[*CLAIMED], "p"].tolist(), nan_ok=True)
    assert (row["detects_more"], row["higher_similarity"], row["withheld"]) == ("", "", "")


def test_each_system_stands_once_with_its_own_numbers() -> None:
    table = pairwise_table(three(), thresholds={"z": 0.6})
    systems = systems_of(table)
    assert tuple(systems) == SYSTEM_COLUMNS
    assert systems["system"].tolist() == ["x", "y", "z"]
    assert systems["threshold"].isna().tolist() == [True, True, False]
    assert systems["detected"].tolist() == [*table["detected_x"].iloc[[0, 2]], 0]


def test_x_and_y_have_the_live_thresholds_and_others_their_own() -> None:
    dataset = three()
    settings = replace(dataset.settings, x="z", y="x")
    params = Params(threshold_x=0.7, threshold_y=0.3)
    assert thresholds_in_use(dataset.with_settings(settings), params) == {"z": 0.7, "x": 0.3}


def test_progress_runs_over_the_pairs() -> None:
    shares: list[float] = []
    pairwise_table(three(), progress=lambda share, _: shares.append(share))
    assert shares == sorted(shares)
    assert len(shares) >= 3

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from drives import by_figure, drives

from nvcore.comparison import compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.errors import InputError
from nvcore.evidence.paired_tests import holm
from nvcore.evidence.pairwise import COLUMNS, pairwise_table
from nvcore.params import Params


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
        assert (row["similarity_low"], row["similarity_p"]) == (similarity["low"], similarity["p"])
        by_unit = alone.loc["encounters_detected_by_unit"]
        assert (row["detected_by_unit_high"], row["detected_by_unit_p"]) == (
            by_unit["high"], by_unit["p"],
        )  # fmt: skip


def test_holm_corrects_over_the_pairs_and_both_measures() -> None:
    table = pairwise_table(three())
    names = ["detected_by_unit_p", "similarity_p"]
    together = holm(np.concatenate([table[name] for name in names]))
    corrected = np.concatenate([table[f"{name}_holm"] for name in names])
    assert corrected.tolist() == together.tolist()
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

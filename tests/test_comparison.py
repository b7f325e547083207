from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pandas as pd
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of
from other_params import OTHER, WITH
from scenes import draw_scene

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.entry import Measure
from nvcore.comparison.measures.table import MEASURES
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.metrics import kernels
from nvcore.settings.params import SETTINGS, Params, settings_for
from nvcore.settings.stages import (
    COST,
    DISTANCES,
    ENCOUNTERS,
    EVENTS,
    LOW,
    MATCH,
    MISS_WEIGHTS,
    NEAREST,
    PROXIMITY,
    SALIENCY,
    SALIENT,
    SEVERITY,
    SIMILARITY,
    THRESHOLD,
    Stage,
)
from nvcore.subjects.alerts.settings import ALERTS, IN_TIME, SPEEDING
from nvcore.subjects.alerts.speeding import judge_speeding
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY
from nvcore.subjects.time_left.steps import confirmed_by, time_left_in, time_left_of

PARTS: dict[str, tuple[Stage, ...]] = {
    "matches": (MATCH,),
    "n_det": (MATCH,),
    "matched": (MATCH,),
    "false_alarms": (MATCH,),
    "episodes": (MATCH,),
    "weights": (MATCH, PROXIMITY),
    "nearest": (NEAREST,),
    "distances": (DISTANCES,),
    "salient_row": (SALIENT,),
    "events": (EVENTS,),
    "encounters": (ENCOUNTERS,),
    "failures": (SEVERITY,),
    "confirmed": (CONTACT, CONFIRMED),
    "time_left": (TIME_LEFT,),
}
"""Parts of a system's result that another comparison may take over, and what makes them."""
MADE_BY: dict[Stage, set[str]] = {
    THRESHOLD: {"x matches state", "y matches state"},
    MATCH: {"x matches truth_det"},
    PROXIMITY: {"k_truth"},
    COST: {"cost"},
    NEAREST: {f"x nearest {name}" for name in ("truth", "detections")},
    SIMILARITY: {"x similarity"},
    LOW: {"x intervals", "x similarity_window"},
    ENCOUNTERS: {"x encounters"},
    SALIENT: {"x salient_row"},
    EVENTS: {"x events"},
    SALIENCY: {"x saliency_s"},
    CONTACT: {"ttc_s"},
    URGENCY: {"urgency"},
    CONFIRMED: {"x confirmed"},
    MISS_WEIGHTS: {"k_miss"},
    DRIVER: {"detectable"},
    ALERTS: {"x alerts", "y alerts"},
    IN_TIME: {"in time for drivers"},
    SPEEDING: {"speeding"},
}
"""What a setting of a stage changes first: one of these at least."""


@pytest.fixture(scope="module")
def busy() -> Dataset:
    """Many recordings with every kind of failure."""
    scenes = [draw_scene(seed) for seed in range(12)]
    places: list[Place] = []
    boxes: list[list[Any]] = [[], [], []]
    for scene in scenes:
        for target, source in zip(boxes, (scene.truth, scene.x, scene.y), strict=True):
            target += [b._replace(recording=b.recording + len(places)) for b in source]
        places += scene.places
    for n in range(3):  # driven up to, more or less to the side, found sooner or later
        person = approach(range(40), 4.6 + 0.1 * n, centre=50 + 15 * n, recording=len(places))
        for target, frames in zip(boxes, (range(40), range(5 + n, 40), range(25, 40)), strict=True):
            seen = only(person, frames)  # only the systems know how far away
            target += seen if target is boxes[0] else [b._replace(distance_m=40.0) for b in seen]
        places.append(PLACE)
    for source, target in enumerate(boxes):  # of two classes, and now and then of none
        target[:] = [b._replace(label=(i + source) % 3 - 1) for i, b in enumerate(target)]
    boxes[0][:] = [b._replace(detectability=i % 11 / 10) for i, b in enumerate(boxes[0])]
    dataset = make_dataset(*boxes, places=places, labels=("30", "50"))
    # where the car drives at 40 km/h; elsewhere it is assumed
    kmh = np.where(dataset.frames["recording"] < 6, 40.0, np.nan)
    return dataclasses.replace(dataset, frames=dataset.frames.assign(speed_kmh=kmh))


def figures(result: Result) -> dict[str, Any]:
    """Everything in a result that is a number, by name."""
    by_name: dict[str, Any] = {
        "venn": result.venn, "exclusivity": result.exclusivity, "boxes": result.boxes,
        "category": result.category, "k_truth": result.k_truth.k, "n_truth": result.n_truth,
        "k_miss": result.k_miss, "detectable": driver_in(result).table,
        "cost": result.cost, "ttc_s": time_left_in(result).contact.ttc_s,
        "urgency": time_left_in(result).urgency,
        "track": result.tracks.track, "lead": result.lead_time_s, "duration": result.duration_s,
        "without_distance": result.k_truth.n_without_distance,
        "speeding": judge_speeding(result).episodes,
        "in time for drivers": alerts_in(result).in_time_for_drivers.table,
    }  # fmt: skip
    for name in (spec.name for spec in dataclasses.fields(result.encounters)):
        by_name[f"encounters {name}"] = getattr(result.encounters, name)
    for letter, system in (("x", result.x), ("y", result.y)):
        for part in ("matches", "weights", "nearest", "distances"):
            for name, value in vars(getattr(system, part)).items():
                by_name[f"{letter} {part} {name}"] = value
        for name in ("similarity", "similarity_window", "salient_row", "n_det", "matched",
                     "false_alarms", "events", "encounters", "failures", "episodes", "intervals",
                     "summary", "false_alarm_summary", "saliency_s"):  # fmt: skip
            by_name[f"{letter} {name}"] = getattr(system, name)
        by_name[f"{letter} confirmed"] = confirmed_by(system)
        by_name[f"{letter} time_left"] = time_left_of(system)
        by_name[f"{letter} alerts"] = alerts_in(result).of(system)
    return by_name


def differing(result: Result, other: Result) -> set[str]:
    """Names of the figures in which two results differ."""
    theirs = figures(other)
    return {name for name, value in figures(result).items() if not _is_same(value, theirs[name])}


def _is_same(value: Any, other: Any) -> bool:
    if isinstance(value, pd.DataFrame):
        return value.equals(other)
    if isinstance(value, np.ndarray):
        return np.array_equal(value, other, equal_nan=value.dtype.kind == "f")
    return repr(value) == repr(other)


def changed(name: str) -> tuple[Params, Params]:
    """Settings that differ in one parameter, where it has an effect."""
    before = Params(**WITH.get(name, {}))
    return before, dataclasses.replace(before, **{name: OTHER[name]})


def depends_on(stages: tuple[Stage, ...], letter: str) -> set[str]:
    """Settings that move the result of these stages for a system."""
    return {f"threshold_{letter}", *settings_for(*stages)}


def test_these_tests_know_every_stage() -> None:
    assert set(MADE_BY) == {setting.stage for setting in SETTINGS.values()}


@pytest.mark.parametrize("name", SETTINGS)
def test_a_parameter_changes_what_its_stage_makes(busy: Dataset, name: str) -> None:
    before, after = changed(name)
    differences = differing(compare(busy, before), compare(busy, after))
    assert differences & MADE_BY[SETTINGS[name].stage]


@pytest.mark.parametrize("name", SETTINGS)
def test_a_parameter_changes_only_measures_that_depend_on_it(busy: Dataset, name: str) -> None:
    results = [compare(busy, params) for params in changed(name)]

    def values(measure: Measure) -> list[list[float]]:
        return [[measure.of(result, system) for _, system in result.sides] for result in results]

    of_systems = [measure for measure in MEASURES if measure.of is not None]
    differ = {measure.key for measure in of_systems if not _is_same(*values(measure))}
    assert differ <= {measure.key for measure in MEASURES if measure.depends_on(name)}


@pytest.mark.parametrize("name", SETTINGS)
def test_a_parameter_leaves_the_stages_before_its_own_as_they_were(
    busy: Dataset, name: str
) -> None:
    before, after = changed(name)
    previous = compare(busy, before)
    result = compare(busy, after, previous=previous)
    assert not differing(result, compare(busy, after))
    for letter in "xy":
        here, there = getattr(result, letter), getattr(previous, letter)
        taken_over = {part for part in PARTS if here.made[part] is there.made[part]}
        assert taken_over == {
            part for part, stages in PARTS.items() if name not in depends_on(stages, letter)
        }


def test_figures_do_not_depend_on_the_number_of_threads(
    busy: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = compare(busy)
    monkeypatch.setattr(kernels, "MIN_PER_THREAD", 1)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert not differing(compare(busy), whole)


def test_a_previous_result_of_another_dataset_is_not_used() -> None:
    dataset, other = make_dataset([at(0, 50, track=1)]), make_dataset([at(0, 20, track=1)])
    result = compare(other, previous=compare(dataset))
    assert result.x.distances.d_miss[0] == pytest.approx(20)


def test_exchanged_systems_with_a_previous_result_are_exchanged(busy: Dataset) -> None:
    previous = compare(busy)
    result = compare(busy, x="y", y="x", previous=previous)
    assert not differing(result, compare(busy, x="y", y="x"))
    assert (result.venn.x_only, result.venn.y_only) == (previous.venn.y_only, previous.venn.x_only)


def test_one_system_against_itself_with_two_thresholds_is_a_comparison() -> None:
    truth = [at(0, 20, track=1), at(0, 70, track=2)]
    dataset = make_dataset(truth, [at(0, 20, score=0.9), at(0, 70, score=0.4)])
    result = result_of(dataset, threshold_x=0.3, threshold_y=0.5)
    assert result.y.n_det.tolist() == [0]
    itself = compare(dataset, Params(threshold_x=0.3, threshold_y=0.5), x="x", y="x")
    assert (itself.venn.both, itself.venn.x_only) == (1, 1)


def test_a_dataset_without_any_detection_misses_all_encounters() -> None:
    result = result_of(make_dataset([at(f, 50, track=1) for f in range(3)]))
    assert result.venn.neither == 1
    assert result.x.similarity == pytest.approx([0.1, 0.1, 0.1])
    assert result.x.encounters["miss_class"].tolist() == ["never"]
    assert np.isnan(result.exclusivity.phi)


def test_a_dataset_without_any_truth_has_false_alarms_and_no_encounter() -> None:
    result = result_of(make_dataset(x=[at(0, 50), at(2, 50)]))
    assert result.n_truth.tolist() == [0, 0, 0]
    assert result.x.similarity == pytest.approx([0.9, 1, 0.9])
    assert result.x.saliency_s == 0
    assert result.x.false_alarm_summary.count == 2
    assert result.venn.n_near == 0


def test_a_dataset_without_frames_is_undefined_not_an_error() -> None:
    result = result_of(make_dataset())
    assert np.isnan(result.x.summary.mean)
    assert result.duration_s == 0
    assert result.x.similarity_window.size == 0


def one_system() -> Dataset:
    dataset = make_dataset([at(0, 50, track=1)], [at(0, 50)])
    return dataset_from_tables(dataset.recordings, [np.arange(1)], dataset.boxes, ["only"])


def test_a_comparison_needs_two_systems() -> None:
    with pytest.raises(InputError, match=r"needs two systems; there is 1 \(only\)"):
        compare(one_system())


def test_a_single_system_may_be_compared_with_itself_by_name() -> None:
    assert compare(one_system(), Params(proximity="none"), x="only", y="only").venn.both == 1


def test_an_unknown_system_is_refused() -> None:
    with pytest.raises(InputError, match="there is no system 'z'; there are x, y"):
        compare(make_dataset(n_frames=1), y="z")


def test_the_dataset_is_not_changed(busy: Dataset) -> None:
    before = [table.copy() for table in (busy.recordings, busy.frames, busy.boxes)]
    compare(busy, Params(**{**OTHER, "proximity": "horizon"})).fusion  # noqa: B018
    for table, copy in zip((busy.recordings, busy.frames, busy.boxes), before, strict=True):
        pd.testing.assert_frame_equal(table, copy)

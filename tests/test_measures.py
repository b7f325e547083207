"""Every entry of the table of measures: what it says of itself holds for its values."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pandas as pd
import pytest
from approach import approach, only
from builders import Place, at, make_dataset, result_of
from drives import drives

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Measure
from nvcore.comparison.measures.table import (
    EVIDENCE_KEYS,
    MEASURES,
    evidence_form,
    evidence_label,
    inference_of,
    label_words,
    measure_of,
    size_text,
)
from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import detection_curve
from nvcore.report.matrix import PAIR_MEASURES
from nvcore.report.tiles import KINDS
from nvcore.report.verdict.points import QUALITIES
from nvcore.settings.objects import PEDESTRIAN

OF_SYSTEMS = [measure for measure in MEASURES if measure.of is not None]
OF_CURVES = [measure for measure in MEASURES if measure.of_curve is not None]
OF_RECORDINGS = [measure for measure in OF_SYSTEMS if measure.by_recording is not None]


def key_of(measure: Measure) -> str:
    return measure.key


@pytest.fixture(scope="module")
def perfect() -> Result:
    """Twelve recordings; X is the truth itself, Y misses and invents."""
    rng = np.random.default_rng(3)
    truth, y = [], []
    for recording in range(12):
        for frame in range(12):
            for track, centre in ((1, 30), (2, 60)):
                truth.append(
                    at(frame, centre, recording=recording, track=track, score=rng.random())
                )
                if rng.random() < 0.6:
                    y.append(truth[-1])
            if rng.random() < 0.3:
                y.append(at(frame, 90, recording=recording, score=rng.random()))
        person = approach(range(12), 2.9, track=3, recording=recording)
        truth += person
        y += only(person, range(12 if recording % 2 else 9))
    truth = [box._replace(detectability=0.2) for box in truth]
    return result_of(make_dataset(truth, truth, y, places=[Place(range(12))] * 12), alerts="policy")


@pytest.fixture(scope="module")
def alone() -> Result:
    """One recording."""
    return result_of(drives(1), alerts="policy")


def test_no_key_and_no_name_of_a_rule_stands_twice():
    names = Counter(measure.rule or measure.key for measure in MEASURES)
    assert [name for name, n in names.items() if n > 1] == []
    assert max(Counter(map(key_of, MEASURES)).values()) == 1


@pytest.mark.parametrize("measure", MEASURES, ids=key_of)
def test_labels_name_only_what_a_result_has(measure: Measure, alone: Result):
    label = PEDESTRIAN.say(measure.label, **label_words(alone, "recordings"))
    assert label
    assert "{" not in label
    part = PEDESTRIAN.say(measure.part)
    assert PEDESTRIAN.say(measure.part, **label_words(alone)) == part


@pytest.mark.parametrize("measure", OF_SYSTEMS, ids=key_of)
def test_values_fit_their_format(measure: Measure, perfect: Result):
    value = measure.of(perfect, perfect.y)
    assert np.isfinite(value)
    assert format(value, measure.form)


@pytest.mark.parametrize("measure", OF_SYSTEMS, ids=key_of)
def test_a_perfect_system_is_never_the_worse_one(measure: Measure, perfect: Result):
    x, y = (measure.of(perfect, system) for system in (perfect.x, perfect.y))
    if measure.better == "higher":
        assert x >= y
    if measure.better == "lower":
        assert x <= y or np.isnan(x)


@pytest.mark.parametrize("measure", OF_CURVES, ids=key_of)
def test_a_perfect_curve_is_never_the_worse_one(measure: Measure, perfect: Result):
    curves = (
        detection_curve(perfect.dataset, system.name, perfect.params)
        for system in (perfect.x, perfect.y)
    )
    x, y = (measure.of_curve(summarise_curve(curve, 0.1)) for curve in curves)
    if measure.better == "higher":
        assert x >= y
    if measure.better == "lower":
        assert x <= y


@pytest.fixture(scope="module")
def alarming() -> Result:
    """Y is X with a false alarm of the highest score in every frame, of help to no pedestrian.

    The driver does not see the first pedestrian, who becomes urgent and is detected late; the
    second one, farther to the side, is missed in half of the frames.
    """
    frames = range(40)
    first = [box._replace(detectability=0.1) for box in approach(frames, 5, centre=15)]
    second = [at(frame, 5, track=2, detectability=0.9) for frame in frames]
    x = [box._replace(score=0.5) for box in [*only(first, range(20, 40)), *second[::2]]]
    x.append(at(0, 90, score=0.2))
    y = [*x, *(at(frame, 60, score=1.0) for frame in frames)]
    ignored = at(3, 80, ignore=True)
    return result_of(make_dataset([*first, *second, ignored], x, y), low=0.95, alerts="policy")


@pytest.mark.parametrize("measure", [*OF_SYSTEMS, *OF_CURVES], ids=key_of)
def test_a_measure_says_whether_false_alarms_worsen_it(measure: Measure, alarming: Result):
    if measure.of_curve is None:
        without, with_alarms = (measure.of(alarming, system) for _, system in alarming.sides)
    else:
        curves = (
            detection_curve(alarming.dataset, system.name, alarming.params)
            for _, system in alarming.sides
        )
        without, with_alarms = (measure.of_curve(summarise_curve(curve, 0.1)) for curve in curves)
    if not measure.is_worsened_by_alarms:
        assert with_alarms == without
    elif measure.better == "higher":
        assert with_alarms < without
    else:
        assert with_alarms > without


def test_measures_of_one_hypothesis_rest_on_the_same():
    for measure in MEASURES:
        if measure.inference is not None and measure.inference.repeats:
            tested = measure_of(measure.inference.repeats)
            assert measure.stages == tested.stages
            assert measure.is_worsened_by_alarms == tested.is_worsened_by_alarms


def test_what_displays_choose_among_the_measures_exists():
    chosen = [*QUALITIES, *PAIR_MEASURES, *KINDS]
    assert {quality.key for quality in chosen} | {kind.judged for kind in KINDS if kind.judged} <= {
        measure.key for measure in MEASURES
    }


@pytest.mark.parametrize("measure", OF_RECORDINGS, ids=key_of)
def test_of_one_recording_it_is_that_of_all(measure: Measure, alone: Result):
    (value,) = measure.by_recording(alone, alone.y)
    if measure.only_if and not measure.only_if.holds(alone):  # nothing is known of the driver
        assert pd.isna(value)
        return
    assert value == pytest.approx(measure.of(alone, alone.y), nan_ok=True)


@pytest.mark.parametrize("measure", OF_RECORDINGS, ids=key_of)
def test_a_recording_without_frames_has_no_value_or_none_of_anything(measure: Measure):
    result = result_of(make_dataset(places=[Place(range(2)), Place([])]))
    value = measure.by_recording(result, result.x)[1]
    assert pd.isna(value) if measure.empty or measure.empty_by_recording else value == 0


def test_what_is_undefined_without_frames_says_so():
    result = result_of(make_dataset(n_frames=0))
    undefined = {
        measure.key
        for measure in OF_SYSTEMS
        if measure.meaning and np.isnan(measure.of(result, result.x))
    }
    assert undefined == {measure.key for measure in OF_SYSTEMS if measure.empty}


@pytest.mark.parametrize("key", EVIDENCE_KEYS)
def test_evidence_is_named_and_written_like_the_measure(key: str, alone: Result):
    label = evidence_label(key, alone, "blocks")
    assert label[0].islower()
    assert "{" not in label
    assert format(0.5, evidence_form(key))
    assert measure_of(key).better in ("higher", "lower")
    # a share is written as one everywhere, so that its differences are percentage points
    assert inference_of(key).scale.is_share == evidence_form(key).endswith("%")


def test_the_size_of_a_difference_has_no_sign_and_keeps_its_zero():
    assert size_text(-0.25, "mean_similarity") == size_text(0.25, "mean_similarity") == "0.2500"
    assert size_text(0.00001, "mean_similarity") == "0.0000"
    assert size_text(-0.1, "encounters_detected") == "10.0 pp"


def test_encounters_stand_first_in_the_evidence_and_the_curve_last():
    assert EVIDENCE_KEYS[:2] == ("encounters_detected", "encounters_detected_by_unit")
    assert EVIDENCE_KEYS[-1] == "log_average_miss_rate"

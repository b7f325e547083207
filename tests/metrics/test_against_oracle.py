"""Every figure against the plain-loop reading of the specification in `oracle`."""

from __future__ import annotations

import math

import numpy as np
import oracle
import pytest
from builders import Box
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import Scene, draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import salient_detection
from nvcore.settings.params import Params

PARAMS = st.builds(
    Params,
    alpha=st.sampled_from([0.0, 0.3, 0.9, 1.0]),
    distance=st.sampled_from(["lateral", "ground"]),
    edge_weight=st.sampled_from([None, 0.0, 0.4, 1.0]),
    pairing=st.sampled_from(["nearest", "matched"]),
    proximity=st.sampled_from(["height", "horizon", "distance", "none"]),
    midpoint=st.sampled_from([None, 20.0]),
    spread=st.sampled_from([None, 5.0]),
    threshold_x=st.sampled_from([None, 0.5]),
    threshold_y=st.sampled_from([None, 0.3]),
    match=st.sampled_from(["iou", "lateral"]),
    iou=st.sampled_from([0.1, 0.5, 0.75]),
    lateral_tolerance=st.sampled_from([0.0, 0.02, 0.1]),
    match_class=st.sampled_from(["any", "same"]),
    coverage=st.sampled_from([0.0, 0.5, 0.8]),
    lag_s=st.sampled_from([0.0, 0.1, 0.5]),
    gap_s=st.sampled_from([0.0, 0.2, 0.5]),
    low=st.sampled_from([0.7, 0.9, 0.97]),
    window=st.sampled_from([0.0, 0.4, 1.0]),
    tolerance=st.sampled_from([0.0, 0.05, 0.2]),
    saliency_aggregate=st.sampled_from(["max", "sum"]),
    saliency_scope=st.sampled_from(["recording", "encounter"]),
    saliency_of=st.sampled_from(["most_salient", "each"]),
    saliency_weight=st.sampled_from(["time", "risk"]),
    recency_unit=st.sampled_from(["share", "seconds"]),
    recency_midpoint_s=st.sampled_from([0.0, 0.5, 7.5]),
    recency_spread_s=st.sampled_from([0.2, 1.5]),
)
SEEDS = st.integers(0, 2**32 - 1)
MOSTLY_FALSE = st.sampled_from([False] * 9 + [True])
SCENES = st.builds(draw_scene, SEEDS, is_grid=st.booleans(), is_crowded=MOSTLY_FALSE)
thoroughly = settings(max_examples=40, deadline=None, derandomize=True)


def each_system(
    scene: Scene, result: Result, recording: int
) -> list[tuple[SystemResult, oracle.Trace]]:
    place, params = scene.places[recording], result.params
    truth = scene.by_frame(scene.truth, recording)
    return [
        (system, oracle.score(place, truth, scene.by_frame(boxes, recording), params, threshold))
        for system, boxes, threshold in (
            (result.x, scene.x, params.threshold_x),
            (result.y, scene.y, params.threshold_y),
        )
    ]


def worst_alarms(
    result: Result, system: SystemResult, rows: slice
) -> list[tuple[float, ...] | None]:
    """x, y, w, h of the detection at which D(S, G) stands, of every frame."""
    boxes, worst = result.dataset.system(system.name), []
    for row in range(rows.start, rows.stop):
        at = salient_detection(
            boxes, system.weights.k, system.matches.is_counted, system.nearest,
            result.dataset.frame_columns, row,
            edge_weight=in_use(result.params, "edge_weight", result.dataset.frame_columns),
        )  # fmt: skip
        worst.append(None if at < 0 else (boxes.x[at], boxes.y[at], boxes.w[at], boxes.h[at]))
    return worst


def rows_of(result: Result, recording: int) -> slice:
    first = result.dataset.frame_columns.first
    return slice(int(first[recording]), int(first[recording + 1]))


@thoroughly
@given(SCENES, PARAMS)
def test_distances_similarity_and_counts_of_every_frame_agree(scene: Scene, params: Params) -> None:
    result = compare(scene.dataset(), params)
    for recording in range(len(scene.places)):
        rows = rows_of(result, recording)
        for system, trace in each_system(scene, result, recording):
            assert system.distances.d_miss[rows] == pytest.approx(trace.d_miss, abs=1e-9)
            assert system.distances.d_false[rows] == pytest.approx(trace.d_false, abs=1e-9)
            assert system.similarity[rows] == pytest.approx(trace.similarity, abs=1e-9)
            assert system.n_det[rows].tolist() == trace.n_det
            assert system.matched[rows].tolist() == trace.matched
            alarms = [len(boxes) for boxes in trace.false_alarms]
            assert system.false_alarms[rows].tolist() == alarms
            assert worst_alarms(result, system, rows) == [
                box and box[1:5] for box in trace.worst_alarm
            ]


@thoroughly
@given(SCENES, PARAMS)
def test_saliency_events_agree(scene: Scene, params: Params) -> None:
    result = compare(scene.dataset(), params)
    saliencies: dict[int, list[float]] = {id(result.x): [], id(result.y): []}
    for recording in range(len(scene.places)):
        start = rows_of(result, recording).start
        for system, trace in each_system(scene, result, recording):
            events = system.events[system.events["recording"] == recording]
            events = events.assign(
                first_row=events["first_row"] - start, last_row=events["last_row"] - start
            )
            names = ["track", "first_row", "last_row", "duration_s", "saliency_s"]
            expected = np.array(trace.events, float).reshape(-1, len(names))
            assert events[names].to_numpy(float) == pytest.approx(expected)
            values = expected[:, -1].tolist()
            is_max = params.saliency_aggregate == "max"
            saliencies[id(system)].append(max(values, default=0.0) if is_max else sum(values))
    for system in (result.x, result.y):
        values = saliencies[id(system)]
        assert system.saliency_s == pytest.approx(sum(values) / len(values))


@thoroughly
@given(SCENES, PARAMS)
def test_low_intervals_and_the_moving_mean_agree(scene: Scene, params: Params) -> None:
    result = compare(scene.dataset(), params)
    for recording, place in enumerate(scene.places):
        rows = rows_of(result, recording)
        for system, trace in each_system(scene, result, recording):
            values = system.similarity[rows].tolist()  # a value beside the limit is decided once
            assert values == pytest.approx(trace.similarity)
            expected = oracle.intervals(place, values, params.low)
            intervals = system.intervals[system.intervals["recording"] == recording]
            intervals = intervals.assign(
                **{
                    name: intervals[name] - rows.start
                    for name in ("first_row", "last_row", "worst_row")
                }
            )
            assert intervals[oracle.INTERVAL].to_numpy(float) == pytest.approx(
                np.array(expected, float).reshape(-1, len(oracle.INTERVAL)), abs=1e-9
            )
            means = oracle.moving_mean(place, values, params.window)
            assert system.similarity_window[rows] == pytest.approx(means)
            step_s = np.array(oracle.steps(place))
            lost = (1 - np.array(values)) * step_s
            worst = system.worst_window_of_recordings[recording]
            near = oracle.within(place, worst.row - rows.start, params.window)
            assert worst.mean == pytest.approx(min(means))
            assert worst.lost_s == pytest.approx(lost[near].sum())


@thoroughly
@given(SCENES, PARAMS)
def test_encounters_and_venn_counts_agree(scene: Scene, params: Params) -> None:
    result = compare(scene.dataset(), params)
    kinds = []
    for recording, place in enumerate(scene.places):
        truth = scene.by_frame(scene.truth, recording)
        judged = [
            (system, oracle.encounters(place, truth, trace, params))
            for system, trace in each_system(scene, result, recording)
        ]
        is_here = result.encounters.recording == recording
        for system, expected in judged:
            assert result.encounters.track[is_here].tolist() == list(expected)
            table = system.encounters[is_here].to_dict("records")
            for row, figures in zip(table, expected.values(), strict=True):
                assert {name: pytest.approx(row[name], nan_ok=True, abs=1e-9) for name in row
                        if name != "miss_class"} == {
                    name: value for name, value in figures.items() if name != "miss_class"
                }  # fmt: skip
                assert row["miss_class"] == figures["miss_class"]
        for in_x, in_y in zip(judged[0][1].values(), judged[1][1].values(), strict=True):
            hits = (in_x["is_detected"], in_y["is_detected"])
            kind = {(True, True): "both", (True, False): "x_only", (False, True): "y_only"}
            kinds.append("distant" if in_x["miss_class"] is None else kind.get(hits, "neither"))
    assert result.category.tolist() == kinds
    assert result.venn.counts() == {
        name: kinds.count(name) for name in ("both", "x_only", "y_only", "neither", "distant")
    }


@thoroughly
@given(SCENES, PARAMS)
def test_severity_and_losses_agree(scene: Scene, params: Params) -> None:
    result = compare(scene.dataset(), params)
    lost_s: dict[int, float] = {id(result.x): 0.0, id(result.y): 0.0}
    for recording, place in enumerate(scene.places):
        truth = scene.by_frame(scene.truth, recording)
        rows, is_here = rows_of(result, recording), result.encounters.recording == recording
        for system, trace in each_system(scene, result, recording):
            expected = [
                oracle.severity(place, truth, trace, track, params)
                for track in result.encounters.track[is_here].tolist()
            ]
            values = system.failures[is_here][["severity_s", "peak_cost"]].to_numpy()
            assert values == pytest.approx(np.array(expected).reshape(-1, 2), abs=1e-9)
            both = system.loss_miss + system.loss_false
            assert both[rows] == pytest.approx(1 - np.array(trace.similarity), abs=1e-9)
            steps = zip(trace.similarity, oracle.steps(place), strict=True)
            lost_s[id(system)] += sum((1 - value) * step for value, step in steps)
    for system in (result.x, result.y):
        per_minute = lost_s[id(system)] / (result.duration_s / 60)
        assert system.lost_s_per_min == pytest.approx(per_minute)


@thoroughly
@given(SEEDS, MOSTLY_FALSE)
def test_truth_without_tracks_is_linked_as_specified(seed: int, is_crowded: bool) -> None:
    scene = draw_scene(seed, is_crowded=is_crowded, has_tracks=False)
    result = compare(scene.dataset())
    for recording in range(len(scene.places)):
        frames = scene.by_frame([b for b in scene.truth if not b.ignore], recording)
        expected = [number for numbers in oracle.link(frames) for number in numbers]
        truth = result.dataset.truth
        here = result.dataset.frame_columns.recording[truth.frame_index] == recording
        track = result.tracks.track[here & ~truth.ignore]
        assert (track - track.min(initial=2**62)).tolist() == expected
        assert (recording in result.tracks.linked_recordings) == bool(expected)


@thoroughly
@given(SEEDS, MOSTLY_FALSE, st.sampled_from([None, 0.3, 0.6]), st.sampled_from(["iou", "lateral"]))
def test_false_alert_episodes_agree(
    seed: int, is_crowded: bool, threshold: float | None, match: str
) -> None:
    scene = draw_scene(seed, is_crowded=is_crowded)
    result = compare(
        scene.dataset(), Params(threshold_x=threshold, threshold_y=threshold, match=match)
    )
    for recording, place in enumerate(scene.places):
        start, step = rows_of(result, recording).start, oracle.steps(place)
        for system, trace in each_system(scene, result, recording):
            linked = oracle.link(trace.false_alarms)
            expected = []
            for number in sorted({n for numbers in linked for n in numbers}):
                seen = [p for p, numbers in enumerate(linked) if number in numbers]
                duration = sum(step[seen[0] : seen[-1] + 1])
                n_boxes = sum(numbers.count(number) for numbers in linked)
                expected.append((seen[0] + start, seen[-1] + start, n_boxes, duration))
            table = system.episodes[system.episodes["recording"] == recording]
            episodes = table[["first_row", "last_row", "n_boxes", "duration_s"]].to_numpy()
            assert episodes == pytest.approx(np.array(expected).reshape(-1, 4))


@thoroughly
@given(SCENES, st.sampled_from([None, 0.4]), st.sampled_from([0.2, 0.5]))
def test_fused_systems_agree_with_fusing_by_hand(
    scene: Scene, threshold: float | None, iou: float
) -> None:
    params = Params(threshold_x=threshold, threshold_y=threshold, iou=iou)
    fusion = compare(scene.dataset(), params).fusion
    either: list[Box] = []
    both: list[Box] = []
    for recording in range(len(scene.places)):
        for in_x, in_y in zip(
            scene.by_frame(scene.x, recording), scene.by_frame(scene.y, recording), strict=True
        ):
            above = [
                [b for b in boxes if threshold is None or not b.score < threshold]
                for boxes in (in_x, in_y)
            ]
            parts = oracle.fuse(above[0], above[1], iou)
            either += parts[0]
            both += parts[1]
    by_hand = compare(Scene(scene.places, scene.truth, either, both).dataset(), Params(iou=iou))
    for fused, plain in ((fusion.x, by_hand.x), (fusion.y, by_hand.y)):
        assert fused.n_det.tolist() == plain.n_det.tolist()
        assert fused.similarity.tolist() == plain.similarity.tolist()
        assert fused.events.equals(plain.events)
        assert fused.encounters.equals(plain.encounters)
        assert fused.episodes.equals(plain.episodes)


def test_the_oracle_itself_reproduces_figure_7_of_the_paper() -> None:
    place, params = oracle.Place([0]), Params(proximity="none")
    G = [Box(0, 11, 40, 2, 50, track=1), Box(0, 16, 40, 2, 50, track=2)]
    S = [Box(0, 9, 40, 2, 50)]
    of_truth = oracle.terms(G, S, [None, None], place, params)
    assert oracle.maximin(G, of_truth, place, params) == (7, G[1])
    assert oracle.terms(S, G, [None], place, params) == [2]
    assert not math.isnan(oracle.weight(S[0], place, Params()))

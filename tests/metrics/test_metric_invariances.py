"""What must hold for any data: bounds, mirroring, reordering, scaling, monotony."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Box, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import Scene, draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.scoring import SystemResult
from nvcore.settings.params import Params

SEEDS = st.integers(0, 2**32 - 1)
ALPHA = st.floats(0, 1)
CENTRES = st.lists(st.floats(0, 100), max_size=5)
FRAMES = st.lists(st.tuples(CENTRES, CENTRES), min_size=1, max_size=8)
Sets = list[tuple[list[float], list[float]]]
PLAIN = Params(proximity="none")
often = settings(max_examples=15, deadline=None, derandomize=True)


def score_sets(sets: Sets, **params: object) -> SystemResult:
    """One frame for every pair of pedestrians G and detections S, 100 px wide, k = 1."""
    truth = [at(f, c, track=i) for f, (G, _) in enumerate(sets) for i, c in enumerate(G)]
    x = [at(f, c) for f, (_, S) in enumerate(sets) for c in S]
    return result_of(make_dataset(truth, x, n_frames=len(sets)), **params).x


@often
@given(
    SEEDS, ALPHA, st.floats(0, 1), st.sampled_from(["lateral", "ground"]),
    st.sampled_from(["height", "distance", "horizon", "none"]),
)  # fmt: skip
def test_similarity_lies_between_0_and_1(
    seed: int, alpha: float, edge_weight: float, distance: str, proximity: str
) -> None:
    params = Params(alpha=alpha, edge_weight=edge_weight, distance=distance, proximity=proximity)  # type: ignore[arg-type]
    result = compare(draw_scene(seed).dataset(), params)
    for system in (result.x, result.y):
        assert (system.similarity >= 0).all()
        assert (system.similarity <= 1).all()


@often
@given(FRAMES, ALPHA)
def test_similarity_has_the_lower_bound_of_the_specification(sets: Sets, alpha: float) -> None:
    similarity = score_sets(sets, alpha=alpha).similarity
    assert similarity.min() >= 1 - max(alpha, 1 - alpha, 2 / 3) - 1e-12


@often
@given(ALPHA)
def test_each_lower_bound_is_reached(alpha: float) -> None:
    missed, false, thirds = ([50.0], []), ([], [50.0]), ([100 / 3], [200 / 3])
    similarity = score_sets([missed, false, thirds], alpha=alpha).similarity
    assert similarity == pytest.approx([1 - alpha, alpha, 1 / 3])
    assert similarity.min() == pytest.approx(1 - max(alpha, 1 - alpha, 2 / 3))


@often
@given(FRAMES, st.floats(0, 100))
def test_another_pedestrian_never_lowers_the_effect_of_misses(sets: Sets, more: float) -> None:
    before = score_sets(sets).distances.d_miss
    after = score_sets([([*G, more], S) for G, S in sets]).distances.d_miss
    assert (after >= before).all()


@often
@given(FRAMES, st.floats(0, 100), st.sampled_from([0.0, 0.5, 1.0]))
def test_another_detection_never_raises_the_effect_of_misses(
    sets: Sets, more: float, edge_weight: float
) -> None:
    before = score_sets(sets, edge_weight=edge_weight).distances.d_miss
    with_more = [(G, [*S, more]) for G, S in sets]
    assert (score_sets(with_more, edge_weight=edge_weight).distances.d_miss <= before).all()


@often
@given(FRAMES)
def test_exchanging_the_two_sets_exchanges_the_two_distances(sets: Sets) -> None:
    given_sets = score_sets(sets).distances
    swapped = score_sets([(S, G) for G, S in sets]).distances
    assert given_sets.d_miss.tolist() == swapped.d_false.tolist()
    assert given_sets.d_false.tolist() == swapped.d_miss.tolist()


@often
@given(FRAMES)
def test_more_edge_weight_never_lowers_a_distance(sets: Sets) -> None:
    town, country = (score_sets(sets, edge_weight=rho).distances for rho in (0.0, 1.0))
    assert (country.d_miss >= town.d_miss).all()
    assert (country.d_false >= town.d_false).all()


def transformed(scene: Scene, move: object) -> Scene:
    truth, x, y = ([move(b) for b in s] for s in (scene.truth, scene.x, scene.y))  # type: ignore[operator]
    return Scene(scene.places, truth, x, y)


def assert_same_verdict(result: Result, other: Result, *, factor: float = 1.0) -> None:
    for a, b in ((result.x, other.x), (result.y, other.y)):
        assert b.similarity == pytest.approx(a.similarity, abs=1e-9)
        assert b.distances.d_miss == pytest.approx(factor * a.distances.d_miss, abs=1e-7)
        assert b.distances.d_false == pytest.approx(factor * a.distances.d_false, abs=1e-7)
        assert b.encounters["miss_class"].tolist() == a.encounters["miss_class"].tolist()
        assert b.n_det.tolist() == a.n_det.tolist()
    assert result.venn == other.venn


@often
@given(SEEDS)
def test_mirroring_changes_nothing(seed: int) -> None:
    scene = draw_scene(seed)

    def mirror(box: Box) -> Box:
        return box._replace(x=scene.places[box.recording].width - box.x - box.w)

    plain, mirrored = compare(scene.dataset()), compare(transformed(scene, mirror).dataset())
    assert_same_verdict(plain, mirrored)
    assert mirrored.encounters.lateral_position == pytest.approx(-plain.encounters.lateral_position)
    assert mirrored.encounters.lateral_offset == pytest.approx(plain.encounters.lateral_offset)


@often
@given(SEEDS)
def test_reordering_boxes_changes_nothing(seed: int) -> None:
    scene = draw_scene(seed)
    rng = np.random.default_rng(seed)
    # equal scores go by file order, so every detection has its own
    for name in ("x", "y"):
        boxes = getattr(scene, name)
        ranks = rng.permutation(len(boxes)).tolist()
        setattr(scene, name, [b._replace(score=s) for b, s in zip(boxes, ranks, strict=True)])
    shuffled = Scene(scene.places, *(
        [boxes[i] for i in rng.permutation(len(boxes))] for boxes in (scene.truth, scene.x, scene.y)
    ))  # fmt: skip
    plain, reordered = compare(scene.dataset()), compare(shuffled.dataset())
    assert_same_verdict(plain, reordered)
    assert reordered.x.events["track"].tolist() == plain.x.events["track"].tolist()


@often
@given(SEEDS, st.sampled_from([0.25, 0.5, 2.0, 3.0]))
def test_scaling_picture_boxes_and_sigmoid_changes_nothing(seed: int, factor: float) -> None:
    scene = draw_scene(seed)

    def scale(box: Box) -> Box:
        return box._replace(**{name: factor * getattr(box, name) for name in "xywh"})

    scaled = transformed(scene, scale)
    scaled.places = [
        p._replace(width=factor * p.width, height=factor * p.height, horizon=factor * p.horizon)
        for p in scene.places
    ]
    assert_same_verdict(compare(scene.dataset()), compare(scaled.dataset()), factor=factor)
    params = Params(midpoint=20, spread=4, edge_weight=0.3, distance="ground", proximity="horizon")
    larger = replace(params, midpoint=20 * factor, spread=4 * factor)
    assert_same_verdict(
        compare(scene.dataset(), params), compare(scaled.dataset(), larger), factor=factor
    )


@often
@given(SEEDS)
def test_the_truth_as_a_system_is_perfect(seed: int) -> None:
    scene = draw_scene(seed)
    scene.x = list(scene.truth)
    x = compare(scene.dataset(), PLAIN).x
    assert (x.similarity == 1).all()
    assert x.events.empty
    assert x.encounters["is_detected"].all()


@often
@given(SEEDS, st.integers(0, 9))
def test_counts_add_up(seed: int, tenths: int) -> None:
    result = compare(draw_scene(seed).dataset(), Params(threshold_x=tenths / 10))
    pedestrians = int(result.n_truth.sum())
    boxes = result.boxes
    assert boxes.both + boxes.x_only + boxes.y_only + boxes.neither == pedestrians
    assert boxes.both + boxes.x_only == result.x.matched.sum()
    assert boxes.both + boxes.y_only == result.y.matched.sum()
    assert sum(result.venn.counts().values()) == len(result.encounters)
    for system in (result.x, result.y):
        assert (system.n_det == system.matched + system.false_alarms).all()
        assert system.episodes["n_boxes"].sum() == system.false_alarms.sum()
        assert system.false_alarm_summary.count == system.false_alarms.sum()


@often
@given(SEEDS)
def test_frames_without_boxes_anywhere_leave_the_others_as_they_are(seed: int) -> None:
    scene = draw_scene(seed)
    more = [
        p._replace(frames=[*p.frames, *range(p.frames[-1] + 500, p.frames[-1] + 503)])
        for p in scene.places
    ]
    plain, longer = scene.dataset(), Scene(more, scene.truth, scene.x, scene.y).dataset()
    key = ["recording", "frame"]
    is_old = longer.frames[key].apply(tuple, axis=1).isin(plain.frames[key].apply(tuple, axis=1))
    similarity = compare(longer, PLAIN).x.similarity
    assert similarity[is_old].tolist() == compare(plain, PLAIN).x.similarity.tolist()
    assert (similarity[~is_old] == 1).all()

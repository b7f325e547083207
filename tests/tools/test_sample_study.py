"""The simulated study: an observer after published parts, and answers by the paper's design."""

from __future__ import annotations

from io import BytesIO

import cv2
import numpy as np
import pandas as pd
import pytest
from places import ROOT

from tools.sample.study.observer import (
    CRITERION,
    PERIODS_S,
    adapted_luminance,
    eccentricity_deg,
    luminance,
    picking,
    seeing,
    sensitivity,
    visibility,
)
from tools.sample.study.scenes import N_PICTURES, SIZE, all_scenes, boxes_table
from tools.sample.study.trials import (
    ABSENT,
    N_SUBJECTS,
    PAIRS_S,
    simulated_trials,
    subjects,
    trials_text,
    truth_rows,
)
from tools.sample.study.writing import table_text

FOLDER = ROOT / "sample_data"
MIDDLE = (200.0, 150.0)


@pytest.fixture(scope="module")
def boxes() -> pd.DataFrame:
    return pd.read_csv(FOLDER / "study" / "boxes.csv")


@pytest.fixture(scope="module")
def truth() -> pd.DataFrame:
    return pd.read_csv(FOLDER / "trials_simulated_truth.csv")


@pytest.fixture(scope="module")
def trials(truth: pd.DataFrame, boxes: pd.DataFrame) -> pd.DataFrame:
    return simulated_trials(truth, boxes)


def drawn(box: tuple[float, float, float, float] | None, grey: int = 190) -> np.ndarray:
    """A grey picture, with a lighter rectangle for a pedestrian."""
    picture = np.full((300, 400, 3), 90, dtype=np.uint8)
    if box is not None:
        x, y, w, h = (int(value) for value in box)
        picture[y : y + h, x : x + w] = grey
    return picture


def stands_out(box: tuple[float, float, float, float], grey: int = 190) -> np.ndarray:
    return visibility(drawn(box, grey), drawn(None), box, MIDDLE)


def test_contrast_sensitivity_is_barten_s() -> None:
    # 100 cd/m2, a field of 10 degrees: the formula's value by hand at 4 cycles per degree.
    u, light, side = 4.0, 100.0, 10.0
    optics = np.exp(-0.0016 * u**2 * (1 + 100 / light) ** 0.08)
    under = (1 + 144 / side**2 + 0.64 * u**2) * (63 / light**0.83 + 1 / (1 - np.exp(-0.02 * u**2)))
    value = float(sensitivity(np.array(u), np.array(light), side))
    assert value == pytest.approx(5200 * optics / under**0.5)
    assert 300 < value < 1000  # the usual height of the curve's peak by daylight
    frequencies = np.geomspace(0.2, 40, 60)
    peak = frequencies[np.argmax(sensitivity(frequencies, np.array(light), side))]
    assert 1.5 < peak < 6


def test_less_light_and_a_smaller_target_are_seen_worse() -> None:
    u = np.array(3.0)
    usual = sensitivity(u, np.array(10.0), 4.0)
    assert sensitivity(u, np.array(0.5), 4.0) < usual
    assert sensitivity(u, np.array(10.0), 1.0) < usual


def test_the_eye_follows_the_light_down_fast_and_then_slowly() -> None:
    followed = [adapted_luminance(time_s) for time_s in (0.0, *PERIODS_S)]
    assert followed[0] == pytest.approx(255.0)
    assert np.diff(followed).max() < 0
    assert np.diff(np.log(followed))[1] < np.diff(np.log(followed))[-1]
    # In the end it is the curve by which tunnels are lighted (CIE 88:2004).
    assert adapted_luminance(20.0) == pytest.approx(255 * 21.9**-1.4, rel=1e-3)


def test_the_screen_has_the_luminance_of_its_curve() -> None:
    grey = np.array([[[0, 0, 0], [188, 188, 188], [255, 255, 255]]], dtype=np.uint8)
    black, half, white = luminance(grey)[0]
    assert black == pytest.approx(0.13)
    assert half == pytest.approx(0.13 + 110 * 0.503, rel=0.01)
    assert white == pytest.approx(110.13)


def test_a_pedestrian_stands_out_more_with_time_contrast_size_and_near_the_fixation() -> None:
    usual = stands_out((190.0, 120.0, 20.0, 60.0))
    assert (np.diff(usual) >= 0).all()
    assert usual[-1] > 2 * usual[0]
    assert (stands_out((190.0, 120.0, 20.0, 60.0), grey=110) < usual).all()
    assert (stands_out((197.0, 140.0, 7.0, 20.0)) < usual).all()
    assert (stands_out((20.0, 120.0, 20.0, 60.0)) < usual).all()


def test_who_does_not_differ_from_the_street_is_not_seen() -> None:
    box = (190.0, 120.0, 20.0, 60.0)
    nothing = stands_out(box, grey=90)
    assert nothing.tolist() == [0.0] * len(PERIODS_S)
    assert seeing(nothing).tolist() == [0.0] * len(PERIODS_S)


def test_a_busy_street_masks() -> None:
    box = (190.0, 120.0, 20.0, 60.0)
    stripes = np.zeros((300, 400, 3), dtype=np.uint8)
    stripes[:, (np.arange(400) // 4) % 2 == 0] = 40
    calm = stands_out(box)
    busy = visibility(drawn(box) + stripes, drawn(None) + stripes, box, MIDDLE)
    assert (busy < calm).all()


def test_the_chance_of_seeing_is_two_thirds_at_the_criterion() -> None:
    assert seeing(np.array([CRITERION])) == pytest.approx([1 - np.exp(-1)])
    assert seeing(np.array([CRITERION / 2]), gain=2.0) == pytest.approx([1 - np.exp(-1)])


def test_the_small_and_the_far_off_are_picked_out_less_often() -> None:
    near, small = (190.0, 120.0, 20.0, 60.0), (197.0, 145.0, 3.0, 10.0)
    aside = (0.0, 120.0, 20.0, 60.0)
    assert eccentricity_deg(near, MIDDLE) == 0.0
    assert eccentricity_deg(aside, MIDDLE) == pytest.approx(190 / 40)
    assert picking(small, MIDDLE) < picking(aside, MIDDLE) < picking(near, MIDDLE) < 1


def test_the_committed_trials_are_those_of_the_committed_truth(trials: pd.DataFrame) -> None:
    assert (FOLDER / "trials_simulated.csv").read_text("utf-8") == trials_text(trials)


def test_the_committed_boxes_are_those_of_the_scenes() -> None:
    committed = (FOLDER / "study" / "boxes.csv").read_text("utf-8")
    assert committed == table_text(boxes_table(list(all_scenes())))


def test_a_committed_picture_and_its_truth_are_made_again(truth: pd.DataFrame) -> None:
    scene = next(all_scenes())
    shown, street = scene.pictures()
    committed = cv2.imread(str(FOLDER / "study" / scene.image))[..., ::-1]
    assert shown.shape == committed.shape == (SIZE[1], SIZE[0], 3)
    assert np.abs(shown.astype(float) - committed).mean() < 3  # JPEG
    made = truth_rows(scene.image, scene.box(), (shown, street))
    rows = truth[truth["image"] == scene.image]
    assert made["visibility"].to_numpy() == pytest.approx(rows["visibility"], rel=0.01)
    assert made["probability"].to_numpy() == pytest.approx(rows["probability"], abs=0.01)


def test_every_picture_is_there_with_one_pedestrian_inside(boxes: pd.DataFrame) -> None:
    names = sorted(path.name for path in (FOLDER / "study").glob("*.jpg"))
    assert names == sorted(boxes["image"])
    assert len(names) == N_PICTURES
    assert (boxes["pedestrian"] == 1).all()
    assert (boxes["x"] + boxes["w"] < SIZE[0]).all()
    assert (boxes["y"] + boxes["h"] < SIZE[1]).all()


def test_the_pedestrians_are_spread_widely(boxes: pd.DataFrame) -> None:
    assert boxes["h"].max() > 5 * boxes["h"].min()
    away = (boxes["x"] + boxes["w"] / 2 - SIZE[0] / 2).abs()
    assert away.min() < 30
    assert away.max() > 350


def test_every_subject_has_every_picture_at_every_time_once(trials: pd.DataFrame) -> None:
    assert len(trials) == N_SUBJECTS * N_PICTURES * len(PERIODS_S)
    times = trials.groupby(["subject", "image"])["adaptation_asked_s"]
    assert times.nunique().eq(len(PERIODS_S)).all()
    assert set(trials["adaptation_asked_s"] + 0.5) == set(PERIODS_S)


def test_a_run_has_two_pictures_after_one_change_of_light(trials: pd.DataFrame) -> None:
    runs = trials.groupby(["subject", "run"])
    assert runs.size().eq(2).all()
    assert runs["image"].nunique().eq(2).all()
    pairs = set(runs["adaptation_asked_s"].agg(tuple))
    assert pairs == set(PAIRS_S)
    assert trials[trials["subject"] == "S01"]["order"].tolist() == list(range(1, 307))


def test_simulated_trials_say_so_everywhere(trials: pd.DataFrame) -> None:
    assert (trials["device"] == "simulated").all()
    readme = (FOLDER / "README.md").read_text("utf-8")
    assert "no person was asked" in readme


def test_a_touch_is_inside_the_picture_or_there_is_none(trials: pd.DataFrame) -> None:
    is_none = trials["not_seen"] == 1
    assert trials["touch_x"].isna().eq(is_none).all()
    assert trials["touch_x"].dropna().between(0, SIZE[0] - 1).all()
    assert trials["touch_y"].dropna().between(0, SIZE[1] - 1).all()
    assert trials["response_s"].gt(0.4).all()


def test_the_truth_is_the_share_of_subjects_who_see_and_rises(truth: pd.DataFrame) -> None:
    chances = [
        subject.chance(truth["visibility"].to_numpy(), truth["picking"].to_numpy())
        for subject in subjects()
    ]
    assert np.mean(chances, axis=0) == pytest.approx(truth["probability"], abs=6e-5)
    means = truth.groupby("period_s")["probability"].mean()
    assert means.loc[0.5] < 0.25
    assert means.loc[4.5] > 2 * means.loc[0.5]
    assert means.loc[7.5] < 0.9
    assert means.diff().dropna().gt(-0.01).all()


def test_trials_agree_with_the_truth(
    trials: pd.DataFrame, truth: pd.DataFrame, boxes: pd.DataFrame
) -> None:
    known = trials.merge(boxes, on=["image", "pedestrian"])
    across = (known["touch_x"] - known["x"] - known["w"] / 2).abs()
    down = (known["touch_y"] - known["y"] - known["h"] / 2).abs()
    known["is_near"] = (across < 60) & (down < 60)
    known["period_s"] = known["adaptation_asked_s"] + 0.5
    shares = known.groupby(["image", "period_s"])["is_near"].mean()
    expected = truth.set_index(["image", "period_s"])["probability"].loc[shares.index]
    assert np.corrcoef(shares, expected)[0, 1] > 0.95
    assert shares.mean() == pytest.approx(expected.mean(), abs=0.03)


def test_one_subject_often_does_not_look() -> None:
    lapses = {subject.name: subject.lapse for subject in subjects()}
    assert max(lapses, key=lambda name: lapses[name]) == f"S{ABSENT:02d}"
    assert sorted(lapses.values())[-2] < 0.06


def test_csv_texts_are_read_back(trials: pd.DataFrame) -> None:
    again = pd.read_csv(BytesIO(trials_text(trials).encode()))
    assert again["touch_x"].equals(trials["touch_x"])

"""Each feature on pictures whose answer can be counted by hand, and against other programs."""

from __future__ import annotations

import re

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT
from scipy.stats import wasserstein_distance

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.features import FEATURE_KEYS, FEATURES, FeatureSettings, features_of

BOX = np.array([[40.0, 20.0, 20.0, 40.0]])
"""20 x 40 px; with twice its sides: x 30..70, y 0..80."""


def grey(height: int = 100, width: int = 100, value: int = 0) -> np.ndarray:
    return np.full((height, width), value, np.uint8)


def coloured(inside: tuple[int, int, int], outside: tuple[int, int, int]) -> np.ndarray:
    picture = np.full((100, 100, 3), outside, np.uint8)
    picture[20:60, 40:60] = inside
    return picture


def of(picture: np.ndarray, boxes: np.ndarray = BOX, **options: object) -> dict[str, float]:
    """Features of the first box, by their keys."""
    values = features_of(picture, boxes, **options)[0]  # type: ignore[arg-type]
    return dict(zip(FEATURE_KEYS, values.tolist(), strict=True))


def noise(*, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    small = rng.integers(0, 256, (30, 40, 3), dtype=np.uint8)
    return cv2.resize(small, (160, 120), interpolation=cv2.INTER_LINEAR)


def test_the_eight_features_stand_in_the_order_of_the_tables():
    assert (
        *("width_px", "height_px", "luminance_sd", "luminance_contrast", "lab_distance"),
        *("edge_contrast", "colour_emd", "fixation_distance_px"),
    ) == FEATURE_KEYS


def test_width_and_height_are_those_of_the_part_in_the_picture():
    values = of(grey(), np.array([[-5.0, 90.5, 20.0, 40.0]]))
    assert (values["width_px"], values["height_px"]) == (15.0, 9.5)


def test_luminance_sd_divides_by_the_number_of_pixels():
    picture = grey()
    picture[20:40, 40:60] = 60  # half of the pedestrian 60, half 0: mean 30, each 30 away
    assert of(picture)["luminance_sd"] == 30.0


def test_luminance_contrast_is_the_difference_of_the_means():
    picture = grey(value=10)
    picture[20:60, 40:60] = 50
    picture[:, :40] = 40  # 10 of the 20 columns beside the box: 800 of 2400 pixels of the surround
    mean_around = (800 * 40 + 1600 * 10) / 2400
    assert of(picture)["luminance_contrast"] == pytest.approx(50 - mean_around)


def test_luminance_is_that_of_bt_601():
    values = of(coloured((255, 0, 0), (0, 0, 0)))
    assert values["luminance_contrast"] == 76  # 0.299 * 255 = 76.2
    assert of(coloured((0, 0, 255), (0, 0, 0)))["luminance_contrast"] == 29
    assert of(coloured((0, 0, 0), (0, 255, 0)))["luminance_contrast"] == 150


@pytest.mark.parametrize(
    ("colour", "lab"),
    [
        ((255, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 255, 0), (87.73, -86.18, 83.18)),
        ((0, 0, 255), (32.30, 79.19, -107.86)),
    ],
)
def test_lab_distance_from_black_is_the_length_of_the_colour(
    colour: tuple[int, int, int], lab: tuple[float, float, float]
):
    """L*a*b* of the sRGB primaries as published (www.brucelindbloom.com, D65)."""
    distance = of(coloured(colour, (0, 0, 0)))["lab_distance"]
    assert distance == pytest.approx(np.linalg.norm(lab), abs=0.03)


def exact_lab(picture: np.ndarray) -> np.ndarray:
    """L*a*b* of sRGB pixels by the formulas of CIE 15, without tables."""
    share = picture / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
         [0.0193339, 0.1191920, 0.9503041]]
    )  # fmt: skip
    white = linear @ to_xyz.T / to_xyz.sum(axis=1)
    x, y, z = np.moveaxis(
        np.where(white > 216 / 24389, np.cbrt(white), (24389 / 27 * white + 16) / 116), -1, 0
    )
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


@pytest.mark.parametrize("divisor", [1, 8])
def test_lab_distance_is_that_of_the_formulas(divisor: int):
    picture = noise() // divisor
    lab = exact_lab(picture)
    boxes = np.array([[30.0, 20, 30, 60], [100, 40, 20, 30]])
    for box, values in zip(boxes.astype(int), features_of(picture, boxes), strict=True):
        inside, around = masks(box)
        apart = lab[inside].mean(axis=0) - lab[around].mean(axis=0)
        assert values[4] == pytest.approx(np.linalg.norm(apart), abs=0.005)


def masks(box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of a box, and of the ring of twice its sides, in the picture of `noise`."""
    x, y, w, h = box
    inside, around = np.zeros((2, 120, 160), bool)
    inside[y : y + h, x : x + w] = True
    around[max(0, y - h // 2) : y + h + h // 2, max(0, x - w // 2) : x + w + w // 2] = True
    return inside, around & ~inside


def test_edge_contrast_of_a_step_that_goes_through_the_pedestrian():
    picture = grey()
    picture[:, 50:] = 10
    # a step of 10: the two columns at it have a gradient of 4 * 10, in 40 of 80 rows the box's
    inside, around = 40 * 2 * 40 / 800, 40 * 2 * 40 / 2400
    assert of(picture)["edge_contrast"] == pytest.approx(inside - around)


def test_edge_contrast_is_that_of_opencv_s_sobel():
    picture = noise()
    luminance = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    across, along = (
        cv2.Sobel(luminance, cv2.CV_64F, dx, 1 - dx, borderType=cv2.BORDER_REPLICATE)
        for dx in (1, 0)
    )
    strength = np.hypot(across, along)
    for box in ([30, 20, 30, 60], [0, 0, 40, 80], [120, 60, 40, 60]):
        inside, around = masks(np.array(box))
        expected = abs(strength[inside].mean() - strength[around].mean())
        value = of(picture, np.array([box], float))["edge_contrast"]
        assert value == pytest.approx(expected, abs=1e-4)


def test_edges_of_the_picture_are_none():
    assert of(grey(value=200), np.array([[0.0, 0.0, 20.0, 40.0]]))["edge_contrast"] == 0.0


def test_colour_emd_counts_the_bins_that_colours_move():
    # red from bin 15 to bin 3, green from 0 to 2, blue stays: 12 + 2
    assert of(coloured((255, 15, 7), (50, 40, 7)))["colour_emd"] == 14.0


def test_colour_emd_of_half_of_the_pixels_is_half():
    picture = coloured((0, 0, 1), (0, 0, 1))
    picture[20:40, 40:60, 0] = 64  # bin 4
    assert of(picture)["colour_emd"] == 2.0


def test_colour_emd_is_the_sum_of_three_of_scipy():
    picture = noise(seed=3)
    box = np.array([30, 20, 30, 60])
    inside, around = masks(box)
    bins = np.arange(16)
    expected = 0.0
    for channel in range(3):
        shares = [
            np.bincount(picture[mask][:, channel] // 16, minlength=16) for mask in (inside, around)
        ]
        expected += wasserstein_distance(bins, bins, *shares)
    values = of(picture, box[None].astype(float))
    assert values["colour_emd"] == pytest.approx(expected)
    grey_levels = of(picture, box[None].astype(float), settings=FeatureSettings(bin_distance=16))
    assert grey_levels["colour_emd"] == pytest.approx(16 * expected)


def test_one_histogram_of_48_bins_gives_a_third():
    """The other reading of the paper's "combined" histogram differs by a factor alone."""
    picture = noise(seed=4)
    inside, around = masks(np.array([30, 20, 30, 60]))
    bins = np.arange(48)
    combined = [
        np.concatenate([np.bincount(picture[mask][:, c] // 16, minlength=16) for c in range(3)])
        for mask in (inside, around)
    ]
    value = of(picture, np.array([[30.0, 20, 30, 60]]))["colour_emd"]
    assert value / 3 == pytest.approx(wasserstein_distance(bins, bins, *combined))


def test_distance_from_the_fixation_is_that_of_the_middle():
    assert of(grey(), fixation=(53.0, 44.0))["fixation_distance_px"] == 5.0  # from (50, 40)
    assert np.isnan(of(grey())["fixation_distance_px"])


def test_each_pedestrian_may_have_a_fixation_of_its_own():
    boxes = np.repeat(BOX, 2, axis=0)
    values = features_of(grey(), boxes, np.array([[50.0, 41.0], [47.0, 44.0]]))
    assert values[:, 7].tolist() == [1.0, 5.0]


def test_a_grey_picture_gives_what_it_can():
    picture = grey()
    picture[20:60, 40:60] = 50
    values = of(picture, fixation=(0.0, 0.0))
    undefined = {key for key, value in values.items() if np.isnan(value)}
    assert undefined == {"lab_distance", "colour_emd"}


def test_three_channels_that_hardly_differ_are_a_grey_picture():
    single = grey()
    single[20:60, 40:60] = 50
    three = np.repeat(single[:, :, None], 3, axis=2)
    np.testing.assert_array_equal(features_of(three, BOX), features_of(single, BOX))
    three[..., 2] += 8  # as a grey JPEG picture, but more
    assert np.isnan(features_of(three, BOX)[0, [4, 6]]).all()
    three[99, 99, 2] = 9
    assert not np.isnan(features_of(three, BOX)[0, [4, 6]]).any()


@pytest.mark.parametrize("pair", [(0, 1), (0, 2), (1, 2)])
def test_any_two_channels_that_differ_are_colour(pair: tuple[int, int]):
    """The third lies in the middle, no further than 8 levels from either."""
    picture = np.full((100, 100, 3), 100, np.uint8)
    picture[20:60, 40:60, pair[0]] = 92
    picture[20:60, 40:60, pair[1]] = 108
    values = of(picture)
    assert values["colour_emd"] > 0
    assert values["lab_distance"] > 5


def test_a_box_that_fills_the_picture_has_no_surround():
    values = of(noise(), np.array([[0.0, 0.0, 160.0, 120.0]]), fixation=(0.0, 0.0))
    contrasts = ["luminance_contrast", "lab_distance", "edge_contrast", "colour_emd"]
    assert all(np.isnan(values[key]) for key in contrasts)
    assert not np.isnan(values["luminance_sd"])


@pytest.mark.parametrize("box", [[200.0, 20, 20, 40], [-30, 20, 20, 40], [40, 20, 0, 40]])
def test_a_box_without_anything_in_the_picture_has_no_features(box: list[float]):
    assert np.isnan(features_of(grey(), np.array([box]), (0.0, 0.0))).all()


def test_a_box_between_the_middles_of_pixels_has_its_size_alone():
    values = of(noise(), np.array([[40.6, 20.0, 0.8, 40.0]]), fixation=(41.0, 40.0))
    defined = {key for key, value in values.items() if not np.isnan(value)}
    assert defined == {"width_px", "height_px", "fixation_distance_px"}


def test_a_pixel_counts_if_its_middle_is_in_the_box():
    picture = grey()
    picture[:, 40] = 100
    # middles at 40.5 and 41.5: from x = 40.5 on the column 40 is still the box's, from 40.6 on not
    first = features_of(picture, np.array([[40.5, 20, 1, 40], [40.6, 20, 1, 40]]))
    assert first[:, 2].tolist() == [0.0, 0.0]
    assert first[0, 3] > 0  # the pedestrian is bright, the surround dark
    assert features_of(picture, np.array([[40.0, 20, 2, 40]]))[0, 2] == 50.0


def test_the_surround_is_as_large_as_its_setting_says():
    picture = grey()
    picture[20:60, 40:60] = 50
    picture[20:60, 60:70] = 50  # within twice the box's sides
    assert of(picture)["luminance_contrast"] == pytest.approx(50 - 50 * 400 / 2400)
    narrow = FeatureSettings(surround=1.5)  # x 35..65, y 10..70: 1000 pixels, 5 x 40 bright
    assert of(picture, settings=narrow)["luminance_contrast"] == pytest.approx(50 - 50 * 200 / 1000)


def test_the_surround_ends_with_the_picture():
    picture = grey()
    picture[0:40, 0:20] = 50
    picture[:, 20:30] = 20
    # left and above there is nothing: to the right 10 x 60, below 20 x 20
    around = (10 * 60 * 20 + 20 * 20 * 0) / (10 * 60 + 20 * 20)
    box = np.array([[0.0, 0.0, 20.0, 40.0]])
    assert of(picture, box)["luminance_contrast"] == pytest.approx(50 - around)


def test_many_boxes_give_what_each_gives_alone():
    rng = np.random.default_rng(5)
    boxes = np.stack([*rng.uniform(-20, 140, (2, 30)), *rng.uniform(2, 60, (2, 30))], axis=1)
    together = features_of(noise(), boxes, (80.0, 60.0))
    alone = [features_of(noise(), box[None], (80.0, 60.0))[0] for box in boxes]
    np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((5, 5, 4), np.uint8), r"uint8 of the shape \(5, 5, 4\)"),
        (np.zeros((5, 5, 1), np.uint8), r"uint8 of the shape \(5, 5, 1\)"),
        (np.zeros((5, 5, 2), np.uint8), r"uint8 of the shape \(5, 5, 2\)"),
        (np.zeros((5, 5, 3)), r"float64 of the shape \(5, 5, 3\)"),
        (np.zeros((5, 5), np.uint16), r"uint16 of the shape \(5, 5\)"),
        (np.zeros((0, 5, 3), np.uint8), r"uint8 of the shape \(0, 5, 3\)"),
        (np.zeros(25, np.uint8), r"uint8 of the shape \(25,\)"),
        ([[1, 2], [3, 4]], "list"),
    ],
)
def test_what_is_no_picture_is_refused(picture: object, words: str):
    with pytest.raises(ParameterError, match=f"^picture: expected .*, found {words}"):
        features_of(picture, BOX)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("boxes", "words"),
    [
        (np.arange(20.0).reshape(4, 5), r"boxes: expected the shape \(n, 4\), found \(4, 5\)"),
        (np.arange(4.0), r"boxes: expected the shape \(n, 4\), found \(4,\)"),
        (np.array([["a", "b", "c", "d"]]), "boxes: expected numbers"),
        (np.array([[-np.inf, 0, np.inf, 5]]), "boxes: expected numbers, or NaN for not known"),
    ],
)
def test_boxes_of_another_shape_are_refused(boxes: np.ndarray, words: str):
    with pytest.raises(ParameterError, match=words):
        features_of(grey(), boxes)


@pytest.mark.parametrize(
    ("fixation", "words"),
    [
        (np.zeros((1, 3)), r"fixation: expected the shape \(n, 2\), found \(1, 3\)"),
        (np.zeros((2, 2)), "fixation: expected one point, or one for each of 1 boxes, found 2"),
    ],
)
def test_fixations_of_another_shape_are_refused(fixation: np.ndarray, words: str):
    with pytest.raises(ParameterError, match=words):
        features_of(grey(), BOX, fixation)


@given(
    seed=st.integers(0, 1000),
    height=st.integers(1, 40),
    width=st.integers(1, 40),
    surround=st.floats(1.1, 4),
)
def test_features_lie_within_what_8_bits_and_the_picture_allow(
    seed: int, height: int, width: int, surround: float
):
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
    boxes = np.concatenate([rng.uniform(-10, 40, (5, 2)), rng.uniform(0.1, 40, (5, 2))], axis=1)
    values = features_of(picture, boxes, (0.0, 0.0), FeatureSettings(surround=surround))
    assert values.shape == (5, len(FEATURE_KEYS))
    most = [width, height, 127.5, 255, 260, 4 * 255 * 2**0.5, 45, np.hypot(width, height)]
    assert not (values < 0).any()
    assert not (values > np.array(most) * (1 + 1e-6)).any()
    # in the mirror, with the point where the driver looks, nothing else is seen
    mirrored = boxes * [-1, 1, 1, 1] + [width, 0, 0, 0] - boxes[:, [2]] * [1, 0, 0, 0]
    other = features_of(
        np.ascontiguousarray(picture[:, ::-1]),
        mirrored,
        (float(width), 0.0),
        FeatureSettings(surround=surround),
    )
    np.testing.assert_allclose(other, values, atol=2e-3)


def test_no_boxes_give_no_rows():
    assert features_of(noise(), np.empty((0, 4))).shape == (0, 8)


@pytest.mark.parametrize(
    "given", [{"surround": 1.0}, {"surround": float("nan")}, {"bin_distance": 0.0}]
)
def test_settings_outside_their_range_are_refused(given: dict[str, float]):
    with pytest.raises(ParameterError, match=f"{next(iter(given))}: expected"):
        FeatureSettings(**given)


def test_the_documentation_lists_every_feature_in_its_words():
    page = (ROOT / "docs" / "driver-reference.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([\w ]+) \| (\S[^|]*) \|", page, re.MULTILINE)
    assert [(key, name, unit.strip()) for key, name, unit in rows] == [
        (feature.key, feature.label, feature.unit) for feature in FEATURES
    ]

"""OpenCV's people detectors: windows with their scores, in pixels of the picture."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from places import SAMPLE

from nvcore.pictures import Picture, open_pictures
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.hog import Hog, HogSettings, open_hog


@pytest.fixture(scope="module")
def picture() -> Picture:
    """With people of some 60 px."""
    pictures = open_pictures(SAMPLE.parent / "urban_crossing.mp4")
    try:
        return np.ascontiguousarray(pictures.read(60)[200:328, 400:560])
    finally:
        pictures.close()


def test_windows_are_those_of_opencv_without_grouping(picture: Picture):
    plain = Hog(HogSettings(person_box=False, overlap=1.0, upscale=2.0, scale_step=1.2))
    descriptor = cv2.HOGDescriptor()
    descriptor.setSVMDetector(cv2.HOGDescriptor.getDefaultPeopleDetector())
    large = cv2.resize(picture, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR)
    n_threads = cv2.getNumThreads()
    try:
        cv2.setNumThreads(1)  # with more it now and then gives windows the scores of others
        windows, scores = descriptor.detectMultiScale(
            large, 0.0, (8, 8), (8, 8), scale=1.2, groupThreshold=0
        )
    finally:
        cv2.setNumThreads(n_threads)
    detections = plain.detect(picture)
    assert len(detections) == len(windows) > 0
    expected = sorted(zip(np.ravel(scores), *windows.T / 2, strict=True))
    measured = zip(*(getattr(detections, name) for name in ("score", *"xywh")), strict=True)
    np.testing.assert_array_equal(sorted(measured), expected)


def test_the_person_stands_in_the_middle_of_the_window(picture: Picture):
    settings = {"upscale": 2, "scale_step": 1.2, "overlap": 1}
    person = open_hog("", settings).detect(picture)
    window = open_hog("", {**settings, "person_box": "no"}).detect(picture)
    first = int(np.argmax(person.score)), int(np.argmax(window.score))
    assert person.h[first[0]] == pytest.approx(0.75 * window.h[first[1]])
    assert person.w == pytest.approx(0.41 * person.h)
    assert person.x[0] + person.w[0] / 2 == pytest.approx(window.x[0] + window.w[0] / 2)


def test_the_most_confident_box_is_a_pedestrian_of_the_truth(picture: Picture):
    detections = open_hog("daimler", {"upscale": 1.5, "scale_step": 1.1}).detect(picture)
    x, y = detections.x[0] + 400, detections.y[0] + 200  # truth: (487.8, 217.5, 18.0, 61.2)
    assert (x, y, detections.h[0]) == pytest.approx((487, 217, 60), abs=6)


def test_both_give_the_same_twice_and_say_which_they_are(picture: Picture):
    settings = {"upscale": 2, "scale_step": 1.2}
    hog, daimler = open_hog("", settings), open_hog("daimler", settings)
    assert (hog.about.name, daimler.about.name) == ("HOG", "HOG Daimler")
    assert hog.about.fingerprint == open_hog("", settings).about.fingerprint
    assert hog.about.fingerprint != daimler.about.fingerprint
    assert hog.about.fingerprint != open_hog("", {**settings, "overlap": 0.4}).about.fingerprint
    first, second = daimler.detect(picture), daimler.detect(picture)
    assert np.array_equal(first.score, second.score)
    assert np.array_equal(first.x, second.x)


def test_grey_and_16_bit_pictures_are_read_too(picture: Picture):
    hog = open_hog("daimler", {"scale_step": 1.2})
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    thermal = grey.astype(np.uint16) * 3 + 7000
    assert len(hog.detect(grey)) > 0
    assert len(hog.detect(thermal)) > 0


def test_a_picture_smaller_than_the_window_has_nobody():
    assert len(open_hog("", {}).detect(np.zeros((40, 40), np.uint8))) == 0


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"stride": 7}, r"stride: expected one of 8, 16, 24"),
        ({"stride": 12}, r"stride: expected one of 8, 16, 24 \.\.\. 64, found 12"),
        ({"overlap": "nan"}, "overlap: expected a number, found 'nan'"),
        ({"classifier": "inra"}, "classifier: expected one of inria and daimler, found 'inra'"),
    ],
)
def test_settings_are_checked(settings: dict, words: str):
    with pytest.raises(DetectorError, match=words):
        open_hog("", settings)


def test_enlarging_beyond_reason_is_refused():
    with pytest.raises(DetectorError, match="upscale: a picture of 8000 x 8000 px"):
        open_hog("", {"upscale": 4}).detect(np.zeros((8000, 8000), np.uint8))


def test_the_name_and_the_setting_must_not_name_two_classifiers():
    with pytest.raises(DetectorError, match="hog:daimler is that of daimler, found 'inria'"):
        open_hog("daimler", {"classifier": "inria"})
    assert open_hog("daimler", {"classifier": "daimler"}).settings.classifier == "daimler"

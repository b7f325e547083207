"""Detectors in processes of their own give what they give here, and are stopped in words."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import small_icf

from nvcore.common.errors import InputError, ParameterError
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.icf.displays import MOST_CELLS, map_at, window_of, window_path
from nvcore.subjects.detectors.registry import open_detector
from ui.confined.process import MODELS, Allowance, Process
from ui.subjects.detectors.confined import ConfinedDetector, DetectorSpec, describe, find, on_model


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_icf.write(tmp_path_factory.mktemp("model") / "bars.npz")


def test_several_threads_get_what_the_detector_gives(model: Path):
    pictures = [small_icf.scene(number).picture for number in range(4)]
    own = open_detector(model, {"stride": 2})
    confined = ConfinedDetector(DetectorSpec(str(model), "1", (("stride", 2),)), own.about)
    with ThreadPoolExecutor(2) as pool, closing(confined):
        answers = [*pool.map(confined.detect, pictures)]
    for picture, answer in zip(pictures, answers, strict=True):
        expected = own.detect(picture)
        assert len(expected) > 0
        np.testing.assert_array_equal(answer.score, expected.score)
        np.testing.assert_array_equal(answer.x, expected.x)


def test_what_takes_too_long_is_stopped_in_words(model: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(
        "ui.subjects.detectors.confined.MODELS", Allowance(memory_mb=3000, seconds=0.001)
    )
    spec = DetectorSpec(str(model))
    with (
        closing(ConfinedDetector(spec, open_detector(model).about)) as confined,
        pytest.raises(InputError, match=r"running the detector took more than 0\.001 s"),
    ):
        confined.detect(small_icf.scene(0).picture)


def test_a_detector_that_cannot_be_opened_says_so():
    process = Process(MODELS)
    with pytest.raises(DetectorError, match="did you mean 'hog"):
        process.call(describe, DetectorSpec("hogg"), what="opening")
    assert process.call(describe, DetectorSpec("hog"), what="opening").inside is None
    process.close()


def test_a_box_is_followed_over_the_trees(model: Path):
    spec, picture = DetectorSpec(str(model)), small_icf.scene(3).picture
    boxes = find(spec, picture)
    assert len(boxes) > 0
    box, size = (boxes.x[0], boxes.y[0], boxes.w[0]), picture.shape[1::-1]
    window = on_model(spec, window_of, *size, box)
    path = on_model(spec, window_path, picture, *window)
    assert window[0] in small_icf.SETTINGS.scales
    assert path.confidence[-1] == pytest.approx(boxes.score[0])
    assert path.rejected_after is None


def test_a_map_in_the_other_process_is_small_and_a_scale_without_a_window_is_said(model: Path):
    spec = DetectorSpec(str(model), "1", (("stride", 1),))
    process = Process(MODELS)
    picture = np.tile(small_icf.scene(0).picture, (4, 4))
    windows = process.call(on_model, spec, map_at, picture, 1.5, what="looking")
    assert windows.n_windows == (426 - 16 + 1) * (320 - 32 + 1)
    assert max(windows.score.shape) <= MOST_CELLS
    with pytest.raises(ParameterError, match="smaller than the window there"):
        process.call(on_model, spec, map_at, picture[:40, :30], 2.75, what="looking")
    process.close()

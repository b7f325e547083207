"""Targets for tables of the driver and of studies, answers of a browser, names of pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Final

import cv2
import numpy as np

from nvcore.driver.features import FEATURE_KEYS
from nvcore.driver.fixation import read_gaze
from nvcore.driver.illumination.meter import read_light
from nvcore.driver.inputs.reading import read_detectability
from nvcore.driver.inputs.trials import TRIAL_COLUMNS
from nvcore.driver.study.pictures import read_pictures
from nvcore.driver.trials.table import training_table
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.pictures.index import map_frames
from nvcore.pictures.open import open_pictures
from nvcore.ratings.agreement import measure_agreement, rank_ratings
from nvcore.ratings.reading import parse_ratings

PICTURE: Final = bytes(cv2.imencode(".png", np.zeros((4, 6), np.uint8))[1])
_MOST_NAMES: Final = 40
_TIMES_S: Final = np.array([-1e9, -0.5, 0.0, 0.05, 1.0, 2.5, 1e9])


def written(folder: Path, name: str, content: bytes) -> Path:
    """A file with this content."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


def light(content: bytes, folder: Path) -> None:
    """Readings of a light meter: at times, and since when there are any."""
    readings = read_light(written(folder, "lux.csv", content))
    levels, since_s = readings.at(_TIMES_S), readings.since_s(_TIMES_S)
    assert (np.isnan(levels) == np.isnan(since_s)).all(), "a level without a reading"
    assert not (levels < 0).any(), "less than no light"
    assert not (since_s > _TIMES_S).any(), "a reading of the future"
    assert readings.gaps_s.shape[1] == 2, "a gap without an end"


def gaze(content: bytes, folder: Path) -> None:
    """Fixations: in frames that have one and in others."""
    fixations = read_gaze(written(folder, "gaze.csv", content))
    assert (np.diff(fixations.frame) > 0).all(), "frames that are not sorted"
    frames = np.append(fixations.frame, [-(2**62), 0, 2**62])
    points = fixations.at(frames)[: len(fixations.frame)]
    assert np.array_equal(points, fixations.point), "another point"


def estimates(content: bytes, folder: Path) -> None:
    """A file of estimates of detectability."""
    path = written(folder, "detectability.csv", content)
    table = read_detectability(SourceFile(path, path.name))
    known = table["detectability"].dropna()
    assert known.between(0, 1).all(), "no share"


def trials(content: bytes, folder: Path, between: bytes) -> None:
    """Trials and features, perhaps boxes: judged and joined."""
    names = ("trials.csv", "features.csv", "boxes.csv")
    parts = zip(names, content.split(between), strict=False)
    paths = [written(folder, name, part) for name, part in parts]
    if len(paths) < 2:
        return
    table = training_table(*paths[:2], boxes=paths[2] if len(paths) > 2 else None)
    rows = table.rows
    assert rows["detectability"].between(0, 1).all(), "no share"
    assert (rows["n_right"] <= rows["n_subjects"]).all(), "more than all"
    assert rows["n_subjects"].sum() == table.n_trials, "trials that are lost"


def study_boxes(content: bytes, folder: Path) -> None:
    """A study's table of boxes, in a folder with two pictures."""
    for name in ("a.png", "b.png"):
        written(folder, name, PICTURE)
    pictures = read_pictures(written(folder, "boxes.csv", content).parent)
    assert {picture.image for picture in pictures} <= {"a.png", "b.png"}, "a picture of elsewhere"
    for picture in pictures:
        assert (picture.width, picture.height) == (6, 4), "another size"
        assert min(picture.w, picture.h) > 0, "a box without size"


def ratings(content: bytes, _folder: Path) -> None:
    """Ratings of clips: read, ranked, compared with each other."""
    table = parse_ratings(content, name="ratings.csv")
    agreement = measure_agreement(rank_ratings(table))
    assert math.isnan(agreement.w) or -1e-9 <= agreement.w <= 1 + 1e-9, "no share"


def answers(content: bytes, _folder: Path) -> None:
    """What a participant's browser sends as an answer."""
    from ui.driver.study.on_screen import answer_of, sent_by_browser

    answer = answer_of(sent_by_browser(content), "a screen")
    assert math.isfinite(answer.measured_s + answer.shown_s), "no number"
    assert math.isnan(answer.touch_x) == math.isnan(answer.touch_y), "half a touch"
    assert "a screen" in answer.device, "another screen"
    assert len(answer.device) <= 200, "more text than is stored"


def names_of_frames(content: bytes, folder: Path) -> None:
    """Names of files, a line each: recording and frame of each, as annotations have them."""
    names = content.decode("utf-8", "replace").splitlines()[:_MOST_NAMES]
    table = listed_frames([SourceFile(folder, name) for name in names], ReadOptions()).table
    frames = table[table["frame"] >= 0]
    assert len(table) == len(names), "names that are lost"
    assert not frames.duplicated(["recording", "frame"]).any(), "a frame twice"


def names_of_pictures(content: bytes, folder: Path) -> None:
    """Names of pictures, a line each: a folder of such files."""
    for name in content.decode("utf-8", "replace").splitlines()[:_MOST_NAMES]:
        path = PurePosixPath(name.replace("\0", ""))
        if path.name not in ("", "..") and len(path.name.encode()) < 200:
            written(folder, path.name, PICTURE)
    pictures = open_pictures(folder)
    try:
        if (numbers := pictures.numbers) is not None:
            assert len({*numbers.tolist()}) == pictures.n, "a number each"
        frames = np.arange(pictures.n)
        shown = map_frames(frames, pictures).index
        assert len({*shown[shown >= 0].tolist()}) == np.count_nonzero(shown >= 0), "shown twice"
        assert pictures.read(pictures.n - 1).shape == (4, 6), "another picture"
    finally:
        pictures.close()


def light_seeds() -> Iterator[bytes]:
    """With and without a gap, separated by commas and by semicolons."""
    yield b"time_s,lux\n-1.0,1000\n0.0,900.5\n0.1,10\n5,9\n"
    yield b"lux;time_s;note\n1000,5;0,0;day\n10;0,1;\n"
    yield b"time_s\tlux\n0\t0\n"


def gaze_seeds() -> Iterator[bytes]:
    """Of a few frames."""
    yield b"frame,x,y\n212,960.5,540\n3,-5,2000\n"
    yield b"y;x;frame\n540,5;960;-7\n"


def estimates_seeds() -> Iterator[bytes]:
    """With all columns and with those that are needed."""
    yield (
        b"recording,frame,x,y,w,h,track,detectability,sd,is_outside,period_s\n"
        b"drive,1,300,200,30,80,4,0.5,0.1,0,1.5\ndrive,2,301,200,30,80,4,,,1,\n"
    )
    yield b"recording,frame,x,y,w,h,detectability\na,1,3,2,3,8,1\n"


def trials_seeds(between: bytes) -> Iterator[bytes]:
    """Two subjects and two pictures, with the boxes among the features and apart."""
    rows = [
        f"{subject},1,{i},{i},{image}.png,p,{period},{period},{touch},0.7,{not_seen},{device}"
        for subject, device in (("s1", "touch"), ("s2", "simulated"))
        for i, (image, period, touch, not_seen) in enumerate(
            (("a", 0.5, "12,22", 0), ("b", 0.5, ",", 1), ("a", 1.5, "90,90", 0)), 1
        )
    ]
    asked = "\n".join([",".join(TRIAL_COLUMNS), *rows]).encode()
    values = [",".join(f"{i}.5" for i in range(len(FEATURE_KEYS)))] * 2
    images = ("a.png,p", "b.png,p")
    head = f"image,pedestrian,{','.join(FEATURE_KEYS)}"
    lines = [f"{image},{value}" for image, value in zip(images, values, strict=True)]
    boxes = [f"{image},10,20,5,9" for image in images]
    apart = "\n".join(["image,pedestrian,x,y,w,h", *boxes]).encode()
    yield between.join((asked, "\n".join([head, *lines]).encode(), apart))
    both = [f"{head},x,y,w,h", *(f"{line},10,20,5,9" for line in lines)]
    yield between.join((asked, "\n".join(both).encode()))
    yield between.join((asked.replace(b",", b";"), "\n".join([head, *lines]).encode(), apart))


def study_boxes_seeds() -> Iterator[bytes]:
    """One and two pictures."""
    yield b"image,pedestrian,x,y,w,h\na.png,1,1,1,2,2\nb.png,2,0.5,0,1,3\n"
    yield b"image;pedestrian;x;y;w;h;note\nb.png;p;-1;1,5;4;2;dark\n"


def ratings_seeds() -> Iterator[bytes]:
    """With systems and delays and without, complete and not."""
    yield b"participant,clip,rating\nann,a,1\nann,b,2\nben,a,2\nben,b,3\ncy,a,\ncy,b,4\n"
    yield (
        b"participant;clip;system;rating;delay_s\nann;a;x;1,5;2\nann;a;y;3;2\nben;a;x;2;-\n"
        b"Ben;a;y;4;0,5\n"
    )


def answers_seeds() -> Iterator[bytes]:
    """Seen, not seen, and out of time."""
    yield (
        b'{"measured_s": 1.52, "shown_s": 0.2, "touch": [12.5, 40], "response_s": 0.71, '
        b'"is_answered": true, "pointer": "touch", "shown_px": 640, "screen_px": 1280}'
    )
    yield b'{"measured_s": 3, "shown_s": 0.2, "touch": null, "is_answered": false}'


def names_seeds() -> Iterator[bytes]:
    """As cameras, datasets and annotation tools call them."""
    yield b"000001.png\n000002.png\n000003.jpg\n"
    yield b"set06/V000/I00019.jpg\nset06/V000/I00020.jpg\n"
    yield b"img_0120.png\nframe-7.png\nseq/im 8.png\n"
    yield b"drive_1_frame12.jpg\ndrive_1_frame13.jpg\n"
    yield b"7_jpg.rf.0a1b2c.jpg\n8_jpg.rf.0a1b2d.jpg\n9_jpg.rf.0a1b2e.jpg\n"
    yield b"1691234567890123_lwir.png\n1691234567990123_lwir.png\n1691234568090123_lwir.png\n"
    yield b"img_0120.png\nimg_0120 (1).png\nimg_0121.png\ncalib.png\n"

"""Features over recordings: which pictures, gaze and light they are of, and what is said of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from picture_files import write_numbered_video, write_picture

from nvcore.common.errors import FormatError, InputError, ParameterError
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.notes import phrase
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.features import FEATURE_KEYS, features_of
from nvcore.subjects.driver.illumination import LightSettings, read_light
from nvcore.subjects.driver.illumination.clock import adaptation_clock
from nvcore.subjects.driver.running.run import (
    FEATURE_COLUMNS,
    FeatureRun,
    light_doubt,
    light_note,
    open_recordings,
    run_features,
)
from nvcore.subjects.driver.settings import DriverViewSettings, settings_from

BOX = (20.0, 10.0, 8.0, 16.0)
FPS = 4
N_FRAMES = 40
DARK_FROM = 20


def picture(frame: int, *, scale: int = 1) -> np.ndarray:
    """RGB, 64 x 48: a red person before blue that moves right; a quarter as bright from 20 on."""
    level = 200 if frame < DARK_FROM else 50
    rgb = np.zeros((48, 64, 3), np.uint8)
    rgb[..., 2] = level
    rgb[10:26, 20 + frame % 4 : 28 + frame % 4] = (level, 10, 10)
    return np.repeat(np.repeat(rgb, scale, axis=0), scale, axis=1)


def write_pictures(folder: Path, *, scale: int = 1, grey: bool = False) -> None:
    for frame in range(N_FRAMES):
        rgb = picture(frame, scale=scale)
        stored = rgb[..., 0] if grey else rgb[..., ::-1]  # OpenCV stores BGR
        write_picture(folder / f"{frame:03}.png", np.ascontiguousarray(stored))


def write_truth(folder: Path) -> None:
    """A person in each frame, and an ignored box in frame 1."""
    rows = [f"drive,{frame},{20 + frame % 4},10,8,16,5,0" for frame in range(N_FRAMES)]
    rows.insert(2, "drive,1,40,30,5,9,,1")
    text = "\n".join(["recording,frame,x,y,w,h,track,ignore", *rows])
    (folder / "truth.csv").write_text(text + "\n")


@pytest.fixture
def place(tmp_path: Path) -> Path:
    write_truth(tmp_path)
    write_pictures(tmp_path / "drive")
    return tmp_path


def opened(place: Path, keys: str) -> Dataset:
    """A session of one recording with these keys."""
    frames = "" if "frames = " in keys.partition("[[")[0] else f'frames = "0:{N_FRAMES - 1}"\n'
    (place / "session.toml").write_text(
        f'[defaults]\nsize = "64x48"\nfps = {FPS}\n[truth]\npath = "truth.csv"\n'
        f'[[recording]]\nname = "drive"\n{frames}{keys}'
    )
    return load(read_session(place / "session.toml", needs_system=False))


def run(place: Path, keys: str = 'pictures = "drive"\n', **options: object) -> FeatureRun:
    return run_features(opened(place, keys), **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> FeatureRun:
    """A run over the recording as it is made."""
    folder = tmp_path_factory.mktemp("usual")
    write_truth(folder)
    write_pictures(folder / "drive")
    return run(folder, n_threads=3)


def features(table: pd.DataFrame) -> np.ndarray:
    return table[list(FEATURE_KEYS)].to_numpy(float)


def test_every_box_that_is_not_ignored_has_a_row(usual: FeatureRun):
    table = usual.table
    assert tuple(table.columns) == FEATURE_COLUMNS
    assert table["frame"].tolist() == [*range(N_FRAMES)]
    assert (table["track"] == 5).all()
    assert table[["recording", "x", "w"]].iloc[3].tolist() == ["drive", 23.0, 8.0]


def test_features_are_those_of_the_pictures(usual: FeatureRun):
    table = usual.table
    for frame in (0, 7, 30):
        box = np.array([[20 + frame % 4, 10, 8, 16.0]])
        expected = features_of(picture(frame), box, (32.0, 24.0))
        np.testing.assert_array_equal(features(table)[[frame]], expected)


def test_pictures_of_visible_light_go_before_the_recording_s_own(place: Path):
    write_pictures(place / "visible", scale=2)
    part = run(place, 'pictures = "drive"\nvisible = "visible"\n').recordings[0]
    assert part.table["x"].iloc[0] == 20.0
    expected = features_of(picture(0, scale=2), 2 * np.array([BOX]), (64.0, 48.0))
    np.testing.assert_array_equal(features(part.table)[:1], expected)
    assert not any("its own pictures" in note for note in part.notes)


@pytest.mark.parametrize(
    ("more", "is_doubted"), [("", True), ("visible_map = [1, 1.5, 0, 0]\n", False)]
)
def test_pictures_of_another_shape_without_a_map_are_doubted(
    place: Path, more: str, is_doubted: bool
):
    for frame in range(N_FRAMES):
        write_picture(place / "visible" / f"{frame:03}.png", np.zeros((72, 64, 3), np.uint8))
    part = run(place, f'visible = "visible"\n{more}').recordings[0]
    assert (
        "visible is 64 x 72 px and the recording is 64 x 48 px, so boxes are scaled by 1 "
        "horizontally and 1.5 vertically. Do they belong together? If so, give visible_map."
        in part.notes
    ) == is_doubted
    assert ("Do they belong together?" in part.picture_doubt) == is_doubted


@pytest.mark.parametrize(
    ("n", "more", "is_doubted"),
    [
        (40, "", False),
        (39, "", True),
        (41, "", True),
        (80, "", True),
        (80, "first_picture = -40\n", False),
        (40, 'frames = "0:39:10"\n', False),
        (39, 'frames = "0:39:10"\n', True),
        (300, 'frames = "0:9"\n', False),  # some of them: nobody knows how many there are
    ],
)
def test_a_video_of_another_number_of_pictures_is_doubted(
    tmp_path: Path, n: int, more: str, is_doubted: bool
):
    write_truth(tmp_path)
    write_numbered_video(tmp_path / "visible.mp4", n=n)
    dataset = opened(tmp_path, f'visible = "visible.mp4"\n{more}')
    (part,) = open_recordings(dataset.settings, dataset, DriverViewSettings())
    part.pictures.close()
    doubt = (
        f"visible.mp4 has {n} pictures and the recording has frames 0 to 39. Do they belong "
        "together, at the same frame rate?"
    )
    assert [phrase(note, PEDESTRIAN) for note in part.doubts] == [doubt] * is_doubted


def test_frames_of_a_sample_may_count_from_1(tmp_path: Path):
    (tmp_path / "truth.csv").write_text("recording,frame,x,y,w,h\ndrive,1,20,10,8,16\n")
    write_numbered_video(tmp_path / "visible.mp4", n=39)
    dataset = opened(tmp_path, 'visible = "visible.mp4"\nframes = "1:39:2"\n')
    (part,) = open_recordings(dataset.settings, dataset, DriverViewSettings())
    part.pictures.close()
    assert part.doubts == ()


def test_each_row_says_of_which_picture_its_features_are(place: Path, usual: FeatureRun):
    write_pictures(place / "visible")
    (place / "visible" / "005.png").unlink()
    table = run(place, 'pictures = "drive"\nvisible = "visible"\n').table
    assert table["picture"][[4, 6]].tolist() == ["visible", "visible"]
    assert table.loc[table["picture"] == "", "luminance_sd"].isna().all()
    assert (table["picture"] == "").sum() == 1
    assert set(usual.table["picture"]) == {"own"}


def test_a_map_says_where_boxes_lie_in_the_visible_picture(place: Path):
    write_pictures(place / "visible", scale=2)
    keys = 'visible = "visible"\nvisible_map = [1, 2, 5, -3]\n'
    expected = features_of(picture(0, scale=2), np.array([[25.0, 17.0, 8.0, 32.0]]), (64.0, 48.0))
    np.testing.assert_array_equal(features(run(place, keys).table)[:1], expected)


def test_own_pictures_that_are_grey_are_said_to_say_nothing_of_eyes(place: Path):
    write_pictures(place / "thermal", grey=True)
    part = run(place, 'pictures = "thermal"\n').recordings[0]
    assert part.table["lab_distance"].isna().all()
    assert part.table["luminance_contrast"].notna().all()
    assert part.table["period_s"].isna().all()
    text = " ".join(part.notes)
    assert "Far-infrared pictures say nothing about what eyes see" in text
    assert "Nothing is known about the light" in text


def test_the_fixation_is_that_of_the_gaze_file(place: Path):
    (place / "gaze.csv").write_text("frame,x,y\n0,24,21\n1,0,18\n")
    part = run(place, 'pictures = "drive"\ngaze = "gaze.csv"\n').recordings[0]
    distance = part.table["fixation_distance_px"]
    assert distance[:2].tolist() == [3.0, 25.0]  # from the middles (24, 18) and (25, 18)
    assert distance[2:].isna().all()
    assert "Fixation by the gaze file, which has none in 38 of 40 frames with boxes." in (
        part.notes
    )


def test_points_outside_the_picture_are_counted(place: Path):
    rows = [f"{frame},{64 + frame % 2},24" for frame in range(N_FRAMES - 2)]
    (place / "gaze.csv").write_text("\n".join(["frame,x,y", *rows]) + "\n")
    part = run(place, 'pictures = "drive"\ngaze = "gaze.csv"\n').recordings[0]
    assert (
        "Fixation by the gaze file, which has none in 2 of 40 frames with boxes. 19 of its "
        "38 points in frames with boxes lie outside the picture of 64 x 48 px."
    ) in part.notes
    assert part.picture_doubt == "19 of 38 points of the gaze file lie outside the picture."
    (place / "gaze.csv").write_text("\n".join(["frame,x,y", *rows[::2], *rows[1:18:2]]) + "\n")
    part = run(place, 'pictures = "drive"\ngaze = "gaze.csv"\n').recordings[0]
    assert part.picture_doubt == ""


def test_a_gaze_file_of_other_frames_is_said_to_be(place: Path):
    (place / "gaze.csv").write_text("frame,x,y\n1299,24,21\n1000,5,18\n")
    keys = 'pictures = "drive"\ngaze = "gaze.csv"\n'
    part = run(place, keys).recordings[0]
    words = "he gaze file has frames 1000 to 1299, but the recording has 0 to 39"
    assert f"T{words}, so no fixation is known." in part.notes
    assert part.why_missing == {"fixation_distance_px": f"t{words}"}
    (place / "gaze.csv").write_text("frame,x,y\n")
    assert (
        "The gaze file has no row, so no fixation is known." in run(place, keys).recordings[0].notes
    )


@pytest.mark.parametrize(
    ("right", "note"),
    [
        (640, "With its visible_map all boxes lie outside the picture."),
        (41.5, "With its visible_map 10 of 40 boxes lie outside the picture."),
        (5, ""),
    ],
)
def test_boxes_outside_the_picture_are_counted(place: Path, right: float, note: str):
    keys = f'visible = "drive"\nvisible_map = [1, 1, {right}, 0]\n'
    part = run(place, keys).recordings[0]
    assert [text for text in part.notes if "lie outside" in text] == [note] * bool(note)
    assert bool(part.why_missing) == (right == 640)


def test_without_a_gaze_file_a_point_is_assumed_and_said(place: Path):
    settings = settings_from({"fixation": (0.375, 0.375)})
    part = run(place, settings=settings).recordings[0]
    assert part.table["fixation_distance_px"].iloc[0] == 0.0
    assert "Fixation assumed: 38 % across and 38 % down the picture." in part.notes


def test_the_adaptation_period_is_that_at_the_end_of_the_frame(place: Path):
    rows = [f"{i / 20},{1000 if i < 120 else 10}" for i in range(300)]
    (place / "lux.csv").write_text("\n".join(["time_s,lux", *rows]) + "\n")
    part = run(place, 'pictures = "drive"\nlight = "lux.csv"\n').recordings[0]
    table = part.table  # it becomes dark at 6 s; frame 24 begins then
    assert table["period_s"][:24].isna().all()
    assert table["period_s"][24:27].tolist() == pytest.approx([0.25, 0.5, 0.75])
    assert table["illumination"][[0, 23, 24]].tolist() == [1000, 1000, 10]
    assert set(table["illumination_by"]) == {"meter"}
    assert (
        "Light by the light meter: 1 change from bright to dark; readings of 10 to 1,000 lx."
    ) in part.notes


def light_of(folder: Path, rows: list[str], frames: range = range(N_FRAMES)) -> tuple[str, str]:
    """What is noted of a light meter, and how it is doubted."""
    (folder / "lux.csv").write_text("\n".join(["time_s,lux", *rows]) + "\n")
    light, frame, settings = read_light(folder / "lux.csv"), np.array(frames), LightSettings()
    clock = adaptation_clock(light, frame, FPS, settings)
    notes = (
        light_note(light, clock, frame, FPS, settings),
        light_doubt(light, frame, FPS, settings),
    )
    note, doubt = ("" if note is None else phrase(note, PEDESTRIAN) for note in notes)
    return note, doubt.replace("\xa0", " ")


def readings(first_s: float, step_s: float, dark_from: int, unit: float = 1.0) -> list[str]:
    levels = [1000 * unit if i < dark_from else 10 * unit for i in range(300)]
    return [f"{first_s + i * step_s:.9g},{level:g}" for i, level in enumerate(levels)]


NONE = "Light by the light meter: 0 changes from bright to dark"
ONE = "Light by the light meter: 1 change from bright to dark"
OF_LUX = "readings of 10 to 1,000 lx"
DIM = "readings of 0.005 to 0.5 lx"
OF_10_S = "while the recording is from 0 to 10 s"
NOTHING = f"{OF_10_S}. Nothing is known about the light, so there is no adaptation period."


def without(rows: list[str], *gaps: tuple[float, float]) -> list[str]:
    """Readings without those after the beginning of a gap and before its end."""
    times_s = [float(row.partition(",")[0]) for row in rows]
    return [
        row
        for row, time_s in zip(rows, times_s, strict=True)
        if not any(start < time_s < end for start, end in gaps)
    ]


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        (readings(0, 0.05, 240), f"{NONE}; {OF_LUX}."),
        (readings(0, 50, 120), f"{NONE}, with one reading in 50 s; {OF_LUX}."),
        (readings(2.5, 0.05, 120), f"{ONE}; {OF_LUX}; readings are from 2.5 to 17.4 s, {OF_10_S}."),
        (
            readings(100_000, 0.05, 120),
            f"The light meter's readings are from 100,000 to 100,015 s, {NOTHING}",
        ),
        (
            readings(-100_000, 0.05, 120),
            f"The light meter's readings are from -100,000 to -99,985 s, {NOTHING}",
        ),
        (
            without(readings(-5, 0.05, 200), (4.52, 9.02)),
            f"{NONE}; {OF_LUX}; no reading from 4.5 to 9.05 s: the light is not known from 5.5 to "
            "12.1 s.",
        ),
        (
            without(readings(-9, 0.05, 400), (-7.98, -3.98)),
            f"{NONE}; readings of 1,000 lx; readings are from -9 to 5.95 s, {OF_10_S}.",
        ),
        (
            without(readings(-1, 0.2, 200), (1, 3), (4, 7), (30, 40)),  # the last lies after it
            f"{NONE}; {OF_LUX}; 2 gaps between readings, the longest from 4 to 7 s: the light is "
            "not known from 1 s after each begins to 3 s after it ends.",
        ),
        (
            readings(0, 0.05, 120, unit=5e-4),
            f"{NONE}; {DIM}, 180 of 300 below 0.1 lx, counted as 0.1 lx.",
        ),
        (readings(0, 0.05, 280, unit=5e-4), f"{NONE}; {DIM}."),
    ],
)
def test_readings_are_described_with_gaps_and_doubts(tmp_path: Path, rows: list[str], text: str):
    assert light_of(tmp_path, rows)[0] == text


def test_changes_before_the_first_frame_are_counted_apart(tmp_path: Path):
    for dark_from, text in ((80, f"{NONE}, 1 before the first frame"), (160, ONE)):
        note = light_of(tmp_path, readings(0, 0.05, dark_from), range(24, 40))[0]
        assert note == f"{text}; {OF_LUX}."


def test_missing_pictures_that_stand_in_for_a_light_meter_are_said_to_be(place: Path):
    for frame in range(12, 32):
        (place / "drive" / f"{frame:03}.png").unlink()
    part = run(place).recordings[0]
    assert part.notes[-1] == (
        "Light by the mean luminance of pictures (there is no light meter): 0 changes from bright "
        "to dark; no picture from 2.75 to 8 s: the light is not known from 3.75 to 11 s."
    )
    assert part.is_light_known.tolist() == [frame in range(12, 16) for frame in range(N_FRAMES)]


@pytest.mark.parametrize(
    ("rows", "doubt"),
    [
        (readings(0, 0.05, 120), ""),
        (readings(0, 0.05, 120, unit=5e-4), "180 of 300 readings below 0.1 lx"),
        (readings(0, 50, 120), "one reading in 50 s"),
        (readings(7.5, 0.05, 120), "readings in 25 % of the recording"),
        (readings(4.5, 0.05, 120), "readings in 55 % of the recording"),
        (readings(0.9, 0.05, 120), ""),
        (readings(0, 0.05, 120, unit=1e3), "a reading of 1,000,000 lx, more than direct sunlight"),
        ([], "no reading"),
    ],
)
def test_a_light_meter_that_looks_like_another_unit_or_clock_is_doubted(
    tmp_path: Path, rows: list[str], doubt: str
):
    assert light_of(tmp_path, rows)[1] == doubt


def test_a_light_file_without_readings_tells_nothing(place: Path):
    (place / "lux.csv").write_text("time_s,lux\n")
    part = run(place, 'pictures = "drive"\nlight = "lux.csv"\n').recordings[0]
    assert part.table[["period_s", "illumination"]].isna().all(axis=None)
    assert part.light_doubt == "no reading"
    assert (
        "The light file has no readings. Nothing is known about the light, so there is no "
        "adaptation period."
    ) in part.notes


def test_the_pictures_stand_in_for_a_light_meter(usual: FeatureRun):
    (part,) = usual.recordings
    assert part.light_doubt == ""
    period_s = part.table["period_s"]
    assert period_s[: DARK_FROM - 1].isna().all()
    assert period_s[DARK_FROM] == pytest.approx(1 / FPS)
    assert set(part.table["illumination_by"]) == {"picture"}
    assert any("(there is no light meter): 1 change from" in note for note in part.notes)


def test_boxes_in_frames_without_a_picture_have_no_features_and_are_counted(place: Path):
    (place / "drive" / "003.png").unlink()
    (place / "drive" / "004.png").write_bytes(b"\x89PNG damaged")
    part = run(place).recordings[0]
    assert np.flatnonzero(part.table["width_px"].isna()).tolist() == [3, 4]
    assert part.n_unseen == 2
    text = " ".join(part.notes)
    assert "2 boxes are in frames without a picture. The number" in text
    assert "1 picture cannot be read: 004.png" in text


def test_a_recording_without_pictures_is_said_to_have_none(place: Path):
    rows = (place / "truth.csv").read_text() + "other,0,1,1,5,9,,0\n"
    (place / "truth.csv").write_text(rows)
    other = '[[recording]]\nname = "other"\nframes = "0:1"\n'
    parts = run(place, f'pictures = "drive"\n{other}').recordings
    assert parts[1].table["width_px"].isna().all()
    assert "No pictures are named for it." in parts[1].notes[0]
    assert parts[1].why_missing == {}


def test_why_no_picture_can_be_opened_is_said_before_what_to_do(place: Path):
    with pytest.raises(
        InputError, match=r"has a picture: nothere\.mp4: there is .*; name the pict"
    ):
        run(place, 'visible = "nothere.mp4"')


def test_without_any_picture_it_is_refused(place: Path):
    with pytest.raises(InputError, match="no evaluated frame has a picture"):
        run(place, "")


def test_a_wrong_gaze_or_light_file_is_refused_before_pictures_are_read(place: Path):
    (place / "gaze.csv").write_text("frame,x,y\n0,24,up\n")
    with pytest.raises(FormatError, match=r"gaze\.csv, line 2: y: expected a number"):
        run(place, 'pictures = "none"\ngaze = "gaze.csv"\n')
    (place / "lux.csv").write_text("time_s,lux\n0,1\n0,2\n")
    with pytest.raises(FormatError, match=r"lux\.csv, line 3: time_s: expected a time after"):
        run(place, 'pictures = "none"\nlight = "lux.csv"\n')


def test_progress_counts_pictures(place: Path):
    shares: list[float] = []
    run(place, progress=lambda share, _: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_print_says_once_what_holds_for_several_recordings(place: Path):
    rows = (place / "truth.csv").read_text()
    (place / "truth.csv").write_text(rows + rows.replace("drive", "again").partition("\n")[2])
    again = f'[[recording]]\nname = "again"\nframes = "0:{N_FRAMES - 1}"\npictures = "drive"\n'
    text = str(run(place, f'pictures = "drive"\n{again}'))
    assert text.startswith("80 boxes in 80 pictures, in ")
    assert "\ndrive and again: Features are computed from the recording's own" in text


def test_unknown_settings_are_refused_with_the_near_ones():
    with pytest.raises(ParameterError, match="did you mean 'surround'"):
        settings_from({"suround": 2})
    settings = settings_from({"surround": 3.0, "drop_factor": 20.0})
    assert (settings.features.surround, settings.light.drop_factor) == (3.0, 20.0)

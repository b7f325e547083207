"""The visible-light pictures: light by hand, geometry as of the thermal ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tools.sample import all_recordings
from tools.sample.camera import Camera
from tools.sample.scene import Person, Recording
from tools.sample.truth import sightings
from tools.sample.visible.light import LUMA, TO_CAMERA, UP, Glow, Lights, low_beam
from tools.sample.visible.paint import Easel
from tools.sample.visible.recordings import GLOWS, lux_table
from tools.sample.visible.render import Drive
from tools.sample.visible.sensor import Sensor
from tools.sample.visible.view import View, mapped_boxes, visible_map
from tools.sample.visible.wardrobe import outfit

NOTHING = np.zeros((0, 3))
DARK = Glow(sky_lux=0.0, lamp_cd=0.0, headlamp_cd=0.0)
STREET = Recording(
    "street",
    "one person before the car",
    speed=((0, 0), (15, 0)),
    people=(Person(((0, 0.5, 20.0), (15, 0.5, 20.0))),),
)


def by_name(name: str) -> Recording:
    return next(recording for recording in all_recordings() if recording.name == name)


def test_a_thermal_pixel_has_its_place_in_the_visible_picture() -> None:
    view = View(Camera())
    point = np.array([1.5, 0.4, 30.0])
    thermal, _ = view.camera.project(point)
    visible, depth = view.project(point)
    scale_x, scale_y, dx, dy = visible_map()
    assert visible == pytest.approx(thermal * [scale_x, scale_y] + [dx, dy])
    assert depth == pytest.approx(30.0, rel=0.01)


def test_the_ray_of_a_pixel_meets_the_point_that_is_seen_there() -> None:
    view = View(Camera(horizon=232.0))
    point = np.array([-2.0, 0.7, 25.0])
    pixel, depth = view.project(point)
    ray = view.rays(pixel[0], pixel[1])
    assert ray * depth + [0.0, view.camera.mount_m, 0.0] == pytest.approx(point)


def test_boxes_are_mapped_and_clipped() -> None:
    view = View(Camera(), width=100, height=100, scale=2.0, dx=10.0, dy=-20.0)
    boxes = mapped_boxes(view, np.array([[5.0, 15.0, 10.0, 40.0], [40.0, 40.0, 60.0, 70.0]]))
    assert boxes.tolist() == [[20.0, 10.0, 10.0, 50.0], [90.0, 60.0, 10.0, 40.0]]


def test_light_falls_with_the_square_of_the_distance() -> None:
    lights = Lights(replace(DARK, lamp_cd=900.0), np.array([[0.0, 6.0, 20.0]]), way=0.0)
    below = lights.street(np.array([[0.0, 0.0, 20.0], [0.0, 3.0, 20.0]]), UP)
    assert below == pytest.approx([900 / 36, 900 / 9])
    assert lights.street(np.array([[0.0, 0.0, 80.0]]), UP)[0] == 0.0  # out of its reach


def test_a_lamp_behind_a_wall_does_not_light_it() -> None:
    lights = Lights(replace(DARK, lamp_cd=900.0), np.array([[0.0, 6.0, 20.0]]), way=0.0)
    walls = np.array([[0.0, 2.0, 15.0], [0.0, 2.0, 25.0]])
    before, behind = lights.street(walls, TO_CAMERA)
    assert before == 0.0  # the lamp shines on its back
    assert behind > 1.0


def test_the_sky_lights_the_open_ground_alone() -> None:
    light = Lights(replace(DARK, sky_lux=4.0), NOTHING, way=0.0).at(np.zeros((1, 3)), UP)
    assert light[0] @ LUMA == pytest.approx(4.0, rel=0.05)


def test_a_low_beam_ends_below_the_horizon_and_rises_to_the_right() -> None:
    angles = np.array([0.0, 0.0, 5.0])
    dark, bright, right = low_beam(angles, np.array([1.0, -1.5, 0.3]))
    assert dark < 0.08
    assert bright > 0.8
    assert right > 3 * low_beam(-angles[2:], np.array([0.3]))[0]


def test_floodlights_end_where_their_stretch_ends() -> None:
    glow = replace(DARK, flood_lux=1000.0, flood_end_m=50.0)
    places = np.array([[0.0, 0.0, 10.0], [0.0, 0.0, 50.0]])
    assert Lights(glow, NOTHING, way=0.0).flood(places, UP) == pytest.approx([1000.0, 0.0])
    assert Lights(glow, NOTHING, way=45.0).flood(places, UP) == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("name", ["urban_sidewalk", "rural_child"])
def test_the_light_sensor_sees_one_change_from_bright_to_dark(name: str) -> None:
    table = lux_table(by_name(name), GLOWS[name])
    assert list(table.columns) == ["time_s", "lux"]
    assert (len(table), table["time_s"].iloc[-1]) == (150, 14.9)
    bright, dark = table["lux"] > 500, table["lux"] < 20
    assert bright[table["time_s"] < 2].all()
    assert dark[table["time_s"] > 5.5].all()
    falls_s = table["time_s"][dark].min() - table["time_s"][bright].max()
    assert 0 < falls_s < 2


def test_oncoming_headlamps_are_no_change_from_bright_to_dark() -> None:
    lux = lux_table(by_name("oncoming_glare"), GLOWS["oncoming_glare"])["lux"]
    assert lux.max() < 60


def picture_of(recording: Recording, glow: Glow, frame: int = 0, coat: str = "white") -> np.ndarray:
    drive = Drive(recording, glow, View(recording.camera), last_frame=frame)
    outfits = [outfit("somebody", 0.5, coat, "pale") for _ in recording.people]
    return drive.frame(frame, outfits)


def test_the_person_is_painted_where_the_truth_says() -> None:
    glow = Glow(sky_lux=5.0, headlamp_cd=0.0)
    view = View(STREET.camera)
    drive = Drive(STREET, glow, view, last_frame=0)
    white = drive.frame(0, [outfit("somebody", 0.5, "white", "pale")])
    changed = np.abs(white - drive.frame(0, [])).max(axis=2) > 0.2
    rows, columns = np.nonzero(changed)
    x, y, w, h = mapped_boxes(view, sightings(STREET)[0].edges[:1])[0]
    assert [columns.min(), rows.min()] == pytest.approx([x, y], abs=3)
    assert [columns.max() + 1, rows.max() + 1] == pytest.approx([x + w, y + h], abs=3)


def test_a_white_coat_is_brighter_than_a_black_one_in_the_same_light() -> None:
    glow = Glow(sky_lux=5.0)
    x, y, w, h = mapped_boxes(View(STREET.camera), sightings(STREET)[0].edges[:1])[0]
    chest = np.s_[int(y + 0.25 * h) : int(y + 0.4 * h), int(x + 0.4 * w) : int(x + 0.6 * w)]
    white, black = (
        picture_of(STREET, glow, coat=coat)[chest].mean() for coat in ("white", "black")
    )
    assert white > 10 * black


def test_the_picture_is_in_colour_and_the_same_on_every_call() -> None:
    recording = by_name("oncoming_glare")
    scene = picture_of(recording, GLOWS["oncoming_glare"], frame=40)
    view = View(recording.camera)
    first, again = (Sensor(3, view).read(scene) for _ in range(2))
    assert (first.shape, first.dtype) == ((540, 960, 3), np.uint8)
    assert np.array_equal(first, again)
    sky = np.median(first[10:110].reshape(-1, 3), axis=0)
    assert sky[2] > sky[0] + 5  # blue hour
    assert first.max() == 255  # headlamps


@pytest.mark.parametrize("name", ["urban_crossing", "rural_cyclist", "odd_pose"])
def test_every_kind_of_thing_can_be_drawn(name: str) -> None:
    recording = by_name(name)
    scene = picture_of(recording, Glow(), frame=60)
    assert np.isfinite(scene).all()
    assert scene.std() > 0.05


def test_exposure_follows_the_light_within_a_second() -> None:
    view = View(Camera(), width=96, height=54)
    sensor = Sensor(1, view, noise=0.0)
    bright, dark = (np.full((54, 96, 3), value, dtype=np.float32) for value in (20.0, 0.3))
    levels = [float(sensor.read(scene).mean()) for scene in [bright] * 10 + [dark] * 40]
    assert levels[10] < 40  # black at first
    assert levels[30] > 60
    assert levels[-1] < levels[0]  # night stays darker than light


def test_painting_outside_the_picture_changes_nothing() -> None:
    view = View(Camera(), width=64, height=48)
    easel = Easel(np.zeros((48, 64, 3), dtype=np.float32), view)
    white = np.ones(3)
    easel.paint([(np.array([[-90.0, -90.0], [-80.0, -90.0], [-80.0, -80.0]]), white)])
    easel.paint([])
    easel.glow(np.array([-500.0, 10.0]), 5.0, white)
    tile = np.ones((4, 4), dtype=np.float32)
    easel.sprite(np.repeat(tile[..., None], 3, axis=2), tile, (-50.0, -50.0, -40.0, -40.0))
    assert not easel.picture.any()


def test_a_painted_square_has_its_colour_inside_and_nothing_outside() -> None:
    view = View(Camera(), width=64, height=48)
    easel = Easel(np.zeros((48, 64, 3), dtype=np.float32), view)
    square = np.array([[10.0, 10.0], [30.0, 10.0], [30.0, 30.0], [10.0, 30.0]])
    easel.paint([(square, np.array([2.0, 0.5, 0.02]))])
    assert easel.picture[20, 20] == pytest.approx([2.0, 0.5, 0.02], rel=0.06)
    assert not easel.picture[:8].any()
    easel.paint([(square, np.ones(3))], shading=lambda rays: np.full((len(rays), 3), 3.0),
                veil=(0.5, np.full(3, 0.25)))  # fmt: skip
    assert easel.picture[20, 20] == pytest.approx(np.full(3, 3 * 0.5 + 0.25), rel=0.02)


def test_who_is_darker_in_the_near_infrared_wears_darker_clothes() -> None:
    coats = [outfit("the same", reflectance).coat @ LUMA for reflectance in (0.05, 0.3, 0.9)]
    assert coats == sorted(coats)

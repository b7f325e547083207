"""Pictures of a training in memory, in colour or grey, and groups that are held out as a whole."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nvcore.common.errors import MediaError
from nvcore.pictures import Picture
from nvcore.subjects.detectors.training.shots import PictureStore, Shot, hold_out_groups

GREY = np.full((4, 6, 3), 7, np.uint8)
COLOUR = np.dstack([np.full((4, 6), level, np.uint8) for level in (1, 2, 3)])
BOX = np.array([[1.0, 1, 2, 2]])


def given(picture: Picture) -> Callable[[], Picture]:
    return lambda: picture


def damaged() -> Picture:
    raise MediaError("is\x1bdamaged", file="p.png")


def stored(*shots: Shot, most_bytes: int = 1000) -> PictureStore:
    return PictureStore(shots, most_bytes)


def test_pictures_without_colour_have_one_channel():
    store = stored(Shot(given(GREY), "a"), Shot(given(COLOUR), "b"))
    assert store.picture(0).shape == (4, 6)
    np.testing.assert_array_equal(store.picture(1), COLOUR)


def test_a_dark_frame_of_a_recording_in_colour_stays_in_colour():
    store = stored(Shot(given(GREY), "a"), Shot(given(COLOUR), "a"))
    np.testing.assert_array_equal(store.picture(0), GREY)


@pytest.mark.parametrize(("most_bytes", "n_read"), [(0, 3), (24, 3), (1000, 1)])
def test_what_does_not_fit_into_memory_is_read_again(most_bytes: int, n_read: int):
    n = 0

    def read() -> Picture:
        nonlocal n
        n += 1
        return COLOUR

    store = stored(Shot(given(GREY), "b"), Shot(read, "a"), most_bytes=most_bytes)
    for _ in range(2):
        np.testing.assert_array_equal(store.picture(1), COLOUR)
    assert n == n_read


def test_scenes_are_of_what_is_learned_and_of_what_is_held_out():
    both = Shot(given(GREY), "a", learned=BOX, held_out=BOX + 1, ignored=BOX + 2)
    out = Shot(given(GREY), "a", held_out=BOX, has_background=False)
    scenes, held_out = stored(both, out, Shot(damaged, "a", learned=BOX)).scenes()
    assert (len(scenes), len(held_out)) == (1, 2)
    assert scenes[0].boxes.tolist() == BOX.tolist()
    assert scenes[0].ignored.tolist() == [*(BOX + 2).tolist(), *(BOX + 1).tolist()]
    assert scenes[0].has_background
    assert held_out[1].boxes.tolist() == BOX.tolist()
    assert not any(held_out[i].has_background for i in range(2))


def test_faults_are_harmless_lines():
    assert stored(Shot(damaged, "a")).faults == {0: r"p.png: is\x1bdamaged"}


def test_groups_are_held_out_as_a_whole():
    tracks = [i // 30 for i in range(300)]
    is_out, out = hold_out_groups(tracks, 0.2, seed=0)
    assert is_out.sum() == 60
    assert out == sorted({track for track, is_one in zip(tracks, is_out, strict=True) if is_one})
    np.testing.assert_array_equal(is_out, hold_out_groups(tracks, 0.2, seed=0)[0])


def test_at_least_one_group_is_on_either_side():
    assert len(hold_out_groups(["a", "b"], 0.01, seed=0)[1]) == 1
    assert len(hold_out_groups(["a", "b"], 0.99, seed=0)[1]) == 1
    assert hold_out_groups(["a", "a"], 0.5, seed=0)[1] == []
    assert hold_out_groups([], 0.5, seed=0)[0].shape == (0,)

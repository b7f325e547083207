"""Pictures of a study: what a folder may hold, and coarse pictures that show nobody."""

import numpy as np
import pytest

from nvcore.common.errors import InputError
from nvcore.pictures.stretch import png
from nvcore.subjects.driver.study.pictures import (
    FIGURES,
    coarse,
    load_picture,
    practice_picture,
    read_pictures,
)

HEADER = "image,pedestrian,x,y,w,h\n"


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    for name, grey in (("a.png", 40), ("b.png", 60)):
        (folder / name).write_bytes(png(np.full((30, 40, 3), grey, np.uint8)))
    (folder / "boxes.csv").write_text(f"{HEADER}b.png,ped 1,10,5,6,12\na.png,ped 2,0,0,4,8\n")
    return folder


def test_a_folder_gives_its_pictures_in_the_order_of_the_table(folder):
    first, second = read_pictures(folder)
    assert (first.image, first.pedestrian, first.x, first.y, first.w, first.h) == (
        *("b.png", "ped 1"), *(10, 5, 6, 12),
    )  # fmt: skip
    assert (second.width, second.height) == (40, 30)
    assert load_picture(folder, first)[0, 0].tolist() == [60, 60, 60]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("c.png,p,0,0,4,8", r"boxes\.csv, line 2: .*no such picture"),
        ("../secret.png,p,0,0,4,8", "no such picture"),
        ("/etc/hostname,p,0,0,4,8", "no such picture"),
        ("link.png,p,0,0,4,8", "no such picture"),
        ("boxes.csv,p,0,0,4,8", "no such picture"),
        ("text.png,p,0,0,4,8", "text.png"),
        ("a.png,p,40,0,4,8", r"outside the picture \(40 x 30 px\)"),
        ("a.png,p,0,0,0,8", "w: expected"),
        ("a.png,p,0,0,4,8\na.png,q,9,0,4,8", r"line 3: a.png is there .* each \(first in line 2\)"),
        ("", "1 to 500 pictures"),
    ],
)
def test_what_is_no_study_is_refused(folder, line, words):
    (folder.parent / "secret.png").write_bytes((folder / "a.png").read_bytes())
    (folder / "link.png").symlink_to(folder.parent / "secret.png")
    (folder / "text.png").write_text("no picture")
    (folder / "boxes.csv").write_text(f"{HEADER}{line}\n")
    with pytest.raises(InputError, match=words):
        read_pictures(folder)


def test_a_folder_without_a_table_or_its_columns_is_refused(folder):
    (folder / "boxes.csv").write_text("image,x,y,w,h\na.png,0,0,4,8\n")
    with pytest.raises(InputError, match="pedestrian is missing"):
        read_pictures(folder)
    (folder / "boxes.csv").unlink()
    with pytest.raises(InputError, match=r"boxes\.csv: cannot be opened"):
        read_pictures(folder)


def test_a_picture_that_was_changed_is_not_shown(folder):
    picture = read_pictures(folder)[0]
    (folder / "b.png").write_bytes((folder / "a.png").read_bytes())
    with pytest.raises(InputError, match="has changed since the study began"):
        load_picture(folder, picture)


def test_a_coarse_picture_averages_squares():
    picture = np.arange(8 * 12, dtype=np.uint8).reshape(8, 12)
    picture[:, :6], picture[:, 6:] = 10, 30
    assert coarse(picture, (0, 0, 1, 1), n_columns=4).tolist() == [[10, 10, 30, 30]] * 3


@pytest.mark.parametrize("box", [(20, 10, 8, 20), (0, 0, 5, 40), (72, 5, 8, 35), (0, 0, 80, 40)])
def test_a_coarse_picture_shows_nobody(box):
    x, y, w, h = box
    with_person = np.full((40, 80, 3), 90, np.uint8)
    with_person[y : y + h, x : x + w] = 255
    is_whole = (w, h) == (80, 40)  # then there is nothing around
    assert np.ptp(coarse(with_person, box, n_columns=20)) == 0
    assert is_whole or coarse(with_person, box, n_columns=20).max() == 90


def test_practice_pictures_show_their_figure_and_hide_it_when_coarse():
    for index, (x, y, w, h) in enumerate(FIGURES):
        picture = practice_picture(index)
        assert picture.shape == (720, 1280, 3)
        trunk = picture[int(y + 0.4 * h), int(x + w / 2)].mean()
        beside = picture[int(y + 0.4 * h), int(x - 2 * w)].mean()
        assert trunk > beside + 20
        assert coarse(picture, FIGURES[index]).max() < 120

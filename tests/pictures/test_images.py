"""Pictures as files: order, depth, sizes, and what is refused before it is decoded."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from picture_files import encoded, number_in, numbered, png_that_claims, write_picture, write_zip
from PIL import ExifTags, Image

from nvcore.common.errors import MediaError
from nvcore.pictures import is_below, open_pictures
from nvcore.pictures.header import image_size
from nvcore.pictures.images import decode_image
from nvcore.pictures.notes import PictureNote, PictureTrait
from nvcore.pictures.stretch import STRETCH, stretch

GREY = (np.arange(48 * 64) % 251).astype(np.uint8).reshape(48, 64)


@pytest.mark.parametrize("ending", [".png", ".bmp", ".tif", ".jpg"])
def test_a_folder_is_read_in_natural_order(tmp_path: Path, ending: str):
    for number in (10, 9, 100, 1):
        write_picture(tmp_path / f"I{number}{ending}", numbered(number))
    pictures = open_pictures(tmp_path)
    assert [number_in(pictures.read(index)) for index in range(4)] == [1, 9, 10, 100]
    assert (pictures.width, pictures.height, pictures.numbers.tolist()) == (64, 48, [1, 9, 10, 100])


def test_a_folder_with_one_subfolder_of_pictures_is_that_subfolder(tmp_path: Path):
    write_picture(tmp_path / "img1" / "000001.png", numbered(1))
    (tmp_path / "gt").mkdir()
    (tmp_path / "gt" / "gt.txt").write_text("1,2,3")
    write_picture(tmp_path / ".thumbnails" / "000001.png", numbered(9))
    assert number_in(open_pictures(tmp_path).read(0)) == 1


def test_several_folders_of_pictures_are_named_and_one_can_be_chosen(tmp_path: Path):
    write_picture(tmp_path / "lwir" / "1.png", numbered(1))
    write_picture(tmp_path / "visible" / "1.png", numbered(2))
    with pytest.raises(MediaError, match=r"pictures in 2 folders \(lwir, visible\); give the"):
        open_pictures(tmp_path)
    assert number_in(open_pictures(tmp_path / "visible").read(0)) == 2


def test_a_single_file_is_pictures(tmp_path: Path):
    single = open_pictures(write_picture(tmp_path / "12.png", numbered(12)))
    assert (single.n, number_in(single.read(0))) == (1, 12)


def test_an_archive_is_read_without_unpacking(tmp_path: Path):
    members = {f"seq/{number}.png": encoded(numbered(number)) for number in (2, 11)}
    path = write_zip(tmp_path / "a.zip", {**members, "__MACOSX/seq/._2.png": b"x", "notes": b"y"})
    pictures = open_pictures(path)
    assert [number_in(pictures.read(index)) for index in (0, 1)] == [2, 11]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.zip"]


@pytest.mark.parametrize("ending", [".png", ".tiff"])
def test_16_bit_grey_levels_come_unchanged(tmp_path: Path, ending: str):
    values = np.arange(48 * 64, dtype=np.uint16).reshape(48, 64) + 6743
    picture = open_pictures(write_picture(tmp_path / f"a{ending}", values)).read(0)
    assert picture.dtype == np.uint16
    np.testing.assert_array_equal(picture, values)


def test_colours_come_as_red_green_blue(tmp_path: Path):
    blue_green_red = np.full((4, 5, 3), (10, 20, 30), np.uint8)
    for content in (encoded(blue_green_red), encoded(np.dstack([blue_green_red, GREY[:4, :5]]))):
        assert decode_image(content, "a.png")[0, 0].tolist() == [30, 20, 10]


def test_temperatures_in_a_tiff_become_16_bit():
    values = np.array([[-10.5, 0.0], [float("nan"), 31.5]], np.float32)
    picture = decode_image(encoded(values, ".tiff"), "a.tiff")
    assert picture.tolist() == [[0, 16383], [163, 65535]]


KELVIN = np.linspace(290, 300, 48 * 64, dtype=np.float32).reshape(48, 64)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 3e38, -9999.0, 0.0])
@pytest.mark.parametrize("where", [np.s_[:, :2], np.s_[3, 5]])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_masked_border_or_a_wrong_pixel_leaves_the_contrast_of_the_others(
    wrong: float, where: Any, kind: type
):
    values = KELVIN.astype(kind)
    values[where] = wrong
    picture = decode_image(encoded(values, ".tiff"), "a.tiff")
    is_right = np.ones(values.shape, bool)
    is_right[where] = False
    right = (KELVIN - 290) / 10 * 65535
    assert np.abs(picture[is_right] - right[is_right]).max() < 65535 * 0.04
    assert (np.abs(picture[where] / 65535 - 0.5) > 0.45).all()
    shown, whole = (
        stretch(decode_image(encoded(v, ".tiff"), "a"), *STRETCH) for v in (values, KELVIN)
    )
    assert np.abs(shown[is_right] - whole[is_right].astype(float)).max() < 255 * 0.04


@pytest.mark.parametrize("mask", [np.nan, -9999.0, 0.0, 65535.0])
@pytest.mark.parametrize("side", [np.s_[:16], np.s_[28:]])
def test_a_mask_over_a_third_of_a_picture_takes_no_contrast(mask: float, side: slice):
    columns = np.tile(np.linspace(290, 300, 64, dtype=np.float32), (48, 1))
    values = columns.copy()
    values[side] = mask
    shown, whole = (
        stretch(decode_image(encoded(v, ".tiff"), "a"), *STRETCH) for v in (values, columns)
    )
    is_right = values == columns
    assert np.abs(shown[is_right] - whole[is_right].astype(float)).max() < 255 * 0.04


@pytest.mark.parametrize("plain", [np.nan, 295.0])
def test_temperatures_without_a_difference_are_a_plain_picture(plain: float):
    values = np.full((48, 64), plain, np.float32)
    assert not decode_image(encoded(values, ".tiff"), "a.tiff").any()


def test_one_wrong_pixel_before_a_plain_background_leaves_the_pedestrian():
    values = np.full((48, 64), 280, np.float32)
    values[10:30, 20:28], values[0, 0] = 305, 3e38
    picture = decode_image(encoded(values, ".tiff"), "a.tiff")
    assert (picture[0, 1], picture[20, 24], picture[0, 0]) == (0, 65535, 65535)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_a_tiff_whose_zero_is_white_is_shown_as_the_positive(kind: type):
    values = np.arange(48 * 64).reshape(48, 64).astype(kind)
    content = encoded(values, ".tif", [cv2.IMWRITE_TIFF_COMPRESSION, 1])
    black = (262).to_bytes(2, "little") + b"\3\0\1\0\0\0" + b"\1"
    assert content.count(black) == 1
    negative = decode_image(content.replace(black, black[:-1] + b"\0"), "a.tif")
    assert (negative == np.iinfo(negative.dtype).max - decode_image(content, "a.tif")).all()


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize(
    ("ending", "kind"),
    [
        ("jpeg", np.uint8),
        ("png", np.uint8),
        *(("tiff", k) for k in (np.uint8, "uint16", "float32")),
    ],
)
def test_a_picture_is_turned_as_its_camera_says(orientation: int, ending: str, kind: str):
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    upright = np.zeros((48, 64), np.uint8)
    upright[:12, :16] = 255  # at the top left
    # as the sensor has it: what `ImageOps.exif_transpose` turns back
    stored = {1: upright, 2: np.fliplr(upright), 3: np.rot90(upright, 2), 4: np.flipud(upright)}
    stored |= {5: upright.T, 6: np.rot90(upright), 7: np.rot90(upright, 2).T}
    stored |= {8: np.rot90(upright, 3)}
    buffer = BytesIO()
    Image.fromarray(stored[orientation].astype(kind)).save(buffer, ending, exif=exif)
    content = buffer.getvalue()
    picture = decode_image(content, "a")
    assert image_size(content, "a") == (64, 48) == picture.shape[1::-1]
    assert (picture[:10, :14] > 200).all()
    assert (picture[14:] < 60).all()


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.int16, np.int32, np.float32, np.float64])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_a_tiff_of_any_kind_of_numbers_is_read_at_the_size_it_states(kind: type, channels: int):
    content = encoded(np.ones((48, 64, channels), kind).squeeze(), ".tif")
    assert image_size(content, "a") == (64, 48) == decode_image(content, "a").shape[1::-1]


def written_by_pillow(ending: str, mode: str, **options: Any) -> bytes:
    buffer = BytesIO()
    Image.new(mode, (64, 48)).save(buffer, ending, **options)
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("ending", "mode", "options"),
    [
        ("png", "1", {}),
        ("png", "P", {"transparency": 0}),
        ("png", "I;16", {}),
        ("jpeg", "L", {"progressive": True}),
        ("jpeg", "RGB", {"comment": "a" * 60_000}),
        ("tiff", "I;16B", {}),
        ("tiff", "RGB", {"compression": "tiff_lzw"}),
        ("tiff", "L", {"save_all": True, "append_images": [Image.new("L", (5, 5))]}),
        ("bmp", "1", {}),
        ("bmp", "RGBA", {}),
    ],
)
def test_sizes_are_those_that_another_program_wrote(ending: str, mode: str, options: dict):
    content = written_by_pillow(ending, mode, **options)
    assert image_size(content, "a") == (64, 48) == decode_image(content, "a").shape[1::-1]


@pytest.mark.parametrize(
    ("width", "height"), [(10_001, 10_000), (32, 65_501), (2**31 - 1, 1), (2**31, 2**31)]
)
def test_absurd_sizes_are_refused_before_decoding(tmp_path: Path, width: int, height: int):
    (tmp_path / "a.png").write_bytes(png_that_claims(width, height))
    with pytest.raises(MediaError, match=rf"a\.png: states a size of {width} x {height} px; at"):
        open_pictures(tmp_path)


def test_an_absurd_bitmap_and_tiff_are_refused_before_decoding():
    bitmap, tiff = bytearray(encoded(GREY, ".bmp")), bytearray(encoded(GREY, ".tif"))
    bitmap[18:26] = (60_000).to_bytes(4, "little") * 2
    at = int.from_bytes(tiff[4:8], "little")
    tags = {bytes(tiff[at + 2 + 12 * n : at + 4 + 12 * n]): at + 2 + 12 * n for n in range(20)}
    for tag in (b"\x00\x01", b"\x01\x01"):
        tiff[tags[tag] + 8 : tags[tag] + 10] = (60_000).to_bytes(2, "little")
    for content in (bitmap, tiff):
        with pytest.raises(MediaError, match="states a size of 60000 x 60000 px"):
            decode_image(bytes(content), "a")


@pytest.mark.parametrize("ending", [".png", ".jpg", ".tif"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_a_picture_that_is_cut_off_is_an_error(ending: str, share: float):
    noise = np.random.default_rng(1).integers(0, 255, (48, 64), dtype=np.uint8)
    content = encoded(noise, ending)
    with pytest.raises(MediaError, match=r"a\.x: the picture (is damaged|cannot be decoded)"):
        decode_image(content[: max(16, int(len(content) * share))], "a.x")


def test_a_part_of_a_png_may_not_be_longer_than_the_file():
    content = encoded(np.zeros((24, 32), np.uint8), ".png")
    data = content.index(b"IDAT") - 4  # its length: the decoder would take so much memory
    stated = content[:data] + (1_900_000_000).to_bytes(4, "big") + content[data + 4 :]
    with pytest.raises(MediaError, match=r"a\.png: the picture is damaged or cut off"):
        decode_image(stated, "a.png")


def test_a_damaged_picture_is_named_and_the_others_are_read(tmp_path: Path):
    for number in (1, 2, 3):
        write_picture(tmp_path / f"{number}.png", numbered(number))
    (tmp_path / "2.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    pictures = open_pictures(tmp_path)
    with pytest.raises(MediaError, match=r"2\.png: the picture is damaged or cut off"):
        pictures.read(1)
    assert number_in(pictures.read(2)) == 3


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"frame,x,y\n1,2,3\n", "is text, not pictures; expected a video"),
        (b"", "is empty"),
        (b"GIF89a" + bytes(40), "is a GIF picture, not pictures"),
        (b"%PDF-1.7", "is a PDF document, not pictures"),
        (b"BM, the maker of pictures", "is text, not pictures"),
    ],
)
def test_what_holds_no_pictures_says_what_it_is(tmp_path: Path, content: bytes, words: str):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(MediaError, match=rf"a\.png: {words}"):
        open_pictures(tmp_path / "a.png")


def test_an_empty_folder_and_a_missing_one_are_errors(tmp_path: Path):
    with pytest.raises(MediaError, match="holds no PNG, JPEG, TIFF or BMP"):
        open_pictures(tmp_path)
    with pytest.raises(MediaError, match="x: there is no such file or folder"):
        open_pictures(tmp_path / "x")
    with pytest.raises(MediaError, match=r"cannot be opened .*too long"):
        open_pictures(tmp_path / ("a" * 300))


def test_a_link_out_of_the_folder_is_noticed(tmp_path: Path):
    inside, outside = tmp_path / "in", tmp_path / "out"
    write_picture(inside / "pictures" / "1.png", numbered(1))
    write_picture(outside / "2.png", numbered(2))
    assert is_below(inside / "pictures", inside)
    assert not is_below(inside / ".." / "out", inside)
    (inside / "pictures" / "2.png").symlink_to(outside / "2.png")
    assert not is_below(inside / "pictures", inside)


def test_a_name_longer_than_any_file_has_lies_where_it_would_lie(tmp_path: Path):
    assert is_below(tmp_path / ("a" * 300), tmp_path)
    assert not is_below(tmp_path / ".." / ("a" * 300), tmp_path)
    assert not is_below(tmp_path / "a\0b", tmp_path)


def test_16_pictures_stay_in_memory(tmp_path: Path):
    paths = [write_picture(tmp_path / f"{number}.png", numbered(number)) for number in range(20)]
    pictures = open_pictures(tmp_path)
    for index in range(20):
        pictures.read(index)
    for path in paths:
        path.unlink()
    assert [number_in(pictures.read(index)) for index in range(4, 20)] == list(range(4, 20))
    with pytest.raises(MediaError, match=r"3\.png: cannot be read \(No such file"):
        pictures.read(3)


@pytest.mark.realdata
def test_a_radiometric_tiff_keeps_its_values(realdata: Path):
    picture = open_pictures(realdata / "thermal/thermal16/example_radiometric.tiff").read(0)
    assert (picture.dtype, int(picture.min()), int(picture.max())) == (np.uint16, 6743, 7077)


def test_a_closed_archive_lets_go_of_its_file(tmp_path: Path):
    pictures = open_pictures(write_zip(tmp_path / "a.zip", {"1.png": encoded(numbered(1))}))
    pictures.close()
    with pytest.raises(MediaError, match="is damaged, or no ZIP archive"):
        pictures.read(0)


def test_another_reader_of_an_archive_leaves_it_open(tmp_path: Path):
    members = {f"{number}.png": encoded(numbered(number)) for number in (1, 2)}
    pictures = open_pictures(write_zip(tmp_path / "a.zip", members))
    other = pictures.another()
    assert number_in(other.read(1)) == 2
    other.close()
    assert number_in(pictures.read(1)) == 2


def test_an_archive_without_pictures_or_with_a_bad_first_one_is_refused(tmp_path: Path):
    with pytest.raises(MediaError, match=r"a\.zip: holds no PNG, JPEG, TIFF or BMP"):
        open_pictures(write_zip(tmp_path / "a.zip", {"gt.txt": b"1"}))
    with pytest.raises(MediaError, match=r"1\.png: is no PNG, JPEG, TIFF or BMP"):
        open_pictures(write_zip(tmp_path / "b.zip", {"1.png": b"1"}))


def test_a_picture_without_pixels_is_refused():
    with pytest.raises(MediaError, match="states a size of 0 x 5 px; it is damaged"):
        decode_image(png_that_claims(0, 5), "a.png")


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("is_packed", [False, True])
def test_each_page_of_a_single_tiff_is_a_picture(tmp_path: Path, kind: type, is_packed: bool):
    pages = [numbered(number).astype(kind) for number in range(9, 20)]
    done, content = cv2.imencodemulti(".tif", pages)
    assert done
    path = tmp_path / "seq.tif"
    path.write_bytes(bytes(content))
    if is_packed:
        path = write_zip(tmp_path / "seq.zip", {"seq.tif": bytes(content)})
    pictures = open_pictures(path)
    assert (pictures.n, pictures.numbers, pictures.file_names([3])) == (11, None, None)
    spread = [stretch(pictures.read(index)) for index in (10, 0, 5)]
    assert [number_in(picture) for picture in spread] == [19, 9, 14]


def test_pages_of_another_size_are_previews_and_no_pictures(tmp_path: Path):
    buffer = BytesIO()
    small = [Image.new("L", (16, 12)), Image.new("L", (8, 6))]
    Image.fromarray(numbered(5)).save(buffer, "tiff", save_all=True, append_images=small)
    (tmp_path / "1.tif").write_bytes(buffer.getvalue())
    pictures = open_pictures(tmp_path)
    assert (pictures.n, number_in(pictures.read(0)), pictures.notes) == (1, 5, ())


@pytest.mark.parametrize("n_previews", [1, 11])
def test_previews_before_the_pages_are_no_pictures(tmp_path: Path, n_previews: int):
    pages = [numbered(number) for number in range(9, 20)]
    for at in range(n_previews):
        pages.insert(2 * at, np.zeros((12, 16), np.uint8))
    done, content = cv2.imencodemulti(".tif", pages)
    assert done
    (tmp_path / "seq.tif").write_bytes(bytes(content))
    pictures = open_pictures(tmp_path / "seq.tif")
    assert [number_in(pictures.read(index)) for index in range(pictures.n)] == [*range(9, 20)]


def test_of_files_of_many_pages_each_shows_its_first_and_that_is_told(tmp_path: Path):
    for number in (1, 2):
        done, content = cv2.imencodemulti(".tif", [numbered(number), numbered(99)])
        assert done
        (tmp_path / f"{number}.tif").write_bytes(bytes(content))
    pictures = open_pictures(tmp_path)
    assert [number_in(pictures.read(index)) for index in (0, 1)] == [1, 2]
    assert pictures.notes == (PictureNote(PictureTrait.FURTHER_PAGES, 1, names=("1.tif",)),)


def test_pages_that_go_round_end(tmp_path: Path):
    content = bytearray(encoded(numbered(5), ".tif"))
    start = int.from_bytes(content[4:8], "little")
    end = start + 2 + 12 * int.from_bytes(content[start : start + 2], "little")
    content[end : end + 4] = content[4:8]  # the page after the first one is the first one
    (tmp_path / "1.tif").write_bytes(content)
    assert open_pictures(tmp_path / "1.tif").n == 1

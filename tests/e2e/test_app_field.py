"""Files as other tools write them, sent in a browser: right values, or what is wrong with them."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import viewer_scene as scene
from app_files import send_annotations
from app_visit import Visit
from field_cases import CASES, SIDES, Case
from playwright.sync_api import expect
from viewer_reading import READER

KEYS = dict(zip(SIDES, ("upload_truth", "upload_system_0", "upload_system_1"), strict=True))
ASKED = {"Width of the pictures (px)": "640", "Height of the pictures (px)": "480"}
SHOWN = ("yolo-names-in-a-list", "visdrone-mot", "yolo-classes-without-names")
MENDED = {"coco-results-as-corners": 102, "half-the-rate": 51}
"""How many boxes Y matches then."""
ROW = "frame,x,y,w,h,track\n"


def send(one: Visit, folder: Path, files: dict[str, tuple[str, bytes]]) -> None:
    """Choose the files of each field, and wait until the page has looked at them."""
    one.open_way("Upload")
    for key, (name, content) in files.items():
        path = folder / key / name
        path.parent.mkdir(parents=True)
        path.write_bytes(content)
        send_annotations(one, key, path)
    # of both systems at least; until then fields for what the files do not say come and go
    expect(one.page.get_by_text(re.compile("^Read as ")).nth(1)).to_be_visible()
    one.wait_until_drawn()


def open_sent(one: Visit, *, fps: str = "10") -> None:
    for label, value in {**ASKED, "Frames per second": fps}.items():
        field = one.page.get_by_role("spinbutton", name=label)
        if field.count():  # the files do not say it
            field.fill(value)
            field.press("Enter")
            one.wait_until_drawn()
            expect(field).to_have_value(value)
    one.page.get_by_role("button", name="Open these files").click()


def matches(one: Visit, x: int, y: int) -> None:
    """Look up how many boxes X and Y match, as set."""
    one.switch_to("Overview")
    one.page.get_by_text(re.compile(r"^All \d+ measures$")).click()
    row = one.page.locator(".nv-all_measures tr", has_text="boxes matched")
    expect(row).to_be_visible()
    as_set = one.page.get_by_role("radio", name="As set")
    if as_set.count():  # else at like operating points
        as_set.click()
    ends = [re.compile(rf"\b{value}$") for value in (x, y, abs(x - y))]
    expect(row.get_by_role("cell")).to_have_text(ends)


def test_files_give_the_right_values_or_say_what_is_wrong(visit, tmp_path: Path):
    for name in SHOWN:
        case: Case = CASES[name]
        one = visit("data")
        send(one, tmp_path / name, {key: case.sent(side) for side, key in KEYS.items()})
        open_sent(one)
        if case.right is None:
            for words in case.says:
                expect(one.page.get_by_text(words).first, name).to_be_visible()
        else:
            expect(one.heading(re.compile("Open now: Uploaded files")), name).to_be_visible()
            matches(one, 60, 102)
            expect(one.keyed("verdict"), name).to_contain_text("40 frames, 4.0 s")
        one.close()


def test_what_the_audit_found_is_mended_by_its_button(visit, tmp_path: Path):
    for name, y in MENDED.items():
        one = visit("data")
        send(one, tmp_path / name, {key: CASES[name].sent(side) for side, key in KEYS.items()})
        open_sent(one)
        expect(one.heading(re.compile("Open now: Uploaded files")), name).to_be_visible()
        apply = one.page.get_by_role(
            "button", name=re.compile("Read boxes as|Apply to the session")
        )
        expect(apply.first, name).to_be_visible()
        for left in range(apply.count() - 1, -1, -1):
            apply.first.click()
            expect(apply, name).to_have_count(left)
            one.wait_until_drawn()
        matches(one, 60, y)
        one.close()


def drive(frames: range, recordings: tuple[str, ...] = ("drive",)) -> bytes:
    """A pedestrian in every one of these frames, seen by everybody."""
    rows = [f"{name},{frame},300,200,40,90,1" for name in recordings for frame in frames]
    return ("recording," + ROW + "\n".join(rows) + "\n").encode()


def pictures(names: dict[str, int]) -> bytes:
    """A ZIP archive of pictures with these names, each with its number drawn."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, number in names.items():
            archive.writestr(name, scene.jpeg_of(number))
    return packed.getvalue()


def paints(one: Visit, number: int) -> None:
    """Wait until the viewer's picture is the one in which this number is drawn."""
    is_painted = f"viewer => ({READER})(viewer).frame === {scene.FIRST_FRAME + number}"
    one.page.wait_for_function(is_painted, arg=one.viewer.element_handle())


def open_with_pictures(one: Visit, path: Path, boxes: bytes, names: dict[str, int]) -> None:
    """Send these boxes for all three and the pictures to this path, and go to the Timeline."""
    by_field = zip(KEYS.values(), ("drive.csv", "fir.csv", "nir.csv"), strict=True)
    send(one, path.parent, {key: (name, boxes) for key, name in by_field})
    path.write_bytes(pictures(names))
    one.keyed("upload_pictures").locator("input[type=file]").set_input_files(path)
    expect(one.page.get_by_text(f"Here: {path.name}")).to_be_visible()
    one.wait_until_drawn()
    open_sent(one, fps="20")
    expect(one.heading(re.compile("Open now: Uploaded files"))).to_be_visible()
    one.switch_to("Timeline")


def shows_own_pictures(one: Visit, frames: range) -> None:
    for key, frame in (("Home", frames[0]), ("ArrowRight", frames[1]), ("End", frames[-1])):
        one.viewer.press(key)
        one.shows(frame)
        paints(one, frame)


def test_where_every_second_frame_has_boxes_each_shows_its_own_picture(visit, tmp_path: Path):
    one, frames = visit("data"), range(0, 24, 2)
    names = {f"frame_{k + 1:04d}.jpg": 2 * k for k in range(12)}
    open_with_pictures(one, tmp_path / "drive.zip", drive(frames), names)
    shows_own_pictures(one, frames)


def test_pictures_are_of_the_recording_that_they_name_less_a_stray_one(visit, tmp_path: Path):
    one, frames = visit("data"), range(12)
    names = {"calib.jpg": 390, **{f"img_{k:05d}.jpg": k for k in frames}}
    boxes = drive(frames, ("drive_1", "drive_10"))
    open_with_pictures(one, tmp_path / "drive_10.zip", boxes, names)
    one.shows(0)
    expect(one.viewer.get_by_text("No pictures: boxes only")).to_be_visible()
    one.recording_field("drive_1").fill("drive_10")
    one.page.get_by_role("option", name="drive_10").click()
    expect(one.recording_field("drive_10")).to_have_count(1)
    one.shows(0)
    expect(one.viewer.get_by_text("No pictures: boxes only")).to_be_hidden()
    shows_own_pictures(one, frames)

"""Files that a person sends, and how: the viewer's made-up scene as truth, two systems, a video."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import av
import cv2
import numpy as np
import viewer_scene as scene
from app_visit import Visit
from playwright.sync_api import expect

RECORDING = "walk"
N_FRAMES = 150
CLIP_FRAMES = 40  # two seconds: clips are watched to their end
SOURCES = ("truth", "camera_a", "camera_b")


class Sent(NamedTuple):
    truth: Path
    x: Path
    y: Path
    video: Path


def write_session(folder: Path, n_frames: int) -> Path:
    """A session file of such files with so many frames; where it is."""
    sent = write_files(folder, n_frames)
    path = folder / "session.toml"
    path.write_text(
        f'[defaults]\nsize = "{scene.WIDTH}x{scene.HEIGHT}"\nfps = {scene.FPS}\n'
        f'[truth]\npath = "{sent.truth.name}"\n'
        f'[[recording]]\nname = "{RECORDING}"\npictures = "{sent.video.name}"\n'
        f'[[system]]\nname = "camera_a"\npath = "{sent.x.name}"\n'
        f'[[system]]\nname = "camera_b"\npath = "{sent.y.name}"\n',
        encoding="utf-8",
    )
    return path


def write_files(folder: Path, n_frames: int = N_FRAMES) -> Sent:
    """Frame f of the recording is row f of the scene, whose picture has its number in it."""
    columns = ("recording,frame,x,y,w,h,track", *["recording,frame,x,y,w,h,score"] * 2)
    tables = [[header] for header in columns]
    for frame in range(n_frames):
        for box in scene.boxes_of(frame):
            if box.source == 0 and box.state & 1:  # an ignore region
                continue
            last = box.track if box.source == 0 else f"{box.score:.2f}"
            tables[box.source].append(f"{RECORDING},{frame},{box.x},{box.y},{box.w},{box.h},{last}")
    paths = [folder / f"{name}.csv" for name in SOURCES]
    for path, lines in zip(paths, tables, strict=True):
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    video = folder / f"{RECORDING}.mp4"
    _write_video(video, n_frames)
    return Sent(*paths, video)


def _write_video(path: Path, n_frames: int) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=int(scene.FPS))
        stream.width, stream.height, stream.pix_fmt = scene.WIDTH, scene.HEIGHT, "yuv420p"
        stream.codec_context.gop_size = 50
        stream.options = {"crf": "23", "preset": "ultrafast"}
        for row in range(n_frames):
            jpeg = np.frombuffer(scene.jpeg_of(row), dtype=np.uint8)
            picture = cv2.imdecode(jpeg, cv2.IMREAD_COLOR_RGB)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))


def send_annotations(one: Visit, key: str, path: Path) -> None:
    """Choose a file in the field with this key, and wait until it has arrived."""
    field = one.keyed(key)
    with one.page.expect_response(re.compile("/_stcore/upload_file/")):
        field.locator("input[type=file]").set_input_files(path)
    expect(field.get_by_text(path.name)).to_be_visible()
    expect(field.get_by_role("progressbar")).to_have_count(0)
    one.wait_until_drawn()


def send(one: Visit, files: Sent) -> None:
    """Upload all files and answer what the app asks."""
    one.open_way("Upload")
    for key, path in (
        ("upload_truth", files.truth), ("upload_system_0", files.x), ("upload_system_1", files.y),
    ):  # fmt: skip
        send_annotations(one, key, path)
    one.keyed("upload_pictures").locator("input[type=file]").set_input_files(files.video)
    expect(one.page.get_by_text(f"Here: {files.video.name}")).to_be_visible()
    # the files say neither size nor frame rate; both are proposed from the video
    rate = one.page.get_by_role("spinbutton", name="Frames per second")
    expect(rate).to_have_value(f"{scene.FPS:g}")
    one.page.get_by_role("button", name="Open these files").click()
    expect(one.heading("Open now: Uploaded files")).to_be_visible()

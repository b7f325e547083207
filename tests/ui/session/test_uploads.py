"""Uploads: harmless names, content checked, limits kept, archives taken apart with care."""

from __future__ import annotations

import asyncio
import io
import zipfile
from collections.abc import AsyncIterator
from http import HTTPStatus
from pathlib import Path, PurePosixPath

import pytest
from builders import at, make_dataset
from sent_files import Sent

from nvcore.common.errors import InputError, MediaError
from nvcore.inputs.readers.meaning.names import NEUTRAL
from nvcore.inputs.session import Session, Source
from ui.session import uploads, workspace
from ui.session.uploads import (
    ANNOTATION_FOLDERS,
    UploadError,
    kind_of,
    new_upload,
    receive,
    remove_pictures,
    store_annotations,
    store_model,
)
from ui.session.workspace import Opened, Workspace
from ui.settings.limits import Limits

PNG = b"\x89PNG\r\n\x1a\n" + bytes(100)


def packed(members: dict[str, bytes], how: int = zipfile.ZIP_DEFLATED) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", how) as archive:
        for name, text in members.items():
            archive.writestr(name, text)
    return content.getvalue()


def send(space: Workspace, name: str, *chunks: bytes, n_bytes: int | None = None):
    async def content() -> AsyncIterator[bytes]:
        for chunk in chunks:
            yield chunk

    return asyncio.run(receive(space, name, content(), n_bytes=n_bytes))


def files_in(folder: Path) -> list[str]:
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())


@pytest.mark.parametrize(
    ("head", "kind"),
    [
        (PNG, "image"),
        (b"\xff\xd8\xff\xe0", "image"),
        (b"II*\x00", "image"),
        (b"\x00\x00\x00\x20ftypisom", "video"),
        (b"RIFF\x00\x00\x00\x00AVI LIST", "video"),
        (b"\x1aE\xdf\xa3", "video"),
        ((b"G" + bytes(187)) * 3, "video"),
        (b"PK\x03\x04", "zip"),
        (b"#EXTM3U\nfile:///etc/passwd", None),
        (b"ffconcat version 1.0", None),
        (b"<svg onload=alert(1)>", None),
        (b"", None),
    ],
)
def test_the_kind_of_a_file_is_told_from_its_content(head: bytes, kind: str | None):
    assert kind_of(head) == kind


def test_a_picture_lands_in_the_sessions_folder_byte_by_byte(space: Workspace):
    pieces = PNG[:50], PNG[50:], *[bytes(300_000)] * 10
    stored = send(space, "a/../frame_0001.png", *pieces)
    assert stored.name == "frame_0001.png"
    assert (space.folder / stored.place).read_bytes() == b"".join(pieces)
    assert space.used_bytes == stored.n_bytes == len(PNG) + 3_000_000


def test_a_text_named_like_a_video_is_refused(space: Workspace):
    with pytest.raises(UploadError, match="neither a video") as caught:
        send(space, "drive.mp4", b"#EXTM3U\nfile:///etc/passwd\n")
    assert caught.value.status == HTTPStatus.UNSUPPORTED_MEDIA_TYPE
    assert files_in(space.folder) == []


@pytest.mark.parametrize(
    ("limit", "value", "message", "status"),
    [
        ("MAX_FILE_BYTES", 50, "larger than", HTTPStatus.REQUEST_ENTITY_TOO_LARGE),
        ("SPARE_BYTES", 1 << 62, "no room left", HTTPStatus.INSUFFICIENT_STORAGE),
    ],
)
def test_a_file_for_which_there_is_no_room_is_refused_before_it_is_read(
    space: Workspace,
    monkeypatch: pytest.MonkeyPatch,
    limit: str,
    value: int,
    message: str,
    status: HTTPStatus,
):
    monkeypatch.setattr(uploads, limit, value)
    with pytest.raises(UploadError, match=message) as caught:
        send(space, "a.png", n_bytes=101)
    assert caught.value.status == status


def test_a_file_that_hides_its_size_is_refused_at_the_cap(
    space: Workspace, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(uploads, "MAX_FILE_BYTES", 250)
    monkeypatch.setattr(uploads, "WRITE_BYTES", 100)
    with pytest.raises(UploadError, match="larger than"):
        send(space, "a.png", PNG, bytes(100), bytes(100))
    assert files_in(space.folder) == []
    assert space.used_bytes == 0


def test_a_session_has_a_quota_in_which_removed_pictures_make_room(
    space: Workspace, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(uploads, "MAX_SESSION_BYTES", 150)
    send(space, "a.png", PNG)
    with pytest.raises(UploadError, match="in all; remove uploads"):
        send(space, "b.png", PNG)
    assert files_in(space.folder) == ["pictures/0/images/a.png"]
    remove_pictures(space, [*space.stored, PurePosixPath("unknown.png")])
    send(space, "b.png", PNG)
    assert files_in(space.folder) == ["pictures/0/images/b.png"]


def test_all_sessions_together_have_a_quota(space: Workspace, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(uploads, "limits_of_environment", lambda: Limits(max_disk_mb=1))
    other = Workspace()
    monkeypatch.setattr(workspace, "_workspaces", {"own": space, "other": other})
    send(other, "a.png", PNG, bytes((1 << 20) - 150))
    with pytest.raises(UploadError, match="holds as many uploads as it may") as caught:
        send(space, "a.png", PNG)
    assert caught.value.status == HTTPStatus.INSUFFICIENT_STORAGE
    other.close()
    monkeypatch.setattr(workspace, "_workspaces", {"own": space})
    send(space, "a.png", PNG)


def test_an_upload_that_is_shorter_than_stated_is_dropped(space: Workspace):
    with pytest.raises(UploadError, match="broke off"):
        send(space, "a.png", PNG, n_bytes=len(PNG) + 1)
    assert files_in(space.folder) == []


def test_two_pictures_of_one_name_are_both_kept(space: Workspace):
    first, second = send(space, "a.png", PNG), send(space, "a.png", PNG[:-1] + b"1")
    assert (first.name, second.name) == ("a.png", "a-2.png")


def test_a_picture_that_is_sent_twice_is_kept_once(space: Workspace):
    assert send(space, "a.png", PNG) == send(space, "a.png", PNG)
    assert files_in(space.folder) == ["pictures/0/images/a.png"]
    assert space.used_bytes == len(PNG)


def test_a_file_has_its_name_in_every_form_that_it_is_sent_in(space: Workspace):
    for number, end in enumerate((b"1", b"2")):
        assert send(space, "a.png", PNG, end).name == "a.png"
        assert space.sent[0] == space.folder / "pictures" / str(number) / "images"
        assert (space.sent[0] / "a.png").read_bytes() == PNG + end
        space.form += 1
    remove_pictures(space, [*space.stored])
    assert files_in(space.folder) == []


def stored_paths(space: Workspace, *files: Sent) -> tuple[str, ...]:
    return store_annotations(space, new_upload(space), "truth", files)


def test_annotations_keep_their_names_below_the_folder_of_their_source(space: Workspace):
    first, second = stored_paths(space, Sent("../set00_V000.csv"), Sent("set00_V000.csv"))
    assert first == "truth/annotations/data/set00_V000.csv"
    assert Path(second).name == "set00_V000-2.csv"
    assert set(ANNOTATION_FOLDERS.parts) <= NEUTRAL  # and are taken for no recording


def test_an_archive_is_unpacked_and_its_folders_stay(space: Workspace):
    members = {"mot/A/gt/gt.txt": b"1", "mot/B/gt/gt.txt": b"2"}
    (path,) = stored_paths(space, Sent("mot15.zip", packed(members)))
    (folder,) = space.folder.glob(f"*/{path}")
    assert files_in(folder) == ["A/gt/gt.txt", "B/gt/gt.txt"]
    # that of one recording has its name
    (path,) = stored_paths(space, Sent("truth.zip", packed({"TUD-Campus/gt/gt.txt": b"1"})))
    assert Path(path).name == "TUD-Campus"


def test_forms_and_archives_beyond_the_quota_are_refused_by_the_name_of_the_file(
    space: Workspace, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(uploads, "MAX_SESSION_BYTES", 5000)
    with pytest.raises(MediaError, match="at most"):
        stored_paths(space, Sent("a.zip", packed({"truth.csv": bytes(range(256)) * 40})))
    with pytest.raises(UploadError, match=r"^gt\.txt: A session takes"):
        stored_paths(space, Sent("gt.txt", bytes(5001)))


def test_a_new_form_removes_the_files_of_those_that_did_not_open(space: Workspace):
    old = new_upload(space)
    store_annotations(space, old, "truth", [Sent("a.csv", b"12345")])
    assert space.used_bytes == 5
    new_upload(space)
    assert not old.exists()
    assert space.used_bytes == 0


@pytest.mark.parametrize(
    "content",
    [
        b"PK\x03\x04" + bytes(500),
        packed({"a.csv": b"1" * 90, "../b.csv": b"1"}),
        # breaks while it is unpacked
        packed({"a.csv": b"1", "b.csv": b"no sum"}, zipfile.ZIP_STORED).replace(b"no", b"NO"),
    ],
    ids=["damaged", "leaves its folder", "wrong checksum"],
)
def test_nothing_stays_of_an_archive_that_is_refused(space: Workspace, content: bytes):
    folder = new_upload(space)
    files = [Sent("a.csv", b"12345"), Sent("b.zip", content)]
    with pytest.raises(MediaError):
        store_annotations(space, folder, "truth", files)
    assert files_in(folder) == ["truth/annotations/data/a.csv"]
    assert space.used_bytes == 5
    new_upload(space)
    assert space.used_bytes == 0


def test_what_was_not_counted_makes_no_room(space: Workspace):
    folder = new_upload(space)
    store_annotations(space, folder, "truth", [Sent("a.zip", packed({"a.csv": b"1" * 90}))])
    assert space.used_bytes == 90
    (folder / "made-by-the-app.toml").write_bytes(bytes(500))
    new_upload(space)
    assert space.used_bytes == 0


def test_the_files_of_the_open_comparison_stay_counted(space: Workspace):
    folder = new_upload(space)
    paths = store_annotations(space, folder, "truth", [Sent("a.csv", b"12345")])
    dataset = make_dataset(truth=[at(0, 50)])
    space.opened = Opened.of(Session(folder, Source(paths), ()), dataset, "uploads")
    new_upload(space)
    assert space.used_bytes == 5
    space.opened = None
    new_upload(space)
    assert space.used_bytes == 0


def test_a_model_takes_the_place_of_the_one_before_and_of_its_bytes(space: Workspace):
    first = store_model(space, Sent("../one.npz", b"PK\3\4 no archive to unpack"), "detector", str)
    assert (first.name, space.used_bytes) == ("one.npz", 25)
    second = store_model(space, Sent("two.npz", b"1234"), "detector", str)
    assert not first.exists()
    assert second.read_bytes() == b"1234"
    assert space.used_bytes == 4


def test_a_model_that_is_refused_leaves_the_one_before(
    space: Workspace, monkeypatch: pytest.MonkeyPatch
):
    def refuse(path: Path) -> None:
        raise InputError("is no model", file=path.name)

    first = store_model(space, Sent("one.npz", b"1234"), "detector", str)
    with pytest.raises(InputError, match=r"two\.npz: is no model"):
        store_model(space, Sent("two.npz", b"12345678"), "detector", refuse)
    monkeypatch.setattr(uploads, "MAX_SESSION_BYTES", 8)
    with pytest.raises(UploadError, match="A session takes"):
        store_model(space, Sent("three.npz", b"12345678"), "detector", str)
    assert first.read_bytes() == b"1234"
    assert space.used_bytes == 4
    assert len([*space.folder.glob("model-detector-*")]) == 1

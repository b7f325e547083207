"""Open a recording's images or video, detecting the container from its content."""

from __future__ import annotations

import glob
import os
from pathlib import Path

from nvcore.common.errors import MediaError
from nvcore.common.file_kinds import as_stored, binary_kind
from nvcore.common.wording import one_line
from nvcore.pictures.base import Pictures
from nvcore.pictures.containers import video_format
from nvcore.pictures.header import is_image
from nvcore.pictures.images import Images, archive_as_pictures, file_bytes, folder_as_pictures
from nvcore.pictures.series import series_of
from nvcore.pictures.video import Video


def open_pictures(path: Path) -> Pictures:
    """Open the pictures of one recording.

    Parameters
    ----------
    path
        A video, a folder of pictures, a ZIP archive of pictures, or one picture. The last part may
        be a pattern of names in a folder or archive, such as ``*.png``.

    Raises
    ------
    MediaError
        If it holds no pictures that can be read. Says what to do.
    """
    path = as_stored(path)
    name = one_line(path.name)
    try:
        is_folder, is_file = path.is_dir(), path.is_file()
    except OSError as error:  # a name that is too long, a folder that may not be looked into
        raise MediaError(f"cannot be opened ({error.strerror})", file=name) from error
    if is_folder:
        return folder_as_pictures(path)
    if not is_file:
        if glob.has_magic(path.name) and path.parent.is_dir():
            return folder_as_pictures(path.parent, path.name)
        if glob.has_magic(path.name) and path.parent.is_file():
            return archive_as_pictures(path.parent, path.name)
        raise MediaError("there is no such file or folder of pictures", file=name)
    try:
        with path.open("rb") as file:
            content = file.read(4096)
    except OSError as error:
        raise MediaError(f"cannot be opened ({error.strerror})", file=name) from error
    if content.startswith((b"PK\3\4", b"PK\5\6")):
        return archive_as_pictures(path)
    if is_image(content):
        return Images(name, series_of([path.name], name), lambda _: file_bytes(path))
    if container_format := video_format(content):
        return Video(path, container_format)
    if not content:
        raise MediaError("is empty", file=name)
    kind = (binary_kind(content) or "text").partition(":")[0]
    raise MediaError(
        f"is {kind}, not pictures; expected a video (MP4, MOV, Matroska, WebM, AVI, MPEG), PNG, "
        "JPEG, TIFF or BMP, or a ZIP archive or folder of these",
        file=name,
    )


def is_below(path: Path, root: Path) -> bool:
    """Whether a path and all that it holds lie in a folder, links followed.

    For places where people may look at one folder only, as pictures there may be links. A name
    that no file can have (too long, with a NUL) lies where it would lie, or nowhere.
    """
    real_root = os.path.realpath(root)

    def lies_below(inner: str | Path) -> bool:
        try:
            return Path(os.path.realpath(inner)).is_relative_to(real_root)
        except ValueError:  # NUL
            return False

    if not lies_below(path):
        return False
    return not os.path.isdir(path) or all(  # noqa: PTH112  # Path.is_dir refuses long names
        lies_below(Path(folder) / name)
        for folder, folders, files in os.walk(path)
        for name in (*folders, *files)
    )

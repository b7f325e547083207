"""Names of pictures without what tools add to them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from itertools import takewhile
from typing import Final

from nvcore.file_kinds import unpacked_name

_PICTURE: Final = "jpe?g|png|bmp|tiff?|webp|avif|heic|ppm|pgm"
_VIDEO: Final = "mp4|avi|mov|mkv|webm|m4v|mpe?g|wmv|ts"
_ENDINGS = re.compile(
    rf"(?:\.(?:{_PICTURE}))?\.(?:txt|xml|json|csv|tsv|gz|{_PICTURE})$|\.[A-Za-z]{{2,4}}$",
    re.IGNORECASE,
)
_ROBOFLOW = re.compile(
    rf"(?:(?:[_\-.](?:{_PICTURE}))*\.rf\.[0-9A-Za-z_\-]{{6,}}|(?<=\d)[_\-](?:{_PICTURE}))$",
    re.IGNORECASE,
)
"""``drive_mp4-0031_jpg.rf.0123456789abcdef0123456789abcdef``; or a shorter id."""
_COPY = re.compile(
    r"(?<=\d)(?: ?\(\d{1,2}\)| ?- ?(?:Copy|Kopie)(?: ?\(\d+\))?|[ _]copy)$", re.IGNORECASE
)
_KIND = re.compile(
    r"(?<=\d)"
    r"(?:[_\-.](?:leftImg8bit(?:_\w+)?|gt(?:Fine|Coarse|Bbox)\w*|lwir|visible|rgb|thermal))+$",
    re.IGNORECASE,
)
"""Cityscapes' and the cameras' words, on one side often and on the other not."""
_SIZE = re.compile(r"(?<=\d)[_\-]\d{3,4}x\d{3,4}$")
"""Of a picture that was written in another size: ``frame_0012_640x480``."""
_OF_VIDEO = re.compile(rf"[_.](?:{_VIDEO})(?=[-_. ]?(?:frame|f)?[-_. ]?\d+$)", re.IGNORECASE)
_FLIR = re.compile(r"(?:^|.*/)video-(?P<video>[^/]+?)-frame-(?P<frame>\d+)(?:[-.][^/]*)?$")
_WORDS = re.compile(r"(?:[_\-. ][A-Za-z]+\d{0,2}[A-Za-z]*)+|[A-Za-z]+")
"""What may be a common ending: ``_det``, ``.left_eye``, ``_cam2``; never ``_I00019``."""
_LABEL_STUDIO = re.compile(r"^[0-9a-f]{8}-(?=.*\d)")
MIN_NAMES: Final = 4
"""Names from which on a common ending with a number of its own is one."""


@lru_cache(maxsize=1 << 15)  # each list of pictures is gone through several times
def plain_name(name: str) -> str:
    """Folders and stem of a picture's name, without what tools add to it.

    Examples
    --------
    >>> plain_name("labels/drive_mp4-0031_jpg.rf.0123456789abcdef0123456789abcdef.txt")
    'labels/drive-0031'
    >>> plain_name("video-BzZs-frame-000123-Xk9.jpg"), plain_name("V000/I00019_lwir.png")
    ('BzZs/000123', 'V000/I00019')
    """
    name = unpacked_name(name.replace("\\", "/"))
    flir = _FLIR.match(name)
    if flir is not None:
        return f"{flir['video']}/{flir['frame']}"
    folders, slash, last = name.rpartition("/")
    stem, before = _ENDINGS.sub("", last), ""
    while stem != before:  # of pictures exported twice each time once more
        before = stem
        for added in (_ROBOFLOW, _COPY, _KIND, _SIZE):
            stem = added.sub("", stem) or stem
    return folders + slash + _OF_VIDEO.sub("", stem)


def plain_names(names: Sequence[str]) -> tuple[list[str], str]:
    """`plain_name` of each, without the ending that all of them share, and that ending."""
    plain = [name if name.isdecimal() else plain_name(name) for name in names]
    if len(plain) > 1 and all(map(_LABEL_STUDIO.match, (_last(name) for name in plain))):
        starts = {_last(name)[:8] for name in plain}
        if len(starts) > len(plain) / 2:  # not a date
            plain = [_with_last(name, _last(name)[9:]) for name in plain]
    taken = _common_ending({_last(name) for name in plain})
    return ([name[: -len(taken)] for name in plain] if taken else plain), taken


def _common_ending(stems: set[str]) -> str:
    """The last words of the names, where all end in them and a number stands before them."""
    if len(stems) < 2:
        return ""
    shared = _shared_start([stem[::-1] for stem in stems])[::-1]
    for start in range(len(shared)):  # the longest first
        words = shared[start:]
        has_number = any(map(str.isdecimal, words))
        if (
            _WORDS.fullmatch(words)
            and all(stem[: -len(words)][-1:].isdecimal() for stem in stems)
            and (not has_number or len(stems) >= MIN_NAMES)
        ):
            return words
    return ""


def _shared_start(texts: Sequence[str]) -> str:
    low, high = min(texts, default=""), max(texts, default="")
    same = takewhile(lambda signs: signs[0] == signs[1], zip(low, high, strict=False))
    return low[: sum(1 for _ in same)]


def common_beginning(stems: Sequence[str]) -> str:
    """What all stems begin with, up to the first number that differs."""
    return _shared_start(stems).rstrip("0123456789")


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _with_last(name: str, last: str) -> str:
    folders, slash, _ = name.rpartition("/")
    return folders + slash + last

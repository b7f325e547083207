"""What kind of file it is that no reader recognises, by its first bytes: for helpful errors."""

from __future__ import annotations

import json
import re
from typing import Final

from nvcore.inputs.readers.base import Role, SourceFile
from nvcore.inputs.readers.parse.json import read_json
from nvcore.inputs.readers.parse.xml import DECLARES

_MAX_KEYS: Final = 8
"""How many keys of a JSON file are named."""
_MAX_JSON_BYTES: Final = 1 << 28
"""A larger JSON file is not parsed only to name its keys."""
_ROOT: Final = re.compile(r"<([A-Za-z_][\w.:-]{0,60})")
_EXPECTED: Final[dict[Role, tuple[str, str]]] = {
    "truth": (
        "a COCO object with the lists 'images', 'annotations' and 'categories'",
        "<annotations> (CVAT) or <annotation> (Pascal VOC)",
    ),
    "detections": (
        "a list of COCO results, each with 'image_id', 'bbox' and 'score'",
        "<annotations> (CVAT) or <annotation> (Pascal VOC)",
    ),
}
"""By role: what JSON and what XML is expected to be."""


def describe_foreign(file: SourceFile, head: str, role: Role) -> str | None:
    """What a file of JSON or XML is, and what was expected instead; None for any other text.

    Parameters
    ----------
    file
        The file.
    head
        Its beginning as text.
    role
        What it should hold.

    Raises
    ------
    FormatError
        If it begins as JSON does, but is none.
    """
    text = head.lstrip("\ufeff \t\r\n")
    as_json, as_xml = _EXPECTED[role]
    if text.startswith(("{", "[")):
        if file.is_larger_than(_MAX_JSON_BYTES):
            return f"JSON of another kind; expected {as_json}"
        return f"{_json_kind(read_json(file))}; expected {as_json}"
    if text.startswith("<"):
        return _xml_kind(text, as_xml)
    return None


def _xml_kind(text: str, expected: str) -> str:
    if "<!DOCTYPE" in text:
        return f"XML that {DECLARES}"
    # the root element comes behind the declaration and comments
    root = _ROOT.search(re.sub(r"<!--.*?-->|<[?!][^>]*>", "", text, flags=re.DOTALL))
    if root is not None and root[1] == "annotations":  # a single annotation is always recognised
        return "XML with the root <annotations>, without the <track> or <image> of CVAT"
    kind = f"XML with the root <{root[1]}>" if root else "XML"
    return f"{kind}; expected {expected}"


def _json_kind(document: object) -> str:
    if isinstance(document, dict):
        return f"a JSON object {_keys(document)}"
    assert isinstance(document, list), "the text begins with a bracket"
    if document and isinstance(document[0], dict):
        return f"a JSON list of objects {_keys(document[0])}"
    return "a JSON list without objects"


def _keys(document: dict[str, object]) -> str:
    if not document:
        return "without keys"
    names = [json.dumps(key[:40], ensure_ascii=False) for key in [*document][:_MAX_KEYS]]
    more = len(document) - len(names)
    return f"with the keys {', '.join(names)}" + (f" and {more} more" if more else "")

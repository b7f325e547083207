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


_MARKS: Final = (
    ("CrowdHuman's .odgt", '"gtboxes"'),
    ("Label Studio's JSON", '"(?:rectanglelabels|from_name)"'),
    ("labelme's JSON", '"shapes".*"image(?:Path|Data|Height)"'),
    ("BDD100K's or Scalabel's JSON", '"box2d"'),
    ("EuroCity Persons' JSON", '"imagename".*"children"|"children".*"imagename"'),
    ("OpenLABEL or VCD", r'\A.{0,5}"(?:openlabel|vcd)"'),
    ("FiftyOne's JSON", '"_cls"|"samples".*"filepath"'),
    ("Supervisely's JSON", '"(?:geometryType|classTitle)"'),
    ("Datumaro's JSON", r'"categories"\s*:\s*\{'),
    ("VGG Image Annotator's (VIA) JSON", '"shape_attributes"|"_via_'),
    ("Cityscapes' or CityPersons' JSON", '"imgHeight"'),
    ("a table of nuScenes", '"(?:sample|instance)_token"'),
    ("Labelbox's JSON", '"(?:data_row|Labeled Data)"'),
    ("Create ML's JSON", r'"coordinates"\s*:\s*\{'),
    ("Darknet's JSON", '"relative_coordinates"'),
    ("supervision's JSON (JSONSink)", r'\A\[\s*\{\s*"x_min"'),
    ("Ultralytics' JSON of one picture", r'\A\[\s*\{\s*"name".*"box"\s*:\s*\{'),
    ("Open Images' tree of classes", r'"LabelName".*"Subcategory"'),
    ("LabelMe's XML", r"<imagesize>|<polygon>(?!.*<bndbox>)"),
    ("COCO results with masks and without boxes", r'\A\s*\[(?!.*"bbox").*"segmentation"'),
    ("CVML's XML (PETS)", r"<dataset\b.*<objectlist"),
    ("UA-DETRAC's XML", r"<target_list"),
    ("ViPER's XML", r"<viper\b"),
    ("VATIC's text", r'\A(?:-?[\d.]+ ){9}"'),
    ("keras-retinanet's CSV", r"\A[^,\n]*\.(?:jpe?g|png|bmp|tiff?),(?:-?[\d.]*,){4}"),
    ("VGG Image Annotator's (VIA) CSV", r"\A#?\s*filename,file_size,file_attributes"),
    ("Label Studio's CSV", r"\A(?=.*annotation_id).*lead_time"),
    ("Ultralytics' CSV without names of pictures", r"\Aname,class,confidence,box"),
    ("Open Images' CSV", r"\AImageID,Source,LabelName,"),
    ("Oxford Town Centre's CSV", r"\A(?:-?[\d.]+,){2}[01],[01],(?:-?[\d.]+,){7}-?[\d.]+\s*$"),
    (
        "text of a class and corners for each picture (Cartucho's mAP)",
        r"\A(?=.*[A-Za-z])[^\s<{\[,;]+(?: [01]?\.\d+(?:[eE]-\d+)?)?(?: -?\d+(?:\.\d+)?){4}\s*$",
    ),
    (
        "Pascal VOC's results: picture, score, corners",
        r"\A[^\s<{\[,;]+ (?:[01]|[01]?\.\d+(?:[eE]-\d+)?)(?: -?\d+(?:\.\d+)?){4}\s*$",
    ),
)
"""Formats that are not read, and what marks the beginning of their files."""
_KNOWN: Final = tuple((name, re.compile(mark, re.DOTALL | re.MULTILINE)) for name, mark in _MARKS)


def foreign_format(head: str) -> str | None:
    """Name of the format that a file is of and that no reader reads; None where it is unknown."""
    text = head.lstrip("\ufeff \t\r\n").replace("\r\n", "\n")
    is_structured = text.startswith(("{", "[", "<"))
    first = text if is_structured else text.partition("\n")[0]
    return next((name for name, mark in _KNOWN if mark.search(first)), None)


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

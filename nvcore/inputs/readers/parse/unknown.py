"""Identify files that no reader recognises by their beginning, for helpful errors."""

from __future__ import annotations

import json
import re
from typing import Final

from nvcore.inputs.readers.base import Role, SourceFile
from nvcore.inputs.readers.parse.json import read_json
from nvcore.inputs.readers.parse.xml import DECLARES

_MAX_KEYS: Final = 8
"""Number of keys of a JSON file in messages."""
_MAX_JSON_BYTES: Final = 1 << 28
"""Largest JSON file that is parsed to name its keys."""
_ROOT: Final = re.compile(r"<([A-Za-z_][\w.:-]{0,60})")
_EXPECTED: Final[dict[Role, str]] = {
    "truth": "a COCO object with the lists 'images', 'annotations' and 'categories'",
    "detections": "a list of COCO results, each with 'image_id', 'bbox' and 'score'",
}
"""Expected kinds of JSON, by role."""
_COCO: Final = "export COCO instead"
_FOREIGN: Final[tuple[tuple[str, str, str], ...]] = (
    ('"gtboxes"', "CrowdHuman's .odgt", "convert it to COCO"),
    ('"(?:rectanglelabels|from_name)"', "Label Studio's JSON", _COCO),
    ('"imageData"|"shape_type"', "labelme's JSON", "convert it to COCO"),
    (r'\A(?=.*"shapes").*"imagePath"', "labelme's JSON", "convert it to COCO"),
    ('"box2d"', "BDD100K's or Scalabel's JSON", "let Scalabel convert it to COCO"),
    (r'\A(?=.*"imagename").*"children"', "EuroCity Persons' JSON", ""),
    (r'\A.{0,5}"(?:openlabel|vcd)"', "OpenLABEL or VCD", ""),
    (
        r'"_cls"|\A(?=.*"samples").*"filepath"',
        "FiftyOne's JSON",
        "export a COCODetectionDataset instead",
    ),
    ('"(?:geometryType|classTitle)"', "Supervisely's JSON", _COCO),
    (r'"categories"\s*:\s*\{', "Datumaro's JSON", _COCO),
    ('"shape_attributes"|"_via_', "VGG Image Annotator's (VIA) JSON", _COCO),
    (r'\A(?=.*"imgHeight").*"objects"', "Cityscapes' or CityPersons' JSON", ""),
    (r'\A\[.*"(?:sample|instance)_token"', "a table of nuScenes", ""),
    ('"(?:data_row|Labeled Data)"', "Labelbox's JSON", "convert it to COCO"),
    (r'\A\[.*"coordinates"\s*:\s*\{', "Create ML's JSON", _COCO),
    ('"relative_coordinates"', "Darknet's JSON", ""),
    ('"workview_url"|"schema_ref"', "V7 Darwin's JSON", _COCO),
    (r'"bounding_box"\s*:\s*\{\s*"h"', "V7 Darwin's JSON", _COCO),
    (
        r'"detection_categories"|"max_detection_conf"|"detections"\s*:\s*\[[^]]{0,200}"conf"',
        "MegaDetector's JSON",
        "convert it to COCO: its boxes are shares of the picture",
    ),
    ('"source-ref"', "a manifest of SageMaker Ground Truth", "convert it to COCO"),
    ('"confidencePairs"', "DIVE's JSON", "export COCO or plain CSV instead"),
    ('"(?:objectHash|featureHash)"', "Encord's JSON", _COCO),
    ('"pointLabels"', "SuperAnnotate's JSON", _COCO),
    ('"imageGcsUri"', "Vertex AI's JSON lines", "convert them to COCO"),
    (r'\A\[\s*\{\s*"x_min"', "supervision's JSON (JSONSink)", "write its CSVSink instead"),
    (
        r'\A\[\s*\{\s*"name".*"box"\s*:\s*\{',
        "Ultralytics' JSON of one picture",
        "write YOLO text (save_txt with save_conf) instead",
    ),
    (r'\A(?=.*"LabelName").*"Subcategory"', "Open Images' tree of classes", ""),
    (r"<imagesize>|\A(?!.*<bndbox>).*<polygon>", "LabelMe's XML", "convert it to COCO"),
    (
        r'\A\s*\[(?!.*"bbox").*"segmentation"',
        "COCO results with masks and without boxes",
        "add the box around each mask",
    ),
    (r"\A(?=.*<dataset\b).*<objectlist", "CVML's XML (PETS)", ""),
    (r"<target_list", "UA-DETRAC's XML", ""),
    (r"<viper\b", "ViPER's XML", ""),
    (r"<tracklets\b", "KITTI's tracklets of laser scans", "take its tracking labels instead"),
    (r'\A(?:-?[\d.]+ ){9}"', "VATIC's text", ""),
    (r"\A[^,\n]*\.(?:jpe?g|png|bmp|tiff?),(?:-?[\d.]*,){4}", "keras-retinanet's CSV", ""),
    (r"\A#?\s*filename,file_size,file_attributes", "VGG Image Annotator's (VIA) CSV", _COCO),
    (r"\A(?=.*annotation_id).*lead_time", "Label Studio's CSV", _COCO),
    (
        r"\Aname,class,confidence,box",
        "Ultralytics' CSV without names of pictures",
        "write YOLO text (save_txt with save_conf) instead",
    ),
    (r"\AImageID,Source,LabelName,", "Open Images' CSV", ""),
    (r"\A(?:-?[\d.]+,){2}[01],[01],(?:-?[\d.]+,){7}-?[\d.]+\s*$", "Oxford Town Centre's CSV", ""),
    (
        r"\A# ?1: Detection or Track|\A(?:#.*\n)*\d+,[^,\n]*,\d+(?:,-?[\d.]+){6},[A-Za-z]",
        "VIAME's CSV (DIVE)",
        "export COCO or plain CSV instead",
    ),
    (
        r"\A.*\[(?:Camera|LiDAR)\w*BoxComponent\]",
        "a table of the Waymo Open Dataset",
        "keep the rows of one camera and call the columns frame, cx, cy, w, h, class",
    ),
    (
        r"\A\S+\.jpg\n\d+\n(?:-?\d+ ){9}-?\d+ ?$",
        "WIDER FACE's text (wider_face_split)",
        "convert it to COCO",
    ),
    (
        r"\A\S+ \d+ 0\.0 0 0\.0(?: -?[\d.]+){4}(?: 0\.0){7}(?: \S+)?$",
        "text of DeepStream's tracker (kitti-track-output-dir), with an id behind the class",
        "take its detections (gie-kitti-output-dir) instead",
    ),
    (
        r"\A(?=.*[A-Za-z])[^\s<{\[,;]+(?: [01]?\.\d+(?:[eE]-\d+)?)?(?: -?\d+(?:\.\d+)?){4}\s*$",
        "text of a class and corners for each picture (Cartucho's mAP)",
        "",
    ),
    (
        r"\A[^\s<{\[,;]+ (?:[01]|[01]?\.\d+(?:[eE]-\d+)?)(?: -?\d+(?:\.\d+)?){4}\s*$",
        "Pascal VOC's results: picture, score, corners",
        "",
    ),
)
"""Unsupported formats: pattern of the beginning of a file, name, and advice.

A dot in a pattern matches a line end in JSON and XML, but not in other text.
"""


def foreign_format(head: str) -> str | None:
    """Name the format of an unsupported file, with advice, or return None if it is unknown."""
    text = head.lstrip("\ufeff \t\r\n").replace("\r\n", "\n")
    flags = re.DOTALL if text.startswith(("{", "[", "<")) else re.MULTILINE
    for mark, name, instead in _FOREIGN:
        if re.search(mark, text, flags):
            return f"{name}, which is not read" + (f": {instead}" if instead else "")
    return None


def describe_foreign(file: SourceFile, head: str, role: Role) -> str | None:
    """Describe the kind of a JSON or XML file and the expected kind, or return None.

    Parameters
    ----------
    file
        The file.
    head
        Its beginning as text.
    role
        Role that it should have.

    Raises
    ------
    FormatError
        If it begins like JSON but is invalid.
    """
    text = head.lstrip("\ufeff \t\r\n")
    if text.startswith(("{", "[")):
        is_large = file.is_larger_than(_MAX_JSON_BYTES)
        kind = "JSON of another kind" if is_large else _json_kind(read_json(file))
        return f"{kind}; expected {_EXPECTED[role]}"
    return _xml_kind(text) if text.startswith("<") else None


def _xml_kind(text: str) -> str:
    if "<!DOCTYPE" in text:
        return f"XML that {DECLARES}"
    # the root element follows the declaration and comments
    root = _ROOT.search(re.sub(r"<!--.*?-->|<[?!][^>]*>", "", text, flags=re.DOTALL))
    if root is not None and root[1] == "annotations":  # a single annotation is always recognised
        return "XML with the root <annotations>, without the <track> or <image> of CVAT"
    kind = f"XML with the root <{root[1]}>" if root else "XML"
    return f"{kind}; expected <annotations> (CVAT) or <annotation> (Pascal VOC)"


def _json_kind(document: object) -> str:
    kind, first = "a JSON object", document
    if isinstance(document, list):
        kind, first = "a JSON list of objects", next(iter(document), None)
    if not isinstance(first, dict):
        return "a JSON list without objects"
    names = [json.dumps(key[:40], ensure_ascii=False) for key in [*first][:_MAX_KEYS]]
    more = f" and {len(first) - len(names)} more" if len(first) > len(names) else ""
    return f"{kind} with the keys {', '.join(names)}{more}" if first else f"{kind} without keys"

"""COCO ground truth (JSON), with the fields of KAIST, Teledyne FLIR, NightOwls, CityPersons."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.errors import FormatError
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    concat_boxes,
    reading_boxes,
    recordings_table,
    rows_finding,
)
from nvcore.inputs.readers.coco.images import (
    ImageList,
    id_text,
    image_ids,
    places_of_rows,
    read_images,
    rows_by_id,
)
from nvcore.inputs.readers.meaning.categories import CategoryChoice, choose_categories
from nvcore.inputs.readers.meaning.occlusion import (
    levels_of_numbers,
    levels_of_visible_share,
    odd_levels,
)
from nvcore.inputs.readers.meaning.tracks import TEXT_IDS, track_numbers
from nvcore.inputs.readers.parse.json import Records, read_json, short_json
from nvcore.schema import NO_TRACK, UNKNOWN_OCCLUSION

TRACK_KEYS = ("track_id", "target_id", "instance_id", "tracking_id")
_LIST = re.compile(r'"(?:images|annotations|categories)"\s*:\s*\[')
_VISIBLE_IF_OCCLUDED = 0.5  # NightOwls' own reading of its yes-or-no field


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the text is a JSON object with COCO's lists."""
    del name
    text = head.lstrip("\ufeff \t\r\n")
    return role == "truth" and text.startswith("{") and _LIST.search(text) is not None


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read COCO ground truth; each file brings its own images, ids and categories.

    Raises
    ------
    FormatError
        With file and record of the first thing that is not COCO, or is not clear.
    """
    tables, images = [], []
    rows: list[dict[str, object]] = []
    facts: list[str] = ["boxes as they are (0-based)"]
    findings: list[Finding] = []
    for number, file in enumerate(files):
        document = read_json(file)
        if not isinstance(document, dict):
            raise FormatError(
                "expected a JSON object with images, annotations and categories, found "
                f"{short_json(document)}; a list of results is no ground truth",
                file=file.name,
            )
        listed = read_images(document, file)
        boxes, what, oddities = _read_annotations(document, file, number, listed, options)
        tables.append(boxes)
        rows += listed.recordings
        images.append(listed.table)
        facts += [fact for fact in (listed.conversion, *what) if fact not in facts]
        findings += [*listed.findings, *oddities]
    facts.append("evaluated frames from the image list")
    return Reading(
        boxes=concat_boxes(tables),
        recordings=recordings_table(rows),
        conversion="; ".join(facts),
        images=_all_images(images, files),
        findings=tuple(findings),
    )


def _all_images(images: list[pd.DataFrame], files: Sequence[SourceFile]) -> pd.DataFrame | None:
    if not images:
        return None
    table = pd.concat(images, ignore_index=True)
    double = table.duplicated(["recording", "frame"])
    if double.any():
        first = table[double].iloc[0]
        owner = np.repeat(np.arange(len(images)), [len(part) for part in images])
        raise FormatError(
            f"frame {first['frame']} of recording {first['recording']!r} is in an earlier file "
            "too; expected each frame in one file",
            file=files[int(owner[int(np.argmax(double))])].name,
        )
    return table


def _read_annotations(
    document: dict[str, object],
    file: SourceFile,
    number: int,
    listed: ImageList,
    options: ReadOptions,
) -> tuple[pd.DataFrame, list[str], list[Finding]]:
    records = Records(document.get("annotations"), file, "annotation", "annotations")
    choice, keys = _classes(document, records, file, options)
    facts = [choice.conversion] if choice is not None else ["no categories: all annotations count"]
    if not len(records):
        return reading_boxes(0), facts, []
    box = records.boxes()
    row = rows_by_id(image_ids(records, "image_id"), listed.table["image_id"])
    recording, frame, is_known = places_of_rows(listed.table, row)
    ignore = records.flags("ignore", "iscrowd")
    facts.append("ignore and iscrowd = ignore")
    is_left_out = np.zeros(len(records), dtype=bool)
    if choice is not None:
        ignore |= keys.isin(choice.ignored).to_numpy()
        is_left_out = keys.isin(choice.left_out).to_numpy()
    track, has_text = _tracks(records, recording)
    facts += [TEXT_IDS] if has_text else []
    occlusion, how, findings = _occlusion(records)
    facts += how
    distance = records.numbers("distance_m", "distance")
    boxes = reading_boxes(
        len(records),
        recording=recording,
        frame=frame,
        x=box[:, 0],
        y=box[:, 1],
        w=box[:, 2],
        h=box[:, 3],
        track=track,
        ignore=ignore,
        occlusion=occlusion,
        distance_m=np.nan if distance is None else distance,
        file=number,
        line=np.arange(1, len(records) + 1),
    )
    findings += _unknown_images(records, ~is_known)
    return boxes[is_known & ~is_left_out].reset_index(drop=True), facts, findings


def _unknown_images(records: Records, unknown: np.ndarray) -> list[Finding]:
    def place(row: int) -> tuple[str, str]:
        image = records.rows[row].get("image_id")
        return records.file.name, f"annotation {row + 1}, image_id {image}"

    return rows_finding(
        unknown,
        "unknown-image",
        "Annotations that name an image which is not in the image list were left out.",
        "Complete the image list, or remove the annotations.",
        role="truth",
        place=place,
        severity=Severity.ERROR,
    )


def _classes(
    document: dict[str, object], records: Records, file: SourceFile, options: ReadOptions
) -> tuple[CategoryChoice | None, pd.Series]:
    """The choice of classes, and each annotation's category id as text."""
    names: dict[str, str] = {}
    if document.get("categories") is not None:
        categories = Records(document["categories"], file, "category", "categories")
        if len(categories):
            labels = categories.required("name")
            for key, label in zip(categories.required("id"), labels, strict=True):
                names[id_text(key)] = str(label)
    values = records.values("category_id")
    keys = pd.Series([id_text(v) for v in values or [None] * len(records)], dtype=object)
    if not names:
        if options.classes is None and len(set(keys)) <= 1:
            return None, keys
        names = {key: key for key in keys.unique()}
        if options.classes is None:
            raise FormatError(
                f'there are no "categories", and annotations of category_id {", ".join(names)}; '
                "name the category ids that count as pedestrians",
                file=file.name,
            )
    elif "0" not in names:
        names["0"] = "ignore"  # CityPersons: category 0 is on no list
    unknown = ~keys.isin(list(names))
    if unknown.any():
        first = int(np.argmax(unknown))
        listed = ", ".join(f"{name} ({key})" for key, name in names.items())
        raise records.error(
            first, f"expected a category_id of the categories {listed}; found {keys[first]}"
        )
    used = set(keys)
    if "0" not in used and names.get("0") == "ignore":
        del names["0"]
    return choose_categories(names, options.classes, file=file.name), keys


def _tracks(records: Records, recording: np.ndarray) -> tuple[np.ndarray, bool]:
    values = records.values(*TRACK_KEYS)
    if values is None:
        return np.full(len(records), NO_TRACK), False
    allowed = {int, float, str, type(None)}
    if not set(map(type, values)) <= allowed:
        first = next(i for i, value in enumerate(values) if type(value) not in allowed)
        raise records.error(
            first, f"expected a number or text as track id, found {short_json(values[first])}"
        )
    texts = [None if value is None else id_text(value) for value in values]
    return track_numbers(pd.Series(texts, dtype="str"), recording)


def _occlusion(records: Records) -> tuple[np.ndarray, list[str], list[Finding]]:
    """Levels of occlusion from whichever field there is, the conversion, and what is odd."""
    visible = records.numbers("vis_ratio", "visibility")
    if visible is not None:
        return levels_of_visible_share(visible), ["occlusion from vis_ratio"], []
    for key in ("occlusion", "occluded"):
        values = records.values(key)
        if values is None:
            continue
        kinds = set(map(type, values)) - {type(None)}
        if kinds == {bool}:
            share = [np.nan if v is None else _VISIBLE_IF_OCCLUDED if v else 1.0 for v in values]
            level = levels_of_visible_share(np.array(share))
            return (
                level,
                [f"{key} true = heavy occlusion (half visible, as NightOwls counts it)"],
                [],
            )
        if kinds <= {int, float, bool}:
            numbers = records.to_floats(values, key)
            record = np.arange(1, len(numbers) + 1)
            odd = odd_levels(numbers, records.file, record, "truth")
            return levels_of_numbers(numbers), [f"{key} 0, 1, 2 kept"], odd
        if kinds == {str}:
            words = pd.Series(values, dtype=object).map(_level_of_words, na_action="ignore")
            level = words.fillna(UNKNOWN_OCCLUSION).to_numpy(dtype=np.int8)
            return level, [f"{key} from words (fully visible, partially, difficult to see)"], []
        first = next(i for i, v in enumerate(values) if not isinstance(v, (int, float, type(None))))
        raise records.error(
            first, f'expected 0, 1, 2 as "{key}", found {short_json(values[first])}'
        )
    return np.full(len(records), UNKNOWN_OCCLUSION, dtype=np.int8), [], []


def _level_of_words(words: str) -> int:
    """Level of FLIR's words: ``no_(fully_visible)``, ``..._(partially_occluded)``, ..."""
    lowered = words.lower()
    if "difficult" in lowered or "heav" in lowered or "fully_occluded" in lowered:
        return 2
    if "part" in lowered:
        return 1
    return 0 if lowered.startswith("no") or "fully_visible" in lowered else UNKNOWN_OCCLUSION


FORMAT = Format(
    name="coco",
    title="COCO ground truth",
    roles=("truth",),
    suffixes=(".json",),
    recognise=recognise,
    read=read,
)

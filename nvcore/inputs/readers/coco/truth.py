"""COCO ground truth (JSON), with the fields of KAIST, Teledyne FLIR, NightOwls, CityPersons."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import (
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    concat_boxes,
    conversion_text,
    reading_boxes,
    rows_finding,
)
from nvcore.inputs.readers.coco.images import (
    ImageList,
    files_of_one_task,
    id_text,
    id_texts,
    image_ids,
    places_of_rows,
    read_images,
    rows_by_id,
)
from nvcore.inputs.readers.meaning.classes import (
    CategoryChoice,
    ClassNames,
    choose_categories,
    classes_left_out,
    labelled,
)
from nvcore.inputs.readers.meaning.frame_names import joined_named
from nvcore.inputs.readers.meaning.values import (
    TEXT_IDS,
    attributes_of_boxes,
    checked_numbers,
    class_of,
    joined_attributes,
    joined_classes,
    known_distances,
    level_of_words,
    levels_of_numbers,
    levels_of_visible_share,
    odd_distances,
    odd_levels,
    track_numbers,
)
from nvcore.inputs.readers.parse.json import Records, read_json, short_json
from nvcore.inputs.readers.parse.unknown import foreign_format
from nvcore.schema import UNKNOWN_OCCLUSION
from nvcore.wording import count_text

TRACK_KEYS = ("track_id", "target_id", "instance_id", "tracking_id")
_LIST = re.compile(r'"(?:images|annotations|categories)"\s*:\s*\[')
_VISIBLE_IF_OCCLUDED = 0.5  # NightOwls' own reading of its yes-or-no field
CROWD: Final = "iscrowd"
"""Field of regions with several objects; among the classes that count it lets these count, too."""
_LEAST_MASKS: Final = 10
"""Masks of a file from which on their shapes tell that each is of one object. (Our choice.)"""
_HIGH_SHARE: Final = 0.8
"""Share of masks in such a file that are not wider than high; crowds are wide. (Our choice.)"""


def recognise(_name: str, head: str, role: Role) -> bool:
    """Whether the text is a JSON object with COCO's lists."""
    text = head.lstrip("\ufeff \t\r\n")
    has_lists = text.startswith("{") and _LIST.search(text) is not None
    return role == "truth" and has_lists and foreign_format(text) is None


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read COCO ground truth; each file brings its own images, ids and categories.

    Raises
    ------
    FormatError
        With file and record of the first thing that is not COCO, or is not clear.
    """
    tables, lists, attributes, kinds = [], [], [], []
    left_out: Counter[Any] = Counter()
    categories: dict[str, str] = {}
    used, passed_over = files_of_one_task(files)
    facts: list[str] = ["boxes as they are (0-based)", passed_over]
    findings: list[Finding] = []
    for number, file in used:
        document = read_json(file)
        if not isinstance(document, dict):
            raise file.fault(
                "expected a JSON object with images, annotations and categories, found "
                f"{short_json(document)}; a list of results is no ground truth"
            )
        listed = read_images(document, file, options)
        names = category_names(document, file)
        boxes, new_facts, oddities, texts, kind = _read_annotations(
            document, file, number, listed, names, options, left_out
        )
        tables.append(boxes)
        kinds.append(kind)
        for key, name in names.items():  # one name for an id, or none
            categories[key] = name if categories.get(key, name) == name else ""
        attributes.append(texts)
        lists.append(listed)
        facts += [listed.conversion, *new_facts]
        findings += [*listed.findings, *oddities]
    facts.append("evaluated frames from the image list")
    kind = np.concatenate(kinds)
    codes, labels = labelled(kind, kind != "", options.objects)
    return Reading(
        boxes=concat_boxes(tables).assign(label=codes),
        recordings=pd.concat([listed.recordings for listed in lists]).drop_duplicates(
            "name", ignore_index=True
        ),
        conversion=conversion_text(facts),
        images=_all_images([listed.table for listed in lists], [file for _, file in used]),
        findings=tuple(findings),
        attributes=joined_attributes(attributes),
        labels=labels,
        categories=categories,
        named=joined_named([listed.named for listed in lists]),
        left_out=classes_left_out(left_out),
    )


def _all_images(images: list[pd.DataFrame], files: Sequence[SourceFile]) -> pd.DataFrame:
    """Image list of all files; a frame in two of them is an error."""
    table = pd.concat(images, ignore_index=True)
    double = table.duplicated(["recording", "frame"])
    if double.any():
        first = table[double].iloc[0]
        owner = np.repeat(np.arange(len(images)), [len(part) for part in images])
        raise files[owner[int(np.argmax(double))]].fault(
            f"frame {first['frame']} of recording {first['recording']!r} is in an earlier file "
            "too; expected each frame in one file"
        )
    return table


def _read_annotations(
    document: dict[str, object],
    file: SourceFile,
    number: int,
    listed: ImageList,
    names: Mapping[str, str],
    options: ReadOptions,
    left_out: Counter[Any],
) -> tuple[pd.DataFrame, list[str], list[Finding], pd.DataFrame | None, np.ndarray]:
    """Boxes, the conversion in words, what is odd, the attributes; class of boxes, or empty.

    Boxes of classes that are left out are added to the counts of `left_out`.
    """
    records = Records(document.get("annotations"), file, "annotation", "annotations")
    classes = tuple(name for name in options.classes or () if name != CROWD)
    choice, keys = _classes(names, records, file, replace(options, classes=classes or None))
    facts = [choice.conversion]
    if not len(records):
        return reading_boxes(0), facts, [], None, np.empty(0, dtype=object)
    box = records.boxes()
    row = rows_by_id(image_ids(records, "image_id"), listed.table["image_id"])
    recording, frame, is_known = places_of_rows(listed.table, row)
    kind = keys.map({key: names.get(key, "") for key in choice.counted}).fillna("").to_numpy()
    ignore = records.flags("ignore") | keys.isin(choice.ignored).to_numpy()
    is_open = keys.isin(choice.counted).to_numpy() & ~ignore
    counted = [names.get(key, key) for key in choice.counted]
    is_crowd, fact, crowds = _crowds(records, box, is_open, counted, options)
    ignore |= is_crowd
    facts.append(fact)
    is_left_out = keys.isin(choice.others).to_numpy()
    left_out.update({item.name: item.count for item in choice.left_out})
    columns: dict[str, object] = {}
    track = id_texts(records, "track id", *TRACK_KEYS)
    if track is not None:
        columns["track"], has_text = track_numbers(track, recording)
        facts += [TEXT_IDS] if has_text else []
    lines = Lines.of(file, np.arange(1, len(records) + 1))
    columns["occlusion"], occlusion_facts, findings = _occlusion(records, lines)
    facts += occlusion_facts
    distance = records.numbers("distance_m", "distance")
    if distance is not None:
        findings += odd_distances(distance, lines, "truth")
        columns["distance_m"] = known_distances(distance)
    detectability = records.numbers("detectability")
    if detectability is not None:
        columns["detectability"] = checked_numbers(detectability, lines, "detectability", high=1)
    findings += [*choice.findings, *crowds]
    keep = is_known & ~is_left_out
    boxes = lines.boxes(
        box.T,
        keep=keep,
        recording=recording,
        frame=frame,
        ignore=ignore,
        file=number,
        **columns,
    )
    findings += rows_finding(
        ~is_known,
        "unknown-image",
        "Annotations that name an image which is not in the image list were left out.",
        "Complete the image list, or remove the annotations.",
        role="truth",
        place=lambda row: (
            file.name,
            f"annotation {row + 1}, image_id {records.rows[row].get('image_id')}",
        ),
        severity=Severity.ERROR,
    )
    attributes = attributes_of_boxes(boxes, _attribute_texts(records)[keep])
    facts += ["attributes as classes of encounters"] if attributes is not None else []
    return boxes, facts, findings, attributes, kind[keep]


def _crowds(
    records: Records,
    box: np.ndarray,
    is_open: np.ndarray,
    counted: Sequence[str],
    options: ReadOptions,
) -> tuple[np.ndarray, str, list[Finding]]:
    """Return which annotations are regions of crowds, the conversion in words, and what is odd.

    COCO's crowds are large regions. CVAT sets iscrowd for whatever was drawn as a mask, also for
    single pedestrians: these count, and where the file leaves doubt, a finding asks.

    Parameters
    ----------
    box
        x, y, w, h of each annotation, px, shape (n, 4).
    is_open
        Whether an annotation counts but for iscrowd; bool, shape (n,).
    counted
        Names of the classes that count.
    """
    is_crowd = records.flags(CROWD)
    usual = is_crowd, "ignore and iscrowd = ignore"
    n_crowds = int(np.count_nonzero(is_crowd & is_open))
    if not n_crowds:
        return *usual, []
    say = options.objects.say
    kept = np.zeros(len(records), dtype=bool), f"ignore = ignore; {n_crowds} with iscrowd counted"
    if CROWD in (options.classes or ()):
        return *kept, []
    shapes = records.values("segmentation") or [None] * len(records)
    is_drawn, is_mask = np.array([(bool(s), isinstance(s, dict)) for s in shapes]).T
    are_all = bool(is_crowd[is_open].all())
    are_masks = bool(((is_mask <= is_crowd) & (is_crowd <= is_drawn))[is_open].all())
    share_high = np.mean((box[:, 3] >= box[:, 2])[is_crowd & is_open])
    is_export = share_high >= _HIGH_SHARE and (are_all or (are_masks and n_crowds >= _LEAST_MASKS))
    if not (is_export or are_all or (are_masks and share_high >= _HIGH_SHARE / 2)):
        return *usual, []
    counts = is_export and options.classes is None
    finding = Finding(
        Severity.NOTE if counts else Severity.WARNING,
        "iscrowd",
        "truth",
        n_crowds,
        f"iscrowd is set for {count_text(n_crowds, 'annotation', 'annotations')} "
        + say("of {many}, as CVAT does for every mask: ")
        + ("each has the shape of one, so they count." if counts else "they are ignore regions."),
        say("If they are crowds, name the classes that count, without iscrowd.")
        if counts
        else say("If each is a single one, let iscrowd count as if it were a class."),
        file=records.file.name,
        example=f"annotation {int(np.argmax(is_crowd & is_open)) + 1}",
        steps=(Step(Remedy.CLASSES, ",".join([*counted, *([] if counts else [CROWD])])),),
    )
    return *(kept if counts else usual), [finding]


def _attribute_texts(records: Records) -> np.ndarray:
    """What each annotation's `attributes` (object, list or text) say; object, shape (n,)."""
    texts = np.full(len(records), "", dtype=object)
    for row, value in enumerate(records.values("attributes") or ()):  # a loop over JSON objects
        if isinstance(value, dict):
            texts[row] = joined_classes(
                class_of(name, str(given))
                for name, given in value.items()
                if isinstance(given, str | bool)
            )
        elif isinstance(value, list):
            texts[row] = joined_classes(name.strip() for name in value if isinstance(name, str))
        elif isinstance(value, str):
            texts[row] = value.strip()
    return texts


def category_names(document: dict[str, object], file: SourceFile) -> dict[str, str]:
    """The names that a file gives its categories, by their ids as text."""
    if document.get("categories") is None:
        return {}
    categories = Records(document["categories"], file, "category", "categories")
    pairs = zip(categories.required("name"), categories.required("id"), strict=True)
    return {id_text(key): str(label) for label, key in pairs}


def _classes(
    categories: Mapping[str, str], records: Records, file: SourceFile, options: ReadOptions
) -> tuple[CategoryChoice, pd.Series]:
    """The choice of classes, and each annotation's category id as text."""
    names = dict(categories)
    values = records.values("category_id")
    keys = pd.Series([id_text(v) for v in values or [None] * len(records)], dtype=object)
    if names and "0" not in names:
        names["0"] = "ignore"  # CityPersons: category 0 is on no list
    unknown = ~keys.isin(list(names))
    if names and unknown.any():
        first = int(np.argmax(unknown))
        listed = ", ".join(f"{name} ({key})" for key, name in names.items())
        raise records.error(
            first, f"expected a category_id of the categories {listed}; found {keys[first]}"
        )
    if names.get("0") == "ignore" and "0" not in set(keys):
        del names["0"]
    counts: dict[Any, int] = keys.value_counts().to_dict()
    choice = choose_categories(
        counts, ClassNames(names), options, file=file.name, numbers="category_id"
    )
    return choice, keys


def _occlusion(records: Records, lines: Lines) -> tuple[np.ndarray, list[str], list[Finding]]:
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
            fact = f"{key} true = heavy occlusion (half visible, as NightOwls counts it)"
            return levels_of_visible_share(np.array(share)), [fact], []
        if kinds <= {int, float, bool}:
            numbers = records.to_floats(values, key)
            fact = f"{key} 0, 1, 2 kept"
            return levels_of_numbers(numbers), [fact], odd_levels(numbers, lines, "truth")
        if kinds == {str}:
            words = pd.Series(values, dtype=object).map(level_of_words, na_action="ignore")
            fact = f"{key} from words (such as none, part, full)"
            return words.fillna(UNKNOWN_OCCLUSION).to_numpy(dtype=np.int8), [fact], []
        records.check_types(values, {bool, int, float, type(None)}, f'0, 1, 2 as "{key}"')
    return np.full(len(records), UNKNOWN_OCCLUSION, dtype=np.int8), [], []


FORMAT = Format("coco", "COCO ground truth", ("truth",), (".json",), recognise, read)

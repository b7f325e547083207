"""COCO ground truth (JSON), with the fields of KAIST, Teledyne FLIR, NightOwls, CityPersons."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset.schema import UNKNOWN_OCCLUSION
from nvcore.inputs.readers.base import (
    NO_FRAME,
    Format,
    Lines,
    NamedPictures,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    conversion_text,
    reading_boxes,
    recordings_table,
    rows_finding,
    warning,
)
from nvcore.inputs.readers.meaning.classes import (
    CategoryChoice,
    ClassNames,
    choose_categories,
    labelled,
)
from nvcore.inputs.readers.meaning.frame_names import (
    NO_NAMES,
    in_file,
    named_pictures,
    times_as_frames,
)
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of
from nvcore.inputs.readers.meaning.values import (
    TEXT_IDS,
    attributes_of_boxes,
    checked_numbers,
    class_of,
    joined_classes,
    known_distances,
    level_of_words,
    levels_of_numbers,
    levels_of_visible_share,
    odd_distances,
    odd_levels,
    track_numbers,
)
from nvcore.inputs.readers.parse.json import Records, first_other, read_json, short_json
from nvcore.inputs.readers.parse.rows import FilePart, joined_parts
from nvcore.inputs.readers.parse.text import whole_numbers
from nvcore.inputs.readers.parse.unknown import foreign_format

NAME_KEYS = ("file_name", "im_name", "filename", "image_name", "image_filepath")
FRAME_KEYS = ("frame_index", "frame_id", "frame_number", "frame")
VIDEO_KEYS = ("video_id", "recording_id", "recordings_id")
_TASKS = ("instances", "person_keypoints", "stuff", "panoptic", "captions", "labels", "image_info")
"""Prefixes of files such as ``instances_val2017.json``, with the same pictures for each task."""
_TASK_FILE = re.compile(rf"(?P<folder>(?:.*/)?)(?P<task>{'|'.join(_TASKS)})_(?P<subset>.+)")
TRACK_KEYS = ("track_id", "target_id", "instance_id", "tracking_id")
_LIST = re.compile(r'"(?:images|annotations|categories)"\s*:\s*\[')
_VISIBLE_IF_OCCLUDED = 0.5  # NightOwls' interpretation of its yes-or-no field
CROWD: Final = "iscrowd"
"""Field of regions with several objects. As a class that counts, it lets them count, too."""
_LEAST_MASKS: Final = 10
"""Smallest number of masks whose shapes show that each is a single object. (Our choice.)"""
_HIGH_SHARE: Final = 0.8
"""Share of masks of single objects that are not wider than high, as crowds are. (Our choice.)"""


def recognise(_name: str, head: str, role: Role) -> bool:
    """Whether the text is a JSON object with COCO's lists."""
    text = head.lstrip("\ufeff \t\r\n")
    has_lists = text.startswith("{") and _LIST.search(text) is not None
    return role == "truth" and has_lists and foreign_format(text) is None


def read_files(
    files: Sequence[SourceFile],
    options: ReadOptions,
    read_part: Callable[[SourceFile, int, ReadOptions], FilePart],
) -> tuple[Reading, list[Reading], list[SourceFile]]:
    """Read several files, and return the joined reading, its parts, and the files used."""
    used, passed_over = files_of_one_task(files)
    parts = [read_part(file, number, options) for number, file in used]
    reading = joined_parts(parts, ["boxes as they are (0-based)", passed_over])
    kind = np.concatenate([np.empty(0, object), *(p.kind for p in parts if p.kind is not None)])
    codes, labels = labelled(kind, kind != "", options.objects)
    reading = replace(reading, boxes=reading.boxes.assign(label=codes), labels=labels)
    return reading, [part.reading for part in parts], [file for _, file in used]


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read COCO ground truth. Each file has its own images, ids and categories."""
    reading, parts, used = read_files(files, options, _read_part)
    categories: dict[str, str] = {}
    for key, name in chain(*(part.categories.items() for part in parts)):
        # no name if files give an id different names
        categories[key] = name if categories.get(key, name) == name else ""
    lists = [part.images for part in parts if part.images is not None]
    images = pd.concat(lists, ignore_index=True)
    double = images.duplicated(["recording", "frame"])
    if double.any():
        first = images[double].iloc[0]
        owner = np.repeat(np.arange(len(lists)), [len(listed) for listed in lists])
        raise used[owner[int(np.argmax(double))]].fault(
            f"frame {first['frame']} of recording {first['recording']!r} is in an earlier file "
            "too; expected each frame in one file"
        )
    return replace(
        reading,
        conversion=conversion_text([reading.conversion, "evaluated frames from the image list"]),
        images=images,
        categories=categories,
    )


def _read_part(file: SourceFile, number: int, options: ReadOptions) -> FilePart:
    document = read_json(file)
    if not isinstance(document, dict):
        raise file.fault(
            "expected a JSON object with images, annotations and categories, found "
            f"{short_json(document)}; a list of results is no ground truth"
        )
    listed, images = read_images(document, file, options)
    names = category_names(document, file)
    listed = replace(listed, categories=names)
    records = Records(document.get("annotations"), file, "annotation", "annotations")
    classes = tuple(name for name in options.classes or () if name != CROWD)
    choice, keys = _classes(names, records, file, replace(options, classes=classes or None))
    facts, findings = [listed.conversion, choice.conversion], [*listed.findings]
    if not len(records):
        return FilePart(listed, facts)
    box = records.boxes()
    row = rows_by_id(image_ids(records, "image_id"), images["image_id"])
    recording, frame, is_known = places_of_rows(images, row)
    ignore = records.flags("ignore") | keys.isin(choice.ignored).to_numpy()
    is_open = keys.isin(choice.counted).to_numpy() & ~ignore
    counted = [names.get(key, key) for key in choice.counted]
    is_crowd, fact, crowds = _crowds(records, box, is_open, counted, options)
    facts.append(fact)
    columns: dict[str, object] = {}
    track = id_texts(records, "track id", *TRACK_KEYS)
    if track is not None:
        columns["track"], has_text = track_numbers(track, recording)
        facts += [TEXT_IDS] if has_text else []
    lines = Lines.of(file, np.arange(1, len(records) + 1))
    columns["occlusion"], occlusion_facts, odd_occlusions = _occlusion(records, lines)
    facts += occlusion_facts
    findings += odd_occlusions
    distance = records.numbers("distance_m", "distance")
    if distance is not None:
        findings += odd_distances(distance, lines, "truth")
        columns["distance_m"] = known_distances(distance)
    detectability = records.numbers("detectability")
    if detectability is not None:
        columns["detectability"] = checked_numbers(detectability, lines, "detectability", high=1)
    findings += [*choice.findings, *crowds]
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
    keep = is_known & ~keys.isin(choice.others).to_numpy()
    boxes = lines.boxes(
        box.T,
        keep=keep,
        recording=recording,
        frame=frame,
        ignore=ignore | is_crowd,
        file=number,
        **columns,
    )
    attributes = attributes_of_boxes(boxes, _attribute_texts(records)[keep])
    facts += ["attributes as classes of encounters"] if attributes is not None else []
    kind = keys.map({key: names.get(key, "") for key in choice.counted}).fillna("").to_numpy()[keep]
    reading = replace(
        listed,
        boxes=boxes,
        findings=tuple(findings),
        left_out=choice.left_out,
        attributes=attributes,
    )
    return FilePart(reading, facts, kind)


def _crowds(
    records: Records,
    box: np.ndarray,
    is_open: np.ndarray,
    counted: Sequence[str],
    options: ReadOptions,
) -> tuple[np.ndarray, str, list[Finding]]:
    """Mark annotations that are regions of crowds, and return conversion text and findings.

    COCO's crowds are large regions. CVAT sets iscrowd for every mask, even for single pedestrians,
    which count. If the file is ambiguous, a finding asks the user.

    Parameters
    ----------
    box
        x, y, w, h of each annotation, px, shape (n, 4).
    is_open
        Whether an annotation counts apart from iscrowd, bool, shape (n,).
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
    """Return the text of each annotation's `attributes` (object, list or text), shape (n,)."""
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
    """Return the names of a file's categories, by their ids as text."""
    if document.get("categories") is None:
        return {}
    categories = Records(document["categories"], file, "category", "categories")
    pairs = zip(categories.required("name"), categories.required("id"), strict=True)
    return {id_text(key): str(label) for label, key in pairs}


def _classes(
    categories: Mapping[str, str], records: Records, file: SourceFile, options: ReadOptions
) -> tuple[CategoryChoice, pd.Series]:
    """Choose the classes, and return each annotation's category id as text."""
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
    """Return levels of occlusion from any known field, with conversion text and findings."""
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


def files_of_one_task(files: Sequence[SourceFile]) -> tuple[list[tuple[int, SourceFile]], str]:
    """Select the files of one task per subset, with their indices, and describe the choice."""
    matches = [_TASK_FILE.fullmatch(unpacked_name(file.name)) for file in files]
    ranks = [_TASKS.index(match["task"]) if match else 0 for match in matches]
    subsets = [
        (match["folder"], match["subset"]) if match else (file.name, "")
        for file, match in zip(files, matches, strict=True)
    ]
    # the last of equal keys is kept: the lowest rank
    best = dict(sorted(zip(subsets, ranks, strict=True), key=lambda pair: -pair[1]))
    is_used = [rank == best[subset] for subset, rank in zip(subsets, ranks, strict=True)]
    used = [(number, file) for number, file in enumerate(files) if is_used[number]]
    others = ", ".join(file.name for number, file in enumerate(files) if not is_used[number])
    return used, f"the same pictures for other tasks passed over: {others}" if others else ""


def read_images(
    document: dict[str, object], file: SourceFile, options: ReadOptions
) -> tuple[Reading, pd.DataFrame]:
    """Read the image list of a COCO document as a reading without boxes and its `images`.

    Raises
    ------
    FormatError
        If there is no list, or one of its entries is invalid.
    """
    images = Records(document.get("images"), file, "image", "images")
    ids = image_ids(images)
    keep, findings = _first_of_each_id(images, ids)
    names = _names(images)
    with in_file(file):
        recording, frame, conversion, oddities, named = _places(images, names, document, options)
    table = pd.DataFrame(
        {
            "recording": pd.Series(recording, dtype=object),
            "frame": frame,
            "image_id": ids,
            "file_name": pd.Series(names, dtype=object),
            "width": _sizes(images, "width"),
            "height": _sizes(images, "height"),
        }
    )
    table = table[keep].reset_index(drop=True)
    double = table.duplicated(["recording", "frame"]) & (table["frame"] != NO_FRAME)
    if double.any():
        first = table[double].iloc[0]
        raise file.fault(
            f"two images are frame {first['frame']} of recording {first['recording']!r} (the "
            f"second has id {first['image_id']}); expected one image per frame"
        )
    recordings, sizes = _recordings(table, document, file)
    renamed = zip(named.recording, recording, strict=True) if named.rates else ()
    rates = {new: named.rates[old] for old, new in renamed if old in named.rates}
    listed = table[["recording", "frame", "file_name"]].rename(columns={"file_name": "name"})
    images_table = table[["recording", "frame", "image_id", "file_name"]]
    return Reading(
        reading_boxes(0),
        recordings,
        conversion,
        images=images_table,
        findings=tuple(findings + oddities + sizes),
        named=replace(named, table=listed, rates=rates, strange=-1),
    ), images_table


def image_ids(records: Records, *keys: str) -> pd.Series:
    """Return image ids as int64 if all are whole numbers, else as text (object).

    Raises
    ------
    FormatError
        If an id is missing or neither number nor text, with the first such record.
    """
    values = records.required(*(keys or ("id",)))
    records.check_types(values, {int, float, str}, "a number or text as image id")
    has_text = first_other(values, {int, float}) is not None
    if not has_text and all(-(2**53) < value < 2**53 for value in values):  # type: ignore[operator]
        numbers = np.array(values, dtype=float)
        if not np.any(numbers % 1):
            return pd.Series(numbers.astype(np.int64))
    return pd.Series([id_text(value) for value in values], dtype=object)


def id_text(value: object) -> str:
    """Convert an image id to text, with 3.0 as 3."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def id_texts(records: Records, what: str, *keys: str) -> pd.Series | None:
    """Return ids of a field (see `Records.values`) as text, missing if a record has none.

    Raises
    ------
    FormatError
        If an id is neither number nor text, with the first such record.
    """
    values = records.values(*keys)
    if values is None:
        return None
    records.check_types(values, {int, float, str, type(None)}, f"a number or text as {what}")
    texts = [None if value is None else id_text(value) for value in values]
    return pd.Series(texts, dtype="str")


def rows_by_id(ids: pd.Series, listed: pd.Series) -> np.ndarray:
    """Return the row of each id in the image list, or -1. Ids 12 and "12" are equal."""
    if not (ids.dtype == listed.dtype and pd.api.types.is_integer_dtype(ids.dtype)):
        ids, listed = (part.map(id_text).astype(object) for part in (ids, listed))
    return np.asarray(pd.Index(listed).get_indexer(pd.Index(ids)))


def places_of_rows(
    images: pd.DataFrame, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return recording, frame, and whether they are known (row is not -1), of image list rows."""
    if images.empty:
        return np.full(len(row), "", dtype=object), np.zeros(len(row), np.int64), row >= 0
    recording = images["recording"].to_numpy(dtype=object)[row]
    return recording, images["frame"].to_numpy(dtype=np.int64)[row], row >= 0


def _names(images: Records) -> list[str]:
    """Return the file name of each picture, empty if it has none."""
    values = images.values(*NAME_KEYS) or [None] * len(images)
    images.check_types(values, {str, type(None)}, "text as file_name")
    return [str(value or "") for value in values]


def _first_of_each_id(images: Records, ids: pd.Series) -> tuple[np.ndarray, list[Finding]]:
    """Mark images to keep, dropping exact repetitions with a finding."""
    double = ids.duplicated().to_numpy()
    for index in np.flatnonzero(double):  # doubles are few
        if images.rows[index] != images.rows[int(np.argmax(ids == ids[index]))]:
            raise images.error(int(index), f"id {ids[index]} stands for two different images")
    return ~double, rows_finding(
        double,
        "duplicate-image",
        "Images are listed more than once.",
        "Nothing is lost: each is taken once; mend the list.",
        role="truth",
        place=lambda row: (images.file.name, f"image {row + 1} of the list, id {ids[row]}"),
    )


def _places(
    images: Records, names: Sequence[str], document: dict[str, object], options: ReadOptions
) -> tuple[Sequence[str], np.ndarray, str, list[Finding], NamedPictures]:
    """Return recordings and frames of images, with conversion text, findings and names."""
    file_recording = recording_of(images.file.name)
    named = NO_NAMES
    numbers = images.numbers(*FRAME_KEYS)
    has_numbers = numbers is not None and len(numbers) > 0 and not np.isnan(numbers).any()
    if names and all(names) and options.frame_names != "order":
        try:
            named = named_pictures(names, options)
        except InputError:
            if not has_numbers:
                raise
            named = named_pictures(names, replace(options, frame_names="numbers"))
    are_placed = named.strange < 0
    folders = (_folders(names, file_recording), "recordings from the folders")
    if options.role == "detections" and are_placed and named.is_joined:
        return [*named.recording], named.frame, "pictures found in the truth by name", [], named
    videos = _videos(images, document)
    recording: Sequence[str]
    if videos is not None:
        recording, source = videos, "recordings from the video of each image"
    elif are_placed:
        recording = [_or_whole(place, file_recording) for place in named.recording]
        source = "recordings from the file names"
    else:
        recording, source = folders
    if has_numbers and numbers is not None:
        if videos is None and _is_scattered(recording):
            recording, source = folders
        lines = Lines.of(images.file, np.arange(1, len(numbers) + 1))
        times = times_as_frames(numbers, recording, options, lines)
        if times is not None:
            return recording, times[1], f"{source}, times from the images' fields", [], times[2]
        frame = whole_numbers(numbers, lines, "frame number")
        text = f"{source}, frame numbers from the images' fields"
        return recording, frame, text, [], replace(named, how="fields", facts=(), rates={})
    if are_placed and not _is_scattered(recording):
        pictures = pd.DataFrame({"recording": recording, "frame": named.frame, "name": names})
        double = pictures.drop_duplicates().duplicated(["recording", "frame"])
        if double.any():
            first = pictures.loc[double[double].index[0]]
            of_frame = (pictures["recording"] == first["recording"]) & (
                pictures["frame"] == first["frame"]
            )
            raise InputError(
                f"{first['name']} is frame {first['frame']} of recording {first['recording']!r}, "
                f"as is {pictures['name'][of_frame].iloc[0]}; expected one picture a frame: leave "
                "copies out, or say that the pictures follow each other in the order of the list",
                steps=(Step(Remedy.FRAME_NAMES, "order"),),
            )
        return recording, named.frame, f"{source}, frame numbers from the file names", [], named
    if videos is None:
        recording, source = folders
    frame = pd.Series(recording, dtype=object).groupby(recording).cumcount().to_numpy(np.int64)
    text = f"{source}, frame numbers from the order of the list"
    by_order = NamedPictures(named.table, "order")
    if options.frame_names == "order":
        return recording, frame, text, [], by_order
    finding = warning(
        "frames-by-order",
        len(images),
        "Neither fields nor file names of the images tell the frame number; they are "
        "numbered 0, 1, 2, ... in the order of the list.",
        "Check that the list is in the order of time.",
        role="truth",
        file=images.file.name,
        example=next(iter(names), ""),
    )
    return recording, frame, text, [finding], by_order


def _or_whole(recording: str, file_recording: str) -> str:
    """Return the file's recording for a name without a folder (parsed as "recording")."""
    return file_recording if recording == "recording" else recording


def _is_scattered(recording: Sequence[str]) -> bool:
    """Whether almost every image would have its own recording, as with hashes as names."""
    return len(recording) >= 4 and len(set(recording)) > len(recording) / 2


def _folders(names: Sequence[str], file_recording: str) -> list[str]:
    """Return the recording of each picture by its folder alone."""
    folders = [name.replace("\\", "/").rpartition("/")[0] for name in names]
    # a made-up frame number lets the rules for folders apply
    places = {folder: recording_and_frame_of(f"{folder}/0") for folder in {*folders}}
    recordings = {
        folder: _or_whole(place[0], file_recording) if place else file_recording
        for folder, place in places.items()
    }
    return [recordings[folder] for folder in folders]


def _videos(images: Records, document: dict[str, object]) -> list[str] | None:
    """Return the name of each image's video, or None unless every image has one."""
    ids = images.values(*VIDEO_KEYS)
    if not ids or None in ids or not set(map(type, ids)) <= {int, float, str}:
        return None
    names: dict[str, str] = {}
    if document.get("videos") is not None:
        videos = Records(document["videos"], images.file, "video", "videos")
        titles = videos.values("name", "file_name") or [None] * len(videos)
        for key, title in zip(videos.required("id"), titles, strict=True):
            names[id_text(key)] = title if isinstance(title, str) and title else id_text(key)
    return [names.get(id_text(key), id_text(key)) for key in ids]


def _sizes(images: Records, key: str) -> np.ndarray:
    """Return the width or height of each picture, NaN if missing or not positive."""
    values = images.numbers(key)
    if values is None:
        return np.full(len(images), np.nan)
    return np.where((values > 0) & np.isfinite(values), values, np.nan)


def _recordings(
    table: pd.DataFrame, document: dict[str, object], file: SourceFile
) -> tuple[pd.DataFrame, list[Finding]]:
    """Make a table of recordings with their commonest picture size, and report other sizes."""
    fps = {}
    if document.get("videos"):
        videos = Records(document["videos"], file, "video", "videos")
        rates = videos.numbers("fps", "frame_rate")
        titles = videos.values("name", "file_name")
        if rates is not None and titles is not None:
            fps = {
                str(title): rate
                for title, rate in zip(titles, rates, strict=True)
                if 0 < rate < np.inf
            }
    rows, n_odd, example = [], 0, ""
    # a loop over recordings: there are few
    for name, group in table.groupby("recording", sort=False):
        sizes = group[["width", "height"]].value_counts(sort=True)
        width, height = sizes.index[0] if len(sizes) else (np.nan, np.nan)
        differs = group["width"].notna() & ~(group["width"].eq(width) & group["height"].eq(height))
        if differs.any() and not n_odd:
            first = group[differs].iloc[0]
            example = (
                f"image id {first['image_id']} is {first['width']:g}x{first['height']:g}, "
                f"most of {name} is {width:g}x{height:g}"
            )
        n_odd += int(differs.sum())
        rows.append((str(name), width, height, fps.get(str(name), np.nan)))
    names, *facts = zip(*rows, strict=True) if rows else ((), (), (), ())
    recordings = recordings_table(names, width=facts[0], height=facts[1], fps=facts[2])
    if not n_odd:
        return recordings, []
    finding = warning(
        "picture-size",
        n_odd,
        "Pictures of one recording differ in size; the commonest size is taken.",
        "Give each size a recording of its own, or scale the boxes to one size.",
        role="truth",
        file=file.name,
        example=example,
    )
    return recordings, [finding]


FORMAT = Format("coco", "COCO ground truth", ("truth",), (".json",), recognise, read)

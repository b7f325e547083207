"""Pascal VOC: one XML file per picture."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from nvcore.common.findings import Remedy, Step
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    object_array,
    rows_finding,
)
from nvcore.inputs.readers.meaning.classes import choose_classes, concerns_objects, rule_for
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.readers.meaning.values import levels_of_numbers, recordings_with_sizes
from nvcore.inputs.readers.parse.rows import rows_reading
from nvcore.inputs.readers.parse.unknown import foreign_format
from nvcore.inputs.readers.parse.xml import Element, is_true, read_elements, root_of

CORNERS: Final = ("xmin", "ymin", "xmax", "ymax")
SCORES: Final = ("score", "confidence")
_SIZES: Final = ("bndbox/x", "bndbox/y", "bndbox/w", "bndbox/h")
"""Fields of KAIST's own XML instead of corners, 0-based as in its text format."""
_COLUMNS = ("file", "line", *CORNERS, "difficult", "occluded", "score")


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether the root element is ``<annotation>``, and not that of LabelMe."""
    return root_of(head) == "annotation" and foreign_format(head) is None


@dataclass
class _Objects:
    """Objects of all files, before the classes are sorted."""

    base: int = 1
    n_fractions: int = 0
    """Number of corners with a decimal point."""
    numbers: array[float] = field(default_factory=lambda: array("d"))
    label: list[str] = field(default_factory=list)
    shapes: list[tuple[str, int, int]] = field(default_factory=list)
    """Label, file and line of objects without a box."""
    sizes: list[tuple[float, float]] = field(default_factory=list)
    """Width and height of each file's picture, NaN where not given."""


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read Pascal VOC files, one per picture. Files without objects are evaluated frames, too.

    Corners are inclusive pixels counted from 1, as VOC defines them. With ``box_base=0``, or if
    most have a decimal point, they are edges counted from 0, as many other programs write them.
    KAIST's x, y, w, h are kept. Difficult objects are ignore regions.
    """
    named = listed_frames(files, options)
    objects = _Objects(1 if options.box_base is None else options.box_base)
    # a loop over files, each of which is a picture
    for position, file in enumerate(files):
        _read_one(file, position, objects)
    table = np.frombuffer(objects.numbers, dtype=np.float64).reshape(-1, len(_COLUMNS))
    # pixel numbers are whole, while CVAT and Datumaro write edges such as "60.0"
    usual_base = 0 if objects.n_fractions > len(table) * len(CORNERS) / 2 else 1
    base = usual_base if options.box_base is None else options.box_base
    column = {name: table[:, i] for i, name in enumerate(_COLUMNS)}
    lines = Lines(files, column["file"].astype(np.int64), column["line"].astype(np.int64))
    label = object_array(objects.label)
    rule = rule_for(None, {*label, *(shape[0] for shape in objects.shapes)}, options)
    choice = choose_classes(label, rule, options, lines)
    is_truth = options.role == "truth"
    x, y = column["xmin"] - base, column["ymin"] - base
    with np.errstate(invalid="ignore", over="ignore"):
        w, h = column["xmax"] - x, column["ymax"] - y
    facts = [
        "frame numbers from the file names",
        "inclusive corners to width and height, pixels from 1-based to 0-based"
        if base
        else "corners taken as edges, pixels 0-based (box base 0)"
        + ", as they have fractions" * (options.box_base is None),
        choice.fact,
        "difficult = ignore" if is_truth else "",
        "occluded = partial occlusion, truncated not used",
    ]
    width, height = np.array(objects.sizes, dtype=float).reshape(-1, 2).T
    recordings, odd_sizes = recordings_with_sizes(
        named.table.assign(width=width, height=height),
        options.role,
        lambda picture: (files[picture].name, ""),
    )
    # impossible in a file that counts pixels from 1
    is_before_first = choice.keep & ((x == -base) | (y == -base)) & (base != 0)
    findings = [
        *rows_finding(
            np.array([concerns_objects(shape[0], options) for shape in objects.shapes], bool),
            "no-box",
            options.objects.say("{Many} without <bndbox> are not boxes and were left out."),
            "Annotate them as upright boxes.",
            role=options.role,
            place=lambda row: (
                files[objects.shapes[row][1]].name,
                f"line {objects.shapes[row][2]}: {objects.shapes[row][0]}",
            ),
        ),
        *lines.finding(
            is_before_first,
            "box-base",
            "Boxes have xmin or ymin 0, but Pascal VOC counts pixels from 1.",
            "The files seem to count from 0: say so.",
            role=options.role,
            steps=(Step(Remedy.BOX_BASE, "0"),),
        ),
        *odd_sizes,
    ]
    reading = rows_reading(
        lines,
        (x, y, w, h),
        choice,
        named,
        options,
        facts,
        findings=findings,
        kind=label,
        layout="corners",
        score=column["score"],
        ignore=(choice.ignore | (column["difficult"] == 1)) & is_truth,
        occlusion=levels_of_numbers(column["occluded"]),
    )
    return replace(reading, recordings=recordings, usual={"box_base": usual_base})


def _read_one(file: SourceFile, index: int, objects: _Objects) -> None:
    """Append the objects of one file, except parts of objects (heads, hands)."""
    facts: dict[str, Element] = {}
    size = {"width": float("nan"), "height": float("nan")}
    for element in read_elements(file, root="annotation"):
        path = element.path.removeprefix("annotation/")
        if path in ("size/width", "size/height"):
            value = element.number(element.text, path)
            # some programs write 0 for an unknown size
            size[path.removeprefix("size/")] = value if value > 0 else float("nan")
        elif path == "object":
            _add_object(element, facts, index, objects)
            facts = {}
        elif path.startswith("object/"):
            facts[path.removeprefix("object/")] = element
    objects.sizes.append((size["width"], size["height"]))


def _add_object(element: Element, facts: dict[str, Element], index: int, objects: _Objects) -> None:
    """Append an object from its elements, or only its label if it has no box."""
    if "name" not in facts:
        raise element.fault("expected <object> with a <name>")
    label = facts["name"].text
    if "bndbox" not in facts:
        objects.shapes.append((label, index, element.line))
        return
    values: list[float] = [index, facts["bndbox"].line]
    if f"bndbox/{CORNERS[0]}" not in facts and {*_SIZES} <= facts.keys():
        x, y, w, h = (facts[name].number(facts[name].text, f"<{name}>") for name in _SIZES)
        values += [x + objects.base, y + objects.base, x + w, y + h]
    for name in CORNERS if len(values) < len(CORNERS) else ():
        edge = facts.get(f"bndbox/{name}")
        objects.n_fractions += edge is not None and "." in edge.text
        what, text = f"<{name}> in <bndbox>", None if edge is None else edge.text
        values.append((edge or facts["bndbox"]).number(text, what))
    values.append("difficult" in facts and is_true(facts["difficult"].text))
    for names in (("occluded", "occlusion"), SCORES):
        fact = next((facts[name] for name in names if name in facts), None)
        values.append(math.nan if fact is None else fact.number(fact.text, f"<{names[0]}>"))
    objects.numbers.extend(values)
    objects.label.append(label)


FORMAT = Format("voc", "Pascal VOC", BOTH_ROLES, (".xml",), recognise, read)

"""Parts of the report in the words for what the boxes are of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Final, TypeVar, cast

import plotly.graph_objects as go

from nvcore.dataset import Dataset
from nvcore.figures.wording import worded as worded_figure
from nvcore.report.html.blocks import Section

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Part = TypeVar("Part")
OF_USERS: Final = ("inputs", "audit")
"""Sections whose content quotes files; of these the introduction alone is ours."""


def worded_sections(sections: Sequence[Section], dataset: Dataset) -> list[Section]:
    """The sections in the dataset's words; see `nvcore.dataset.Dataset.words`."""
    return [
        replace(section, intro=worded(section.intro, dataset))
        if section.anchor in OF_USERS
        else worded(section, dataset)
        for section in sections
    ]


def worded(part: Part, dataset: Dataset) -> Part:
    """A text, figure, block or photo, or a tuple of such, with every text in it worded."""
    if dataset.objects.are_pedestrians:
        return part
    return cast("Part", _worded(part, dataset))


def _worded(part: object, dataset: Dataset) -> object:
    if isinstance(part, str):
        return dataset.words(part)
    if isinstance(part, go.Figure):
        return worded_figure(part, dataset)
    if isinstance(part, tuple):
        return tuple(_worded(item, dataset) for item in part)
    if hasattr(part, "__dataclass_fields__"):
        block = cast("DataclassInstance", part)
        values = {spec.name: getattr(block, spec.name) for spec in fields(block)}
        # names by which the page finds a part stay
        own = {name: value for name, value in values.items() if name not in ("anchor", "name")}
        return replace(block, **{name: _worded(value, dataset) for name, value in own.items()})
    return part

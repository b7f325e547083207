"""Boxes as "CVAT for images" XML 1.1, for import into an annotation tool."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.sax.saxutils import escape, quoteattr

import pandas as pd

_NOT_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def cvat_bytes(pictures: pd.DataFrame, boxes: pd.DataFrame) -> bytes:
    """Return pictures with their boxes as UTF-8 XML.

    Parameters
    ----------
    pictures
        One row per picture: name, width, height (px).
    boxes
        Columns picture (row of `pictures`), label, x, y, w, h (px, from the picture's corner).
    """
    texts: list[list[str]] = [[] for _ in range(len(pictures))]
    columns = (boxes[name] for name in ("picture", "label", "x", "y", "w", "h"))
    # XML needs one element per box, so this is a loop
    for picture, label, x, y, w, h in zip(*columns, strict=True):
        texts[picture].append(
            f'    <box label={_quoted(label)} source="file" occluded="0" xtl="{x:.2f}" '
            f'ytl="{y:.2f}" xbr="{x + w:.2f}" ybr="{y + h:.2f}" z_order="0"/>\n'
        )
    sizes = zip(pictures["name"], pictures["width"], pictures["height"], strict=True)
    images = [
        f'  <image id="{number}" name={_quoted(name)} width="{width:.0f}" height="{height:.0f}">\n'
        f"{''.join(texts[number])}  </image>\n"
        for number, (name, width, height) in enumerate(sizes)
    ]
    head = f"<version>1.1</version>\n  <meta><task>{_labels(boxes['label'].unique())}</task></meta>"
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        f"<annotations>\n  {head}\n{''.join(images)}</annotations>\n"
    ).encode()


def _labels(names: Iterable[str]) -> str:
    labels = (
        f"<label><name>{escape(_possible(name))}</name><type>rectangle</type></label>"
        for name in names
    )
    return f"<mode>annotation</mode><labels>{''.join(labels)}</labels>"


def _quoted(text: str) -> str:
    return quoteattr(_possible(text))


def _possible(text: str) -> str:
    """Remove the characters that XML cannot hold."""
    return _NOT_XML.sub("�", text)

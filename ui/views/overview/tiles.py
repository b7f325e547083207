"""Overview page: four summary tiles as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Final

from nvcore.notes import phrase
from nvcore.report.tiles import Tile
from nvcore.settings.objects import Objects
from ui.widgets.html import stamp_html, value_hooks

MAX_NAME: Final = 5
"""Maximum length of a name beside a value, in characters. X and Y replace longer names."""


def tiles_html(tiles: Sequence[Tile], objects: Objects, names: Mapping[str, str]) -> str:
    """Return the HTML of tiles in a row. Their height does not depend on having an interval.

    Parameters
    ----------
    names
        `ui.widgets.text.short_names` of the systems.
    """
    if max(map(len, names.values())) > MAX_NAME:
        names = {"x": "X", "y": "Y"}
    sections = "".join(_tile(tile, objects, names) for tile in tiles)
    return f'<div class="nv-tiles">{stamp_html()}{sections}</div>'


def _tile(tile: Tile, objects: Objects, names: Mapping[str, str]) -> str:
    values = "".join(
        f'<span class="{letter}{" better" if tile.better == letter else ""}">'
        f'<i>{escape(names[letter])}</i><span data-value="{letter}">{escape(value)}</span></span>'
        for letter, value in (("x", tile.x), ("y", tile.y))
    )
    interval = "" if tile.interval is None else phrase(tile.interval, objects)
    chip = f'<span class="chip {tile.winner}">{escape(phrase(tile.chip, objects))}</span>'
    hooks = value_hooks(tile.key, tile.form, is_marked=not tile.is_doubtful)
    return (
        f'<section class="nv-tile" aria-label="{escape(tile.title, quote=True)}"{hooks}>'
        f"<h3>{escape(tile.title)}</h3><p>{escape(tile.unit)}</p>"
        f'<div class="values">{values}</div>'
        f'<p>X − Y &nbsp;<b data-value="difference">{escape(tile.difference)}</b></p>{_bar(tile)}'
        f'<p class="interval">{escape(interval)}</p>{chip}</section>'
    )


def _bar(tile: Tile) -> str:
    """Return an interval as an HTML bar. X is better right of the middle, for any measure."""
    if tile.bar is None:
        return '<div class="bar"></div>'
    low, middle, high = (100 * end for end in tile.bar)
    return (
        '<div class="bar known" title="Left: Y better. Right: X better."><span class="axis"></span>'
        f'<span class="span" style="left:{low:.1f}%;width:{high - low:.1f}%"></span>'
        f'<span class="dot" style="left:{middle:.1f}%"></span></div>'
    )

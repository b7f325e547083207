"""Render sections as one HTML page that works without this program and offline."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from nvcore.common.wording import shortened
from nvcore.figures.style import CONFIG
from nvcore.pictures import picture_address
from nvcore.report.html.charts import figure_json, heading_apart, packed_plotly
from nvcore.report.section import Section, Table, charts_of, true_minus
from nvcore.settings.objects import Objects

TEMPLATES: Final = Path(__file__).parent / "templates"
LONG_WORD: Final = 24
SHORT_NAME: Final = 16
"""Maximum length of a name with hyphens that is kept on one line, in characters."""
SHORT_ROWS: Final = 12
SHORT_SIGNS: Final = 900
CHART_CONFIG: Final = {**CONFIG, "responsive": True}


def render_page(
    template: str,
    objects: Objects,
    *,
    sections: Sequence[Section],
    title: str,
    version: str,
    fingerprint: str,
    **more: Any,
) -> str:
    """Return the HTML of a page. Equal content gives equal bytes.

    Parameters
    ----------
    template
        File of the folder ``templates`` that extends ``base.html``.
    objects
        Words for the objects of the boxes.
    sections
        Sections in order. Names of charts are unique among them.
    version, fingerprint
        Version of the program and fingerprint of its inputs.
    more
        Other variables of the template.
    """
    charts = {}
    for chart in chain.from_iterable(charts_of(section.blocks) for section in sections):
        figure, *heading = heading_apart(chart.draw())
        json = Markup(figure_json(figure))  # noqa: S704  # figure_json escapes it
        charts[chart.name] = (json, *heading)
    nonce = hashlib.sha256(f"{fingerprint} {version}".encode()).hexdigest()[:32]
    return (
        _environment()
        .get_template(template)
        .render(
            sections=[section.worded(objects) for section in sections],
            title=title,
            version=version,
            fingerprint=fingerprint,
            charts=charts,
            plotly=packed_plotly(),
            nonce=nonce,
            config=CHART_CONFIG,
            **more,
        )
    )


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {  # also in the macros of blocks.html
        "picture_address": picture_address,
        "cell_class": _cell_class,
        "is_short": _is_short,
        "css_text": css_text,
    }
    environment.filters |= {"true_minus": true_minus, "number_cell": _number_cell}
    return environment


def css_text(text: str, most: int) -> Markup:
    """Return a safe CSS string of the text, truncated to `most` characters."""
    signs = (
        sign if sign == " " or (sign.isascii() and sign.isalnum()) else f"\\{ord(sign):x} "
        for sign in shortened(text, most)
    )
    return Markup(f'"{"".join(signs)}"')  # noqa: S704  # only letters, digits, escapes


def _number_cell(text: str) -> str:
    """Format a number with a true minus sign and a no-break space before "pp"."""
    return true_minus(text).replace(" pp", "\N{NO-BREAK SPACE}pp")


def _is_short(block: Table) -> bool:
    """Return whether a table is short enough to print without a page break inside."""
    n_signs = sum(len(cell) for row in block.rows for cell in row)
    return len(block.rows) < SHORT_ROWS and n_signs < SHORT_SIGNS


def _cell_class(cell: str, *, is_number: bool) -> str:
    """Return the CSS class that sets a cell's alignment and line breaks.

    Hashes and paths may break anywhere, short names nowhere.
    """
    if is_number:
        return "right between" if " to " in cell else "right"
    if max(map(len, cell.split()), default=0) > LONG_WORD:
        return "long"
    return "whole" if "-" in cell and len(cell) <= SHORT_NAME else ""

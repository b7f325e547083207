"""Arguments of a report."""

from __future__ import annotations

from dataclasses import KW_ONLY, fields
from typing import Final

from nvcore.common.arguments import PathLike, argument, arguments
from nvcore.common.wording import one_line, shortened

REPORT: Final = "Report"
MAX_CHARACTERS: Final = 400
"""Longest title, author or question. An ellipsis replaces the rest."""


@arguments
class Inscription:
    """Texts that the author puts on a report, if not empty. The program adds no date of its own."""

    _: KW_ONLY
    title: str = argument(REPORT, "Title of the report.", default="")
    author: str = argument(REPORT, "Whose report it is.", default="")
    question: str = argument(REPORT, "The question that it answers.", default="")
    date: str = argument(
        REPORT,
        "Its date, in any words; by itself it has none, so that the same inputs give the same "
        "file.",
        default="",
    )

    def in_short(self) -> Inscription:
        """Return the texts as single lines of limited length."""
        short = {
            spec.name: shortened(one_line(getattr(self, spec.name).strip()), MAX_CHARACTERS)
            for spec in fields(Inscription)
        }
        return Inscription(**short)


@arguments
class HtmlArguments(Inscription):
    """See `nvcore.api.comparison.Comparison.write_html`."""

    path: PathLike
    _: KW_ONLY
    stability: bool | None = argument(
        REPORT,
        "Whether to map the verdict over the settings: alpha and midpoint, thresholds, matching, "
        "traffic context, pairing, rules of saliency. Default: for up to 20,000 frames.",
        flag="--stability/--no-stability",
        default=None,
    )
    looks: PathLike | None = argument(
        REPORT,
        "File in which this verdict is recorded, and by which it is corrected for all that were "
        "looked at before (docs/claims.md).",
        metavar="FILE",
        default=None,
    )

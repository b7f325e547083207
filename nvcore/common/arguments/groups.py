"""Arguments of a comparison of groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY
from typing import TYPE_CHECKING, Final, Literal, get_args

import click

from nvcore.common.arguments import INPUTS, PathLike, argument, arguments, pairs_of

if TYPE_CHECKING:
    import pandas as pd

Scale = Literal["times", "counts", "numbers"]
"""Kind of values: times (in the same persons their logarithms are compared), counts (compared by
permutation), or other numbers."""
STUDY: Final = "Study"


@arguments
class GroupArguments:
    """See `nvcore.groups`."""

    table: PathLike | pd.DataFrame
    measure: str | None = argument(
        INPUTS,
        "The column that is compared. Default: value, or the first column of numbers.",
        default=None,
        metavar="COLUMN",
    )
    _: KW_ONLY
    scale: Scale | None = argument(
        INPUTS,
        "What its numbers are. Default: times where its name ends in a unit of time (_s, _ms, "
        "_min), counts where all are whole numbers from 0 to 99.",
        default=None,
        type=click.Choice(get_args(Scale)),
    )
    kind: str | None = argument(
        INPUTS,
        "Count only rows of this kind, by the column kind. Default: of all kinds together.",
        default=None,
        metavar="KIND",
    )
    rename: Mapping[str, str] | None = argument(
        INPUTS,
        "Another name for a condition; conditions of one name are compared as one, and one without "
        "a name (control=) is left out; {again}.",
        default=None,
        multiple=True,
        metavar="CONDITION=NAME",
        callback=pairs_of,
    )
    leave_out: Sequence[str] = argument(
        INPUTS,
        "Without this participant; {again}.",
        default=(),
        multiple=True,
        metavar="PARTICIPANT",
    )
    correlation: float | None = argument(
        STUDY,
        "Of means and SD: what paired comparisons would show if the same persons stood in all "
        "conditions, and their values in two conditions had this correlation.",
        default=None,
        type=click.FloatRange(-1, 1),
        metavar="R",
    )
    difference: float | None = argument(
        STUDY,
        "The smallest difference that would matter, in the unit of the measure, for the size of a "
        "further study. Default: the largest one found.",
        default=None,
        type=click.FloatRange(0, min_open=True),
        metavar="D",
    )
    power: float = argument(
        STUDY,
        "Share of studies that should show it.",
        default=0.8,
        type=click.FloatRange(0.5, 0.99),
    )

"""Wording shared by all outputs: numbers, differences, counts, names from files.

One function per target escapes untrusted text: `one_line` for terminals and text files,
`markdown_text` for Markdown, `figures.style.plain` for Plotly. Jinja escapes HTML.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Sequence
from difflib import get_close_matches
from typing import Final

UNDEFINED: Final = "–"
MOST_NAMED: Final = 5
"""Maximum number of names in an error. The others are counted."""
MORE_DECIMALS: Final = 3
"""Maximum number of decimals of a difference beyond those of its values."""
ARROWS: Final = {"higher": " ↑", "lower": " ↓", "": ""}
"""Suffix of a label that shows the better direction."""

_SHORT_WORD: Final = 3
"""Maximum length of words in a name that are not checked for misspellings, in letters."""
_MARKUP: Final = re.compile(r"([\\`*_{}\[\]<>()#+.!|$~:&^=@-])")


def number(value: float | None, form: str) -> str:
    """Format a number with commas between thousands, or as a dash if it is undefined.

    Examples
    --------
    >>> number(2439.4, ".0f"), number(0.31, "+.1f")
    ('2,439', '+0.3')
    >>> number(0.6274, ".1%")
    '62.7 %'
    """
    if value is None or math.isnan(value):
        return UNDEFINED
    digits = form.lstrip("+z")
    value = int(value) if form.endswith("d") else value
    return format(value, f"{form.removesuffix(digits)},{digits}").replace("%", " %")


def difference(x: float, y: float, form: str) -> str:
    """Format X - Y with a sign, shares in percentage points. A dash if either is undefined.

    It is rounded once, so that it does not depend on the decimals shown for X and Y. If it rounds
    to 0 although X and Y look different, it has up to `MORE_DECIMALS` more decimals than they.

    Examples
    --------
    >>> difference(0.0184, 0.0156, ".3f")
    '+0.003'
    >>> difference(0.0046, 0.0068, ".1%")
    '-0.2 pp'
    >>> difference(0.00184, 0.00176, ".3f")
    '0.000'
    >>> difference(2.649, 2.651, ".1f")
    '-0.002'
    """
    if math.isnan(x) or math.isnan(y):
        return UNDEFINED
    if form == "d":
        return format(x - y, "+,d") if x != y else "0"
    unit, scale = (" pp", 100) if form.endswith("%") else ("", 1)
    form_of_text = form.replace("%", "f")
    are_alike = format(x, f"z{form}") == format(y, f"z{form}")
    for _ in range(1 + MORE_DECIMALS):
        text = format((x - y) * scale, f"+z,{form_of_text}")
        if float(text.replace(",", "")):
            return text + unit
        if are_alike:
            break
        form_of_text = f".{int(form_of_text[1:-1]) + 1}f"
    return text[1:] + unit


def minus(text: str) -> str:
    """Return the text with hyphens replaced by minus signs, which are as wide as a plus.

    Examples
    --------
    >>> minus("-0.2 to +0.1")
    '−0.2 to +0.1'
    """
    return text.replace("-", "−")


def rounded_form(form: str, width: float) -> str:
    """Reduce the decimals of a format to what an interval of this width supports.

    Examples
    --------
    >>> rounded_form(".4f", 0.06)
    '.3f'
    >>> rounded_form(".1%", 0.4)
    '.0%'
    """
    decimals, kind = form[1:-1], form[-1]
    half = width / 2 * (100 if kind == "%" else 1)
    if form[:1] != "." or not decimals.isdigit() or not half > 0 or not math.isfinite(half):
        return form
    decimals_left = max(0, 1 - math.floor(math.log10(half)))
    return f".{min(int(decimals), decimals_left)}{kind}"


def count_text(n: int, noun: str, plural: str | None = None) -> str:
    """Format a count with its noun: "1 frame", "3,000 frames". Default `plural`: `noun` + s."""
    return f"{n:,} {noun if n == 1 else plural or noun + 's'}"


def aligned(rows: Iterable[Sequence[str]], right: Collection[int] | None = None) -> list[str]:
    """Format rows of cells as lines.

    Parameters
    ----------
    right
        Indices of the right-aligned columns. None: all but the first.
    """
    shown = [tuple(one_line(cell) for cell in row) for row in rows]
    columns = []
    for index, column in enumerate(zip(*shown, strict=True)):
        is_right = index > 0 if right is None else index in right
        align, width = str.rjust if is_right else str.ljust, max(map(len, column))
        columns.append([align(cell, width) for cell in column])
    return ["  ".join(cells).rstrip() for cells in zip(*columns, strict=True)]


def interval_text(low: float, high: float, form: str) -> str:
    """Format an interval of a difference as in `difference`, or as a dash if it is undefined."""
    if math.isnan(low) or math.isnan(high):
        return UNDEFINED
    return f"{difference(low, 0, form)} to {difference(high, 0, form)}"


def p_value(p: float) -> str:
    """Format a p-value for a table: "0.18", "< 0.001"."""
    return "< 0.001" if p < 0.001 else f"{p:.2g}"


def p_text(p: float, p_corrected: float) -> str:
    """Format p, with the corrected p if it differs.

    For example: "p = 0.18; 0.6 after correction".
    """
    own = f"p {'' if p < 0.001 else '= '}{p_value(p)}"
    return own if p == p_corrected else f"{own}; {p_value(p_corrected)} after correction"


def percent(share: float) -> str:
    """Format a share for a sentence, such as ``80 %``."""
    return f"{100 * share:.0f} %"


LEAST_HOURLY_S: Final = 600.0
"""Minimum duration for rates per hour, seconds. Shorter durations are shown in seconds."""


def duration_text(seconds: float) -> str:
    """Format a duration in seconds, minutes or hours: "7.2 s", "90 s", "55 min", "2.4 h"."""
    if 1 <= seconds < 10:
        return f"{seconds:.1f}".removesuffix(".0") + " s"
    if seconds < LEAST_HOURLY_S:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:,.1f} h"


def capitalised(text: str) -> str:
    """Capitalize only the first letter of a text, as at the beginning of a sentence."""
    return text[:1].upper() + text[1:]


def listed(words: Sequence[str], *, most: int | None = None) -> str:
    """Join words as an enumeration for a sentence.

    Parameters
    ----------
    most
        Maximum number of named words. The others are counted, but a single one is named. None: all.

    Examples
    --------
    >>> listed(["alpha", "IoU", "midpoint"])
    'alpha, IoU and midpoint'
    >>> listed(["alpha", "IoU", "midpoint"], most=1)
    'alpha and 2 more'
    """
    if most is not None and len(words) > most + 1:  # "1 more" would say less than the name
        words = [*words[:most], f"{len(words) - most:,} more"]
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def did_you_mean(name: str, names: Iterable[str], sentence: str) -> str:
    """Prepend "did you mean ...?" to a sentence that lists all names, if one name is similar.

    A name of several words (``trees_per_round``) is also close if one of its words is.

    Examples
    --------
    >>> did_you_mean("threes", ["trees_per_round", "threshold"], "there are two")
    "did you mean 'trees_per_round'? There are two"
    """
    every = [*names]
    words = [(word, known) for known in every for word in known.lower().split("_")]
    known_as = {word: known for word, known in reversed(words) if len(word) > _SHORT_WORD}
    known_as |= {known: known for known in every}
    close = [known_as[text] for text in get_close_matches(name, known_as, n=1)]
    return f"did you mean {close[0]!r}? {capitalised(sentence)}" if close else sentence


def one_line(text: str) -> str:
    r"""Return the text as one harmless line, with characters that control a terminal escaped.

    Names of files, recordings and systems come from outside. They must not move the cursor, set a
    colour or start a line of their own.

    Examples
    --------
    >>> one_line("V000\x1b[31m")
    'V000\\x1b[31m'
    """
    return "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text
    )


def markdown_text(text: object) -> str:
    r"""Escape a text so that Markdown shows it literally on one line, without mentions.

    Examples
    --------
    >>> markdown_text("*a*_1")
    '\\*a\\*\\_1'
    """
    return _MARKUP.sub(r"\\\1", one_line(str(text)))


def shortened(text: str, most: int, *, mark: str = "…") -> str:
    """Truncate the text to `most` characters, ending with the mark if anything is cut off.

    Examples
    --------
    >>> shortened("pedestrian", 5)
    'pede…'
    """
    return text if len(text) <= most else text[: most - len(mark)] + mark


def fold_name(participant: str) -> str:
    """Return a name for comparison, the same in whatever capitals and spaces it is typed.

    Examples
    --------
    >>> fold_name(" Anna  K") == fold_name("anna k")
    True
    """
    return " ".join(participant.split()).casefold()

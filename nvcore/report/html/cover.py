"""First page of the report: a summary for readers who stop there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import pandas as pd

from nvcore.common.arguments.report import Inscription
from nvcore.common.wording import count_text, duration_text, one_line
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import count_recordings
from nvcore.evidence.claims import values_of
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import alarms_as_set, are_unequal, point_note
from nvcore.evidence.units import MIN_RECORDINGS
from nvcore.notes import Note, phrase
from nvcore.report.remarks import all_remarks
from nvcore.report.section import Photo
from nvcore.report.tiles import Tile, tiles
from nvcore.report.verdict import Verdict
from nvcore.report.words import n_frames_text, sampling_note
from nvcore.settings.objects import Objects

N_PHOTOS: Final = 2


@dataclass(frozen=True)
class Cover:
    """Contents of the report's first page.

    Attributes
    ----------
    subtitle
        Names of the compared systems; empty if the title has them.
    byline
        Author and date.
    question
        Question that the report answers.
    headline
        Headline of the verdict.
    facts
        Labels and texts that describe X, Y and the data.
    tiles
        Summary of the comparison, without measures that are 0 for both.
    basis
        Comparison that the tiles are about, and measures that are 0 for both.
    photos
        The two most informative frames.
    limits
        Limits of the data.
    objects
        Kind of objects in the boxes.
    """

    subtitle: str
    byline: str
    question: str
    headline: str
    facts: tuple[tuple[str, str], ...]
    tiles: tuple[Tile, ...]
    basis: str
    photos: tuple[Photo, ...]
    limits: tuple[str, ...]
    objects: Objects

    def say(self, note: Note | None) -> str:
        """Render a tile's note without capitalizing it. None gives ""."""
        return "" if note is None else phrase(note, self.objects)


def cover_of(
    result: Result,
    conclusion: Verdict,
    evidence: pd.DataFrame,
    companions: Companions,
    photos: Sequence[Photo],
    inscription: Inscription,
    names: str,
) -> Cover:
    """Return the contents of the report's first page.

    Parameters
    ----------
    photos
        Evidence frames, the most informative first.
    names
        Names of the compared systems, in a few words.
    """
    of_both = tiles(result, evidence, companions)
    zero = [tile for tile in of_both if values_of(tile.key, result) == (0, 0)]
    alike = f"0 for both: {', '.join(tile.title.lower() for tile in zero)}." if zero else ""
    return Cover(
        subtitle=names if inscription.title else "",
        byline=", ".join(filter(None, (inscription.author, inscription.date))),
        question=inscription.question,
        headline=conclusion.say(conclusion.headline),
        facts=_facts(result),
        tiles=tuple(tile for tile in of_both if tile not in zero),
        basis=" ".join(filter(None, (alike, conclusion.say(point_note(result))))),
        photos=_two_kinds(photos),
        limits=_limits(result, conclusion),
        objects=result.objects,
    )


def _facts(result: Result) -> tuple[tuple[str, str], ...]:
    thresholds = [
        (
            letter.upper(),
            one_line(system.name)
            + (
                ", every detection counts"
                if system.threshold is None
                else f", detections with a score of {system.threshold:g} or more"
            ),
        )
        for letter, system in result.sides
    ]
    extent = (
        f"{count_text(count_recordings(result), 'recording')}, "
        f"{n_frames_text(result, 'evaluated frame')}, {duration_text(result.duration_s)}, "
        f"{int(result.n_truth.sum()):,} {result.objects.singular} boxes; "
        f"{count_text(result.venn.n_near, 'encounter')} that count, "
        f"{result.venn.distant:,} too far away to count"
    )
    return (*thresholds, ("Data", extent))


def _two_kinds(photos: Sequence[Photo]) -> tuple[Photo, ...]:
    """Return the first frame and, if there is one, the first with another title.

    Otherwise the first two frames.
    """
    others = [photo for photo in photos[1:] if photo.title != photos[0].title] or photos[1:]
    return (*photos[:1], *others[: N_PHOTOS - 1])


def _limits(result: Result, conclusion: Verdict) -> tuple[str, ...]:
    n = count_recordings(result)
    scope = Note("sections.scope", n=n, n_needed=MIN_RECORDINGS)
    points = [
        conclusion.say(*point.notes)
        for point in conclusion.points
        if point.topic in ("More recordings", "Thresholds")
    ]
    as_set = None
    if are_unequal(result):
        as_set = Note("verdict.unequal_comparison", alarms=alarms_as_set(result))
    return tuple(
        filter(
            None,
            (
                conclusion.say(conclusion.doubt),
                conclusion.say(as_set),
                conclusion.say(Note("sections.short_encounters")) if result.is_short else "",
                *(conclusion.say(*remarks.limits(result)) for remarks in all_remarks()),
                conclusion.say(scope),
                *points,
                sampling_note(result.dataset.frame_columns),
            ),
        )
    )

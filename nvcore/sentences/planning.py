"""What a plan has to say: facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.measures.table import difference_text, size_text
from nvcore.sentences.facts import Amount, Fact
from nvcore.sentences.texts import Texts


@dataclass(frozen=True)
class Apart:
    """A difference X - Y in a measure of `nvcore.measures.table.EVIDENCE_KEYS`."""

    value: float
    key: str

    def __str__(self) -> str:
        return difference_text(self.value, self.key)

    @property
    def size(self) -> str:
        """Without its sign."""
        return size_text(self.value, self.key)


@dataclass(frozen=True)
class Found(Fact):
    """What the recordings show of a measure; p is by itself, None without one.

    Attributes
    ----------
    unit
        In the singular: ``recording`` or ``block``.
    """

    label: str
    x: Amount
    y: Amount
    difference: str
    n: int
    unit: str
    n_encounters: int
    p: float | None

    @property
    def kind(self) -> str:
        """Whether there is a p."""
        return "untested" if self.p is None else "tested"


@dataclass(frozen=True)
class FewDiffer(Fact):
    """That X and Y differ in so few recordings only."""

    n: int


@dataclass(frozen=True)
class Excluded(Fact):
    """Which differences the 95 % interval excludes.

    Attributes
    ----------
    kind
        ``blocks``: none, as blocks of time say nothing of other recordings; ``none``: there is no
        interval. ``some``; ``also 0``: the interval is on one side of it.
    """

    kind: Literal["blocks", "none", "some", "also 0"]
    n: int = 0
    low: Apart | None = None
    high: Apart | None = None
    reason: str = ""


@dataclass(frozen=True)
class NotWorse(Fact):
    """Whether the candidate is at most the margin worse.

    Attributes
    ----------
    kind
        ``open``: it cannot be said. Else whether it is shown, and on which side of 0 the interval
        ends.
    worse_at_most
        End of the interval; negative: better.
    """

    kind: Literal["open", "shown worse", "shown better", "not shown worse", "not shown better"]
    candidate: str
    other: str
    margin: Apart
    worse_at_most: Apart | None = None
    reason: str = ""


@dataclass(frozen=True)
class Sought(Fact):
    """What a study is to show: a difference as ``found`` here or as ``named``, or no more than one.

    Attributes
    ----------
    candidate
        The system that is to be at most so much worse.
    """

    kind: Literal["found", "named", "margin"]
    apart: Apart
    candidate: str = ""


@dataclass(frozen=True)
class Assumed(Fact):
    """What is assumed of the true difference: that X and Y are ``equal``, or as ``found`` here."""

    kind: Literal["equal", "found"]
    apart: Apart


@dataclass(frozen=True)
class StudyExtent(Fact):
    """Size of a study."""

    n_recordings: int
    n_encounters: int
    duration_s: float


@dataclass(frozen=True)
class Size(Fact):
    """How large a study has to be.

    Attributes
    ----------
    assumed
        None: what is sought.
    extent
        None: there is none, `reason` says why.
    power, simulated
        Wanted share of studies that show it, and that of simulated ones with its interval.
    n_pilot
        Recordings that it is judged by.
    least, most
        Range of recordings that these leave open.
    """

    sought: Sought
    assumed: Assumed | None
    extent: StudyExtent | None = None
    power: float = 0.0
    simulated: tuple[float, float, float] = (0.0, 0.0, 0.0)
    n_pilot: int = 0
    least: int = 0
    most: int = 0
    reason: str = ""

    @property
    def kind(self) -> str:
        """Whether there is a size."""
        if self.extent is None:
            return "none" if self.assumed is None else "none assumed"
        return "some"


@dataclass(frozen=True)
class SignificanceLevel(Fact):
    """When a study shows it: a ``margin``, a difference by itself (``alone``) or beside others."""

    kind: Literal["margin", "alone", "corrected"]
    n_tests: int = 1
    level: float = 0.0


@dataclass(frozen=True)
class Advice(Fact):
    """What to know of the size of a study.

    Attributes
    ----------
    kind
        ``unequal`` operating points; that a difference as found is ``optimistic``; that the study
        is a ``fresh`` one.
    """

    kind: Literal["unequal", "optimistic", "fresh"]


@dataclass(frozen=True)
class NeededRecordings(Fact):
    """How many recordings would show a difference as found, for the verdict."""

    extent: StudyExtent
    noun: str
    apart: Apart
    significant: float
    power: float


UNEQUAL_POINTS: Final = "X and Y are set to different operating points"

TEXTS: Final[Texts] = {
    Found: {
        "tested": "{label}: X {x}, Y {y}, X - Y {difference}, in {n} {unit}s with "
        "{n_encounters!n:encounter}; p = {p:.2g} by itself.",
        "untested": "{label}: X {x}, Y {y}, X - Y {difference}, in {n} {unit}s with "
        "{n_encounters!n:encounter}.",
    },
    FewDiffer: "X and Y differ in only {n} of the recordings: all that follows rests on these.",
    Excluded: {
        "blocks": "no difference can be excluded for other recordings: stretches of these say "
        "nothing of others.",
        "none": "no difference can be excluded: {reason}.",
        "some": "at 95 %, these {n!n:recording} exclude a difference X - Y below {low} or above "
        "{high}.",
        "also 0": "at 95 %, these {n!n:recording} exclude a difference X - Y below {low} or above "
        "{high} (in this measure by itself, not corrected for the others).",
    },
    NotWorse: {
        "open": "it cannot be said that {candidate!u} is at most {margin.size} worse than "
        "{other!u}: {reason}.",
        "shown worse": "it is shown that {candidate!u} is at most {margin.size} worse than "
        "{other!u}: by the 95 % interval, it is at worst {worse_at_most.size} worse.",
        "shown better": "it is shown that {candidate!u} is at most {margin.size} worse than "
        "{other!u}: by the 95 % interval, it is at least {worse_at_most.size} better.",
        "not shown worse": "it is not shown that {candidate!u} is at most {margin.size} worse than "
        "{other!u}: by the 95 % interval, it may be {worse_at_most.size} worse.",
        "not shown better": "it is not shown that {candidate!u} is at most {margin.size} worse "
        "than {other!u}, though by the 95 % interval it is at least {worse_at_most.size} better.",
    },
    Sought: {
        "found": "a difference as found here ({apart})",
        "named": "a difference of {apart.size}",
        "margin": "that {candidate!u} is at most {apart.size} worse",
    },
    Assumed: {
        "equal": "if X and Y are equal",
        "found": "if the difference is as found here ({apart})",
    },
    StudyExtent: "{n_recordings!n:recording} like these ({n_encounters!n:encounter}, "
    "{duration_s!d})",
    Size: {
        "some": "{assumed:, }about {extent} would show {sought} in {power!p} of studies "
        "(simulated: {simulated[0]!p}, {simulated[1]!p} to {simulated[2]!p}). Judged by "
        "{n_pilot!n:recording}, that number is itself uncertain: {least:,} to {most:,}.",
        "none": "{sought}: – ({reason}).",
        "none assumed": "{assumed}: – ({reason}).",
    },
    SignificanceLevel: {
        "margin": "a study shows it where the whole 95 % interval is on the better side of the "
        "margin: a one-sided test at 2.5 %.",
        "alone": "a study shows it where p, of this measure by itself, is at most 0.05: tested "
        "beside others, for which p is corrected, it takes more recordings.",
        "corrected": "a study shows it where p, corrected for {n_tests} measures, is at most 0.05 "
        "({level:.2g} by itself).",
    },
    Advice: {
        "unequal": f"{UNEQUAL_POINTS}: nothing is claimed from these settings, and equally many "
        "false alarms would give other numbers. Set thresholds that give these first.",
        "optimistic": "a difference that a few recordings happen to show tends to be larger than "
        "the true one, and the study planned for it too small: name the smallest difference that "
        "would matter instead.",
        "fresh": "this is the size of a study of its own, whose end is set before it begins: "
        "recordings added until p is small enough show differences that are not there.",
    },
    NeededRecordings: "about {extent} would show a difference in the {noun} as large as here "
    "({apart}; p at most {significant:g} by itself) in {power!p} of studies.",
}

"""What there is to say of the encounters that X and Y miss or match: facts, and how they are said.

The terminal has a line of its own for each, with all of its numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts


@dataclass(frozen=True)
class Missed(Fact):
    """How many encounters X, Y and both do not detect; Jaccard index and phi, NaN undefined.

    Attributes
    ----------
    kind
        ``nobody`` came near enough to count; ``none`` is missed; misses are all ``exclusive``, all
        the ``same``, or ``some`` are.
    """

    n: int
    by_x: int
    by_y: int
    by_both: int
    jaccard: float
    phi: float

    @property
    def n_missed(self) -> int:
        """By one system at least."""
        return self.by_x + self.by_y - self.by_both

    @property
    def kind(self) -> str:
        """Whom they miss."""
        if not self.n:
            return "nobody"
        if not self.n_missed:
            return "none"
        if not self.by_both:
            return "exclusive"
        return "same" if self.by_both == self.n_missed else "some"

    @property
    def phi_text(self) -> str:
        """Phi; a dash where it is undefined."""
        return "–" if math.isnan(self.phi) else f"{self.phi:.2f}"

    @property
    def jaccard_text(self) -> str:
        """The Jaccard index; a dash where it is undefined."""
        return "–" if math.isnan(self.jaccard) else f"{self.jaccard:.2f}"


@dataclass(frozen=True)
class Correlated(Fact):
    """How the misses of X and Y correlate, or that these are too ``few`` to say."""

    kind: Literal["few", "known"]
    phi: float


@dataclass(frozen=True)
class Parted(Fact):
    """Encounters that only one system detects, and whether they are split by chance.

    Attributes
    ----------
    kind
        ``none``; as many each (``even``); encounters are ``short``, so that single ones are not
        tested; too few for a test (``untested``); ``uneven``, or ``chance``: p of McNemar's exact
        test.
    is_as_set
        Whether operating points are unequal.
    """

    kind: Literal["none", "even", "short", "untested", "uneven", "chance"]
    x: int
    y: int
    p: float
    is_as_set: bool

    @property
    def split(self) -> ExclusiveEncounters:
        """How they are split."""
        n = self.x + self.y
        return ExclusiveEncounters("many" if n > 1 else "x" if self.x else "y", n, self.x, self.y)

    @property
    def test(self) -> Test | None:
        """The test; None without p."""
        return None if math.isnan(self.p) else Test("set" if self.is_as_set else "equal", self.p)


@dataclass(frozen=True)
class ExclusiveEncounters(Fact):
    """Encounters that only one system detects; a single one by ``x`` or ``y``."""

    kind: Literal["many", "x", "y"]
    n: int
    x: int
    y: int


@dataclass(frozen=True)
class Test(Fact):
    """McNemar's exact test within these drives, at ``equal`` false alarms or as ``set``."""

    kind: Literal["equal", "set"]
    p: float


@dataclass(frozen=True)
class Lead(Fact):
    """Which system matches a pedestrian first, where both match him; seconds, positive: X first.

    Attributes
    ----------
    kind
        ``none`` is matched by both. ``neither`` leads; nor ``usually`` (the median is 0, not the
        mean); mean and median point ``apart``; or they do not (``clear``).
    """

    kind: Literal["none", "neither", "usually", "apart", "clear"]
    n: int = 0
    x: int = 0
    y: int = 0
    mean_s: float = 0.0
    median_s: float = 0.0

    @property
    def n_together(self) -> int:
        """Matched by both at the same time."""
        return self.n - self.x - self.y


@dataclass(frozen=True)
class NoFusion(Fact):
    """That no encounter counts, so that a fusion gains and loses none."""


@dataclass(frozen=True)
class Gain(Fact):
    """Encounters that a fusion detects beyond those of the better single system (`best`)."""

    kind: Literal["more", "fewer", "same"]
    n: int
    best: str


@dataclass(frozen=True)
class MoreEpisodes(Fact):
    """False-alert episodes that a fusion has beyond those of a single system."""

    kind: Literal["more", "fewer", "same"]
    n: int


@dataclass(frozen=True)
class Fused(Fact):
    """What a fusion gains and costs against the better single system."""

    kind: Literal["x_or_y", "x_and_y"]
    detected: int
    n: int
    gain: Gain
    cost: MoreEpisodes


@dataclass(frozen=True)
class ClassesRead(Fact):
    """How many matches of a system have the truth's class, with Wilson's 95 % interval.

    Attributes
    ----------
    kind
        The system names ``no classes``; no match has one (``none``); or shares are ``known``.
    """

    kind: Literal["no classes", "none", "known"]
    letter: str
    n: int = 0
    share: float = 0.0
    low: float = 0.0
    high: float = 0.0


_LEAD: Final = (
    "of {n!n:encounter} that both match, X matches {x} first, Y {y}, and both match "
    "{fact.n_together} at the same time. X's lead is {mean_s:+z.2f} s on average, median "
    "{median_s:+z.2f} s"
)
_MISSED: Final = (
    "of {n} encounters that count, X does not detect {by_x} and Y does not detect {by_y}"
)
_FUSED: Final = "detects {detected} of {n!n:encounter}, {gain}, and {cost}."
_JACCARD: Final = "(Jaccard index {jaccard:.2f})."

TEXTS: Final[Texts] = {
    Missed: {
        "nobody": "no {one} came near enough to count, so there is nothing to miss.",
        "none": "neither system misses any of the {n} encounters that count.",
        "exclusive": f"{_MISSED}; no encounter is missed by both: all {{fact.n_missed}} misses are "
        f"exclusive {_JACCARD}",
        "same": f"{_MISSED}; they miss the same {{by_both}} {_JACCARD}",
        "some": f"{_MISSED}; {{by_both}} of the {{fact.n_missed}} that at least one misses are "
        f"missed by both {_JACCARD}",
    },
    Correlated: {
        "few": "too few misses to say whether those of X and Y go together (phi {phi:+.2f}).",
        "known": "the correlation of their misses is phi {phi:+.2f} (0: a miss of one says nothing "
        "about the other; 1: both miss the same {many}; below 0: one tends to detect those that "
        "the other misses).",
    },
    Parted: {
        "none": "no encounter is detected by one system alone: none tells the two apart.",
        "even": "{fact.split}: in this they do not differ.",
        "short": "{fact.split}. Most encounters are one frame long and not independent, so no test "
        "of single encounters is given.",
        "untested": "{fact.split}: too few to test.",
        "uneven": "{fact.split}: so uneven a split would be unlikely if each of them fell to "
        "either system by chance (exact McNemar test within these drives, p = {p:.2g}; whether "
        "other drives would show it is judged by recordings).",
        "chance": "{fact.split}: two equally good systems could well differ this much by chance "
        "(exact McNemar test within these drives, p = {p:.2g}).",
    },
    ExclusiveEncounters: {
        "many": "of the {n} encounters that only one system detects, X detects {x} and Y {y}",
        "x": "only one encounter is detected by a single system, by X",
        "y": "only one encounter is detected by a single system, by Y",
    },
    Lead: {
        "none": "no encounter is matched by both systems, so there is no lead time.",
        "neither": f"{_LEAD}: neither leads.",
        "usually": f"{_LEAD}: in the middle neither leads; the mean comes from those that differ.",
        "apart": f"{_LEAD}: the two point in different directions, so neither leads clearly.",
        "clear": f"{_LEAD}.",
    },
    NoFusion: "no {one} came near enough to count, so a fusion can neither gain nor lose.",
    Gain: {
        "more": "{n} more than {best!u} alone",
        "fewer": "{n} fewer than {best!u} alone",
        "same": "as many as {best!u} alone",
    },
    MoreEpisodes: {
        "more": "costs {n!n:false-alert episode}",
        "fewer": "saves {n!n:false-alert episode}",
        "same": "has as many false-alert episodes",
    },
    Fused: {
        "x_or_y": f"\u201cX or Y\u201d {_FUSED}",
        "x_and_y": f"\u201cX and Y\u201d {_FUSED}",
    },
    ClassesRead: {
        "no classes": "{letter!u} names no classes.",
        "none": "{letter!u}: – (no match has a class).",
        "known": "{letter!u}: {share:.1%} of {n!n:match/matches} right, 95 % interval {low:.1%} to "
        "{high:.1%} (Wilson; as if boxes were independent).",
    },
}
_NOT_DETECTED: Final = (
    "encounters not detected: {by_x} by X, {by_y} by Y, of these {by_both} by both (Jaccard "
    "{fact.jaccard_text}, phi {fact.phi_text})"
)
_FIRST: Final = (
    "lead time, in {n!n:encounter} that both match: X is first in {x}, Y in {y}, both at the same "
    "time in {fact.n_together}; X leads by {mean_s:+.2f} s on average, median {median_s:+.2f} s"
)
TERMINAL: Final[Texts] = {
    Missed: dict.fromkeys(("nobody", "none", "exclusive", "same", "some"), _NOT_DETECTED),
    Parted: {
        "none": "; none tells the two systems apart",
        **dict.fromkeys(
            ("even", "short", "untested", "uneven", "chance"),
            "; X alone detects {x}, Y alone {y}{fact.test}",
        ),
    },
    Test: {
        "equal": " (McNemar's exact p within these drives = {p:.2g})",
        "set": " (as set, at unequal operating points: McNemar's exact p within these drives = "
        "{p:.2g})",
    },
    Lead: {
        "none": "lead time: no encounter is matched by both systems",
        **dict.fromkeys(("neither", "usually", "apart", "clear"), _FIRST),
    },
}
"""Lines of the terminal's report."""

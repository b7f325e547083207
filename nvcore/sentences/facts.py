"""What a verdict has to say, as facts: kinds and numbers, without a sentence.

Systems are ``x`` and ``y``. Where the text of a fact depends on more than its type, its ``kind``
chooses it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nvcore.notes import Fact as Fact
from nvcore.wording import number, p_text


@dataclass(frozen=True)
class Amount:
    """A number with its format (``d``: a whole number) and the unit that follows it."""

    value: float
    form: str
    unit: str = ""

    @property
    def number(self) -> str:
        """Without the unit."""
        return number(int(self.value) if self.form == "d" else self.value, self.form)

    def __str__(self) -> str:
        return self.number + self.unit


@dataclass(frozen=True)
class P:
    """A p by itself, and corrected for what is tested together."""

    p: float
    corrected: float

    def __str__(self) -> str:
        return p_text(self.p, self.corrected)


@dataclass(frozen=True)
class Named(Fact):
    """A measure of `nvcore.measures.table.EVIDENCE_KEYS`."""

    key: str


@dataclass(frozen=True)
class BetterMeasure(Named):
    """Such a measure with the value of the better system and of the other."""

    better: Amount
    other: Amount


@dataclass(frozen=True)
class OfBoth(Named):
    """Such a measure with the values of X and Y."""

    x: Amount
    y: Amount


@dataclass(frozen=True)
class Better(Fact):
    """In what a system is better."""

    winner: str
    won: tuple[Named, ...]


@dataclass(frozen=True)
class Conclusion(Fact):
    """What the tests come to.

    Attributes
    ----------
    kind
        ``claimed``: differences are more than chance. ``untested``: nothing is. ``pending``: not
        yet compared at equal false alarms. ``few``: fewer recordings than a p needs; ``within``:
        so few, but with differences that are clear within them. ``untestable``: no measure has a p;
        ``unsure``: for want of false alarms at equal ones. ``withheld``: each small p fails another
        check. ``not shown``: none is small enough; ``primary not shown``: that of the primary
        measure is not.
    n_recordings, noun
        Behind the tests, and what they are: ``recording`` or ``unit``.
    better
        In what which system is better, the clearest difference first.
    primary
        The primary measure.
    n_needed
        Recordings that a p needs.
    remarks
        Of subjects, about the measures.
    """

    kind: Literal[
        "claimed", "untested", "pending", "few", "within", "untestable", "unsure", "withheld",
        "not shown", "primary not shown",
    ]  # fmt: skip
    n_recordings: int = 0
    better: tuple[Better, ...] = ()
    primary: Named | None = None
    n_needed: int = 0
    remarks: tuple[Fact, ...] = ()
    noun: str = "recording"


@dataclass(frozen=True)
class Headline(Fact):
    """What is claimed, or that nothing is, and why.

    Attributes
    ----------
    kind
        How X and Y are set: ``alike``; unequally, and compared at ``equal`` false alarms instead;
        not yet compared so (``pending``); or not to be, as there is no such ``threshold``, or are
        no ``scores``. ``same boxes``, ``truth as system``, ``wrong inputs``: the audit says that
        there is no comparison.
    """

    kind: Literal[
        "alike", "equal", "pending", "threshold", "scores",
        "same boxes", "truth as system", "wrong inputs",
    ]  # fmt: skip
    conclusion: Conclusion | None = None


@dataclass(frozen=True)
class Question(Fact):
    """The primary measure, and how it is tested.

    Attributes
    ----------
    kind
        It is the ``default``, was ``chosen`` before a verdict was shown, or ``changed`` after one;
        it is ``untested``: it has no p here.
    when
        When it was chosen.
    """

    kind: Literal["default", "chosen", "changed", "untested"]
    primary: Named
    when: str = ""


@dataclass(frozen=True)
class AtBest(Fact):
    """What so many recordings or units (`noun`) could show at best, before they are looked at.

    Attributes
    ----------
    kind
        Nothing of others (``none``), for `n_needed` are; or only a difference for one system in
        ``all`` of them.
    """

    kind: Literal["none", "all"]
    n: int
    noun: str
    n_needed: int


@dataclass(frozen=True)
class AsSet(Fact):
    """False alarms per frame of X and Y as set, where these are unequal.

    Attributes
    ----------
    kind
        Said of a ``comparison``, from which nothing is claimed; of the ``numbers`` of the verdict,
        or ``above`` others; or of a ``rule`` about it.
    """

    kind: Literal["comparison", "numbers", "above", "rule"]
    x: float
    y: float


@dataclass(frozen=True)
class EqualAlarmsSetting(Fact):
    """How X and Y are set to equal false alarms: the system that is moved, and its threshold."""

    moved: str
    threshold: float | None
    per_frame: float

    @property
    def kind(self) -> str:
        """Whether a threshold leaves detections out."""
        return "all" if self.threshold is None else "some"


@dataclass(frozen=True)
class AtEqualAlarms(Fact):
    """How X and Y are set in a comparison at equal false alarms.

    Attributes
    ----------
    kind
        Said ``above`` its numbers; of the ``numbers`` of the verdict; or of its ``claims`` alone.
    """

    kind: Literal["above", "numbers", "claims"]
    setting: EqualAlarmsSetting


@dataclass(frozen=True)
class Tested(Fact):
    """p of a difference by recordings; None: too few of them, or of false alarms (`is_unsure`)."""

    n: int
    p: P | None
    noun: str = "recording"
    is_unsure: bool = False

    @property
    def kind(self) -> str:
        """Whether there is a p."""
        if self.p is not None:
            return "tested"
        return "unsure" if self.is_unsure else "untestable"


@dataclass(frozen=True)
class Split(Fact):
    """Encounters by who detects them, and whether the difference is more than chance."""

    n: int
    both: int
    x_only: int
    y_only: int
    test: Tested | None = None

    @property
    def kind(self) -> str:
        """How the encounters overlap."""
        if not self.n:
            return "none"
        if self.x_only and self.y_only:
            return "apart"
        return "x" if self.x_only else "y" if self.y_only else "same"

    @property
    def n_apart(self) -> int:
        """Those that only one system detects."""
        return self.x_only + self.y_only


@dataclass(frozen=True)
class Cost(Fact):
    """What encounters that one system alone detects weigh for the other."""

    finder: str
    loser: str
    n: int
    seconds: float

    @property
    def kind(self) -> str:
        """Whether it is one encounter."""
        return "one" if self.n == 1 else "many"


@dataclass(frozen=True)
class EncounterWeights(Fact):
    """What the encounters weigh that only one system detects."""

    costs: tuple[Cost, ...]


@dataclass(frozen=True)
class WorstFailure(Fact):
    """The encounter whose failure weighs most."""

    letter: str
    track: str
    recording: str
    seconds: float


@dataclass(frozen=True)
class Measured(Fact):
    """A measure that is put side by side.

    Attributes
    ----------
    key
        Of the measure; ``mean saliency`` over recordings.
    extent
        Of episodes: in which time, and of which frames, where not of all.
    """

    key: str
    better: Amount
    other: Amount
    extent: str = ""

    @property
    def are_equal(self) -> bool:
        """Whether both have the same, as far as is shown."""
        return self.better.number == self.other.number

    @property
    def kind(self) -> str:
        """The key, and whether both have the same."""
        return f"same {self.key}" if self.are_equal else self.key


@dataclass(frozen=True)
class Has(Fact):
    """Which measures are better of a system, or the same of ``both``."""

    system: str
    measured: tuple[Measured, ...]

    @property
    def kind(self) -> str:
        """Whether it is of both."""
        return "both" if self.system == "both" else "one"


@dataclass(frozen=True)
class SystemShare(Fact):
    """A share of what is a system's."""

    letter: str
    share: float


@dataclass(frozen=True)
class FarAway(Fact):
    """How little of the saliency events' time is about objects that count."""

    shares: tuple[SystemShare, ...]


@dataclass(frozen=True)
class Shown(Named):
    """A difference that is more than chance, with its interval, where there is one."""

    winner: str
    p: P
    interval: str = ""

    @property
    def kind(self) -> str:
        """Whether there is an interval."""
        return "interval" if self.interval else "p"


@dataclass(frozen=True)
class MoreThanChance(Fact):
    """The differences that are claimed."""

    shown: tuple[Shown, ...]


@dataclass(frozen=True)
class WithheldReason(Fact):
    """Why a difference is not claimed although its p is small.

    Attributes
    ----------
    kind
        ``pending``: not yet compared at equal false alarms. ``equal``: not shown at equal false
        alarms. ``strict``: turned by strict pairing. ``alarms`` and ``matches``: the winner has
        more false alarms, or matches fewer, and no threshold sets the systems alike; with
        ``unscored``: nor have they scores. ``doubt``: of the measure itself.
    """

    kind: Literal[
        "pending", "equal", "strict", "alarms", "matches", "unscored alarms",
        "unscored matches", "doubt",
    ]  # fmt: skip
    winner: str = ""
    doubt: str = ""


@dataclass(frozen=True)
class Unclaimed(Fact):
    """Measures of which nothing is claimed for the same reason."""

    measures: tuple[Named, ...]
    reason: WithheldReason


@dataclass(frozen=True)
class UnclaimedOfPair(Named):
    """A measure of which nothing is claimed, of two systems with names."""

    reason: WithheldReason


@dataclass(frozen=True)
class OthersNotShown(Fact):
    """That no further difference is shown to be more than chance."""


@dataclass(frozen=True)
class ShortEncounters(Fact):
    """That most encounters are one frame long."""


@dataclass(frozen=True)
class Strict(Fact):
    """What strict pairing turns round."""

    better: tuple[Better, ...]


@dataclass(frozen=True)
class Unfiltered(Fact):
    """Systems whose every detection counts, though they have scores."""

    letters: tuple[str, ...]


@dataclass(frozen=True)
class DifferenceInterval(Fact):
    """The 95 % interval of a difference with its ends; or that there is none, for want of units.

    Attributes
    ----------
    kind
        ``ends``; ``few``: `n` recordings or units (`noun`), and `n_needed` would be; ``none``.
    """

    kind: Literal["ends", "few", "none"]
    ends: str = ""
    n: int = 0
    n_needed: int = 0
    noun: str = "recording"


@dataclass(frozen=True)
class Chip(Fact):
    """In a few words, what may be claimed of a measure.

    Attributes
    ----------
    kind
        ``better``: that `winner` is. Nothing, for operating points are ``unequal``, it is a
        ``single`` miss, encounters are ``short``, or for a `reason` (``withheld``). ``untested``:
        not tested; ``testing``: not yet. ``few`` recordings, ``unsure`` for want of false alarms,
        ``same`` values, or else ``not shown``.
    """

    kind: Literal[
        "better", "unequal", "single", "short", "withheld", "untested", "testing",
        "few", "unsure", "same", "not shown",
    ]  # fmt: skip
    winner: str = ""
    reason: WithheldReason | None = None
    n: int = 0
    n_needed: int = 0
    noun: str = "recording"


@dataclass(frozen=True)
class Doubt(Fact):
    """Findings that a verdict depends on: those it can name, and how many others there are."""

    known: tuple[str, ...]
    n_others: int

    @property
    def kind(self) -> str:
        """Whether some, all or none are named."""
        if not self.n_others:
            return "known"
        return "mixed" if self.known else "others"

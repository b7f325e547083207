"""The sentences of the verdict: templates, by type and kind of fact.

The fields are those of the fact; ``{one}`` and the like are words for the objects
(`nvcore.wording.objects`). A sentence gets its capital when it is said.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nvcore.sentences import facts

Texts = Mapping[type[facts.Fact], str | Mapping[str, str]]

UNEQUAL_POINTS: Final = "X and Y are set to different operating points"
AS_SET: Final = "as set: at unequal operating points"
"""Marks numbers of X and Y from which nothing is claimed."""
_ALARMS: Final = "X has {x:.3g} and Y {y:.3g} false boxes per frame"
_NO_CLAIM: Final = "so nothing is claimed"

_BY_ITSELF: Final = (
    "it is tested by itself at 5 %, and other differences are claimed only if it shows one."
)

_APART: Final = "{n_recordings!n:{noun}} do not tell X and Y apart"
_NONE_SHOWN: Final = "no difference is shown to be more than chance"
_PRIMARY_NOT_SHOWN: Final = "no difference in {primary} is shown to be more than chance"
_TOO_LITTLE: Final = "too little data to tell X and Y apart"
_TOO_FEW: Final = "too few {noun}s to tell X and Y apart"
CONCLUSIONS: Final = {
    "claimed": "{better}: more than chance over {n_recordings!n:{noun}}{remarks}",
    "untested": "whether X and Y differ by more than chance has not been tested",
    "pending": "nothing is claimed before X and Y are compared at equal false alarms",
    "few": f"{_TOO_FEW} ({{n_recordings}} of the {{n_needed}} needed)",
    "within": "{better} within {n_recordings!n:{noun}}{remarks}, too few to say so of "
    "others ({n_needed} are needed)",
    "untestable": _TOO_LITTLE,
    "unsure": "nothing is claimed: these are too few, or too uneven between recordings",
    "withheld": "no difference between X and Y is claimed: each that is more than chance fails "
    "another check",
    "not shown": f"{_APART}: {_NONE_SHOWN}",
    "primary not shown": f"{_APART}: {_PRIMARY_NOT_SHOWN}",
}
HEADLINES: Final = {
    "alike": "{conclusion}.",
    "equal": f"{UNEQUAL_POINTS}; at equal false alarms, {{conclusion}}.",
    "pending": f"{UNEQUAL_POINTS}: nothing is claimed before they are compared at equal false "
    "alarms.",
    "threshold": f"{UNEQUAL_POINTS} and no threshold sets them alike, {_NO_CLAIM}.",
    "scores": f"{UNEQUAL_POINTS} and cannot be set alike without scores that differ, {_NO_CLAIM}.",
    "same boxes": "X and Y have the same boxes: this is no comparison of two systems.",
    "truth as system": "the ground truth was given as a system: this is no comparison of two "
    "systems.",
    "wrong inputs": "nothing is claimed: the audit found errors in the inputs, and until they "
    "are mended the numbers are wrong.",
}

TEXTS: Final[Texts] = {
    facts.Named: "{key!m}",
    facts.BetterMeasure: "{key!m} ({better.number} against {other})",
    facts.OfBoth: "{key!m} (X {x.number}, Y {y})",
    facts.Better: "{winner!u} is better on {won}",
    facts.Conclusion: CONCLUSIONS,
    facts.Headline: HEADLINES,
    facts.Question: {
        "default": f"{{primary}} is the primary measure (the default): {_BY_ITSELF}",
        "chosen": "{primary} is the primary measure, chosen {when} before a verdict was shown: "
        f"{_BY_ITSELF}",
        "changed": "{primary} was made the primary measure {when}, after a verdict had been shown: "
        "so it is one of all measures, which are corrected for one another.",
        "untested": "{primary}, the primary measure, has no p here: the others are corrected for "
        "one another.",
    },
    facts.AtBest: {
        "none": "with {n!n:{noun}} no difference can be claimed, whatever they show: {n_needed} "
        "are needed.",
        "all": "with {n!n:{noun}} a difference can be claimed only if all of them favour the same "
        "system.",
    },
    facts.AsSet: {
        "comparison": f"as set, {_ALARMS}: nothing is claimed from that comparison.",
        "numbers": f"the numbers are as set, {_ALARMS}.",
        "above": f"{AS_SET} ({_ALARMS}). Nothing is claimed from these.",
        "rule": f"{UNEQUAL_POINTS} ({_ALARMS}), from which nothing is claimed: set thresholds that "
        "give equally many",
    },
    facts.AtEqualAlarms: {
        "above": "at equal false alarms ({setting}).",
        "numbers": "the numbers are at equal false alarms ({setting}); nothing is claimed from X "
        "and Y as set.",
        "claims": "claims are about X and Y at equal false alarms ({setting}).",
    },
    facts.EqualAlarmsSetting: {
        "all": "{moved!u} with all detections, each {per_frame:.3g} false boxes per frame",
        "some": "{moved!u} with scores of {threshold:g} or more, each {per_frame:.3g} false boxes "
        "per frame",
    },
    facts.Tested: {
        "tested": " ({n!n:{noun}}, {p})",
        "untestable": " (they differ in too few {noun}s for a test)",
        "unsure": " (not tested: too few or too uneven false alarms)",
    },
    facts.Split: {
        "none": "no encounter is near enough to count.",
        "same": "X and Y detect the same {both} of {n!n:encounter}.",
        "x": "X detects every encounter that Y detects, and {x_only} more of {n}{test}.",
        "y": "Y detects every encounter that X detects, and {y_only} more of {n}{test}.",
        "apart": "of the {fact.n_apart} encounters that only one system detects, X detects "
        "{x_only} and Y {y_only}{test}.",
    },
    facts.Cost: {
        "one": "the one encounter that only {finder!u} detects costs {loser!u} {seconds:.1f} s",
        "many": "the {n} encounters that only {finder!u} detects cost {loser!u} {seconds:.1f} s",
    },
    facts.EncounterWeights: "weighted by severity, {costs}.",
    facts.WorstFailure: "the worst single failure is {letter!u}'s: {one} {track} in {recording}, "
    "{seconds:.1f} s.",
    facts.Measured: {
        "mean_similarity": "higher mean similarity ({better.number} against {other})",
        "severity_s_per_encounter": "lower severity per encounter ({better.number} against "
        "{other})",
        "saliency": "lower saliency ({better.number} against {other})",
        "mean saliency": "lower saliency in the mean over recordings ({better.number} against "
        "{other})",
        "false_alert_episodes": "fewer false-alert episodes ({better.number} against "
        "{other}{extent})",
        "log_average_miss_rate": "a lower log-average miss rate ({better.number} against {other})",
        "same mean_similarity": "mean similarity ({better})",
        "same severity_s_per_encounter": "severity per encounter ({better})",
        "same saliency": "saliency ({better})",
        "same mean saliency": "saliency in the mean over recordings ({better})",
        "same false_alert_episodes": "number of false-alert episodes ({better}{extent})",
        "same log_average_miss_rate": "log-average miss rate ({better})",
    },
    facts.Has: {"one": "{system!u} has {measured}.", "both": "both have the same {measured}."},
    facts.SystemShare: "{share!p} of {letter!u}'s",
    facts.FarAway: "of the time in saliency events, {shares} is about {many} that count; in the "
    "rest, {people} are too far away.",
    facts.Shown: {
        "interval": "{key!m} ({winner!u} better, X - Y 95 % interval {interval}, {p})",
        "p": "{key!m} ({winner!u} better, {p})",
    },
    facts.MoreThanChance: "more than chance: {shown}.",
    facts.WithheldReason: {
        "pending": "not yet compared at equal false alarms",
        "equal": "not shown at equal false alarms",
        "strict": "the other way round if paired strictly",
        "alarms": "{winner!u} also has more false alarms, and no threshold sets them alike",
        "matches": "{winner!u} also matches fewer {many}, and no threshold sets them alike",
        "unscored alarms": "{winner!u} also has more false alarms, and without scores that "
        "differ nothing sets them alike",
        "unscored matches": "{winner!u} also matches fewer {many}, and without scores that "
        "differ nothing sets them alike",
        "doubt": "{doubt}",
    },
    facts.Unclaimed: "not claimed: {measures} ({reason}).",
    facts.UnclaimedOfPair: "{key!m} ({reason})",
    facts.OthersNotShown: "the other differences are not shown to be more than chance.",
    facts.ShortEncounters: "most encounters are one frame long, so saliency, severity and episodes "
    "mean little here and are not judged.",
    facts.Strict: "with strict pairing, where a false alarm cannot stand in for a match, it is the "
    "other way round: {better}.",
    facts.Unfiltered: "every detection of {letters!u} counts, however low its score.",
    facts.DifferenceInterval: {
        "ends": "95 % interval {ends}",
        "few": "no interval: {n!n:{noun}}, {n_needed} needed",
        "none": "no interval",
    },
    facts.Chip: {
        "better": "{winner!u} better",
        "unequal": "no claim: unequal false alarms",
        "single": "not tested: one encounter",
        "short": "not judged: encounters of one frame",
        "withheld": "no claim: {reason}",
        "untested": "not tested",
        "testing": "being tested",
        "few": "not tested: {n!n:{noun}}, {n_needed} needed",
        "unsure": "not tested: too few or too uneven false alarms",
        "same": "the same",
        "not shown": "may be chance",
    },
    facts.Doubt: {
        "known": "this depends on what the audit found: {known!c}.",
        "mixed": "this depends on what the audit found: {known!c}; {n_others!n:other finding}.",
        "others": "this depends on what the audit found: {n_others!n:finding}.",
    },
}
"""Those of the core."""

IN_SHORT: Final[Texts] = {
    facts.BetterMeasure: "{key!m}",
    facts.Conclusion: {
        "claimed": "{better}",
        "untested": "X and Y have not been tested against each other",
        "pending": "X and Y are not yet compared at equal false alarms",
        "few": _TOO_FEW,
        "within": _TOO_FEW,
        "untestable": _TOO_LITTLE,
        "unsure": "too few false alarms to tell X and Y apart",
        "withheld": "no difference between X and Y passes every check",
        "not shown": _APART,
        "primary not shown": _APART,
    },
    facts.Headline: {
        "alike": "{conclusion}.",
        "equal": "at equal false alarms, {conclusion}.",
        "pending": "nothing is claimed yet.",
        "threshold": "no claim: X and Y have unequal false alarms.",
        "scores": "no claim: X and Y have unequal false alarms.",
        "same boxes": "X and Y have the same boxes.",
        "truth as system": "the ground truth was given as a system.",
        "wrong inputs": "nothing is claimed: the inputs have errors.",
    },
}
"""The headline where its reason (`BECAUSE`) stands below it."""

BECAUSE: Final[Texts] = {
    facts.Conclusion: {
        **CONCLUSIONS,
        "few": "a test needs {n_needed} {noun}s and has {n_recordings}",
        "untestable": "no measure has enough recordings that differ for a test",
        "unsure": "false alarms are too few, or too uneven between recordings",
        "withheld": "each difference that is more than chance fails another check",
        "not shown": _NONE_SHOWN,
        "primary not shown": _PRIMARY_NOT_SHOWN,
    },
    facts.Headline: {
        **HEADLINES,
        "equal": f"as {UNEQUAL_POINTS}, they are compared at equal false alarms: {{conclusion}}.",
    },
}
"""The reason of the headline in short."""

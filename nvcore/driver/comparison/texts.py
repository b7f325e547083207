"""How facts of the driver are said."""

from __future__ import annotations

from typing import Final

from nvcore.driver.comparison import facts
from nvcore.sentences.texts import Texts

_SEEN: Final = "seen means that at least {threshold!p} of drivers would see the {one}."
_DECIDES: Final = "the value that decides is within one standard deviation of {threshold:g}"
_COUNTS: Final = "{n!n:encounter} in all: {n_seen:,} seen by the driver, {n_unseen:,} not seen"
_UNKNOWN: Final = ", {n_unknown:,} unknown"
_DISTANT: Final = ", {n_distant:,} distant (never near enough to count)"
_KNOWN: Final = "whether the driver sees them is known of {n_known:,} of {n:,}"
_OPEN: Final = "; open in {n_open:,} of these, within one standard deviation"
_UNSEEN: Final = ", {n_open_unseen:,} of the {n_unseen:,} not seen among them"
_IS_OPEN: Final = "whether the driver sees the {one} is open in"

TEXTS: Final[Texts] = {
    facts.Why: {
        "useless": "as a whole the estimator is no better than a constant on {many} that it had "
        "not seen",
        "simulated": "the estimator learnt from simulated subjects alone, not from people",
        "range": "in {n:,} of {n_known!n:encounter} of which it is known, the value that decides "
        "is outside the range of the training",
        "open": f"{{fact.where}} of which it is known, {_DECIDES}",
        "unseen": f"{{fact.where}} counted as not seen by the driver, {_DECIDES}",
    },
    facts.Only: {"only": "in the only encounter", "all": "in all {n!n:encounter}"},
    facts.NoClaim: {
        "seen": "nothing is claimed of {what} the driver sees: {why}.",
        "weighted": "nothing is claimed of what is weighted: {why}.",
    },
    facts.NothingKnown: "detectability is known in some frames, but for no encounter in a frame up "
    "to the first that counts: {what} the driver sees is not known.",
    facts.Caution: " ({text})",
    facts.Word: {
        "truth": "by the ground truth",
        "estimates": "by the estimates{caution}",
        "both": "by estimates in {n_estimated!n:recording}{caution} and the ground truth in "
        "{n_stated}",
    },
    facts.Alerts: {
        "unseen": "{by}, the driver sees {n_seen} of {n_known!n:encounter} unaided; of the "
        "{n_unseen} not seen, X detects {useful_x} and Y {useful_y} (X alone {x}, Y alone {y}, "
        "neither {neither}).",
        "all": "{by}, the driver sees {n_seen} of {n_known!n:encounter} unaided.",
        "redundant": "{by}, the driver sees {n_seen} of {n_known!n:encounter} unaided: every alert "
        "about these is redundant.",
    },
    facts.Seldom: "one frame is enough to count as seen: {n:,} of the {n_seen:,} reach the "
    "threshold in fewer than {share!p} of the frames up to the first that counts.",
    facts.Counts: {
        "all": f"{_COUNTS}.",
        "unknown": f"{_COUNTS}{_UNKNOWN}.",
        "distant": f"{_COUNTS}{_DISTANT}.",
        "unknown distant": f"{_COUNTS}{_UNKNOWN}{_DISTANT}.",
    },
    facts.Known: {
        "near": f"{_KNOWN} encounters, {{by}}",
        "near open": f"{_KNOWN} encounters, {{by}}{_OPEN}",
        "urgent": f"{_KNOWN} urgent encounters, {{by}}",
        "urgent open": f"{_KNOWN} urgent encounters, {{by}}{_OPEN}",
    },
    facts.InTime: "of {n!n:urgent encounter} of which it is known, the driver is in time unaided "
    "in {driver:,}; of the others, both systems are in {both:,}, X alone in {x:,}, Y alone in "
    "{y:,}, none of them in {neither:,}.",
    facts.SeenTooLate: "{n:,} that the driver sees are seen too late to stop.",
    facts.DetectabilitySource: {
        "truth": f"detectability is as the ground truth states it; {_SEEN}",
        "estimates": f"detectability is {{fact.how}}; {_SEEN}",
        "both": "detectability is {fact.how}, in {n_estimated!n:recording}, and as the ground "
        f"truth states it in {{n_stated}}; {_SEEN}",
    },
    facts.KnownExtent: {
        "boxes": "it is known of {n_known:,} of {n_boxes:,} {one} boxes.",
        "both": "it is known of {n_known:,} of {n_boxes:,} {one} boxes; {fact.left_out}.",
        "encounters": "{fact.left_out}.",
    },
    facts.NotCounted: {
        "one": "1 encounter of which it is unknown is not counted here",
        "many": "{n!n:encounter} of which it is unknown are not counted here",
    },
    facts.Outside: "outside the range of the training{fact.features} are {n:,} of {n_known:,} "
    "values; such values decide {fact.decided} of {n_encounters!n:encounter}.",
    facts.OutsideOf: " (in that run by {names})",
    facts.Open: {
        "seen": f"{_IS_OPEN} {{n:,}} of {{n_known!n:encounter}}: {_DECIDES}.",
        "unseen": f"{_IS_OPEN} {{n:,}} of {{n_known!n:encounter}}{_UNSEEN}: {_DECIDES}.",
        "least seen": f"{_IS_OPEN} at least {{n:,}} of {{n_known!n:encounter}}: {_DECIDES}.",
        "least unseen": f"{_IS_OPEN} at least {{n:,}} of {{n_known!n:encounter}}{_UNSEEN}: "
        f"{_DECIDES}.",
    },
    facts.LightUnknown: "in {share!p} of all estimates of that run it is not known when the light "
    "last changed: the eyes are taken for adapted.",
    facts.Adapted: "estimates for adapted eyes, as no change from bright to dark is known before, "
    "decide {n:,} of {n_known!n:encounter}.",
    facts.Weighting: {
        "none": "driver_weighting has no effect: no detectability is known.",
        "all": "similarity, saliency and severity are weighted by (1 - detectability): this "
        "weighting is ours, not the papers'.",
        "one": "similarity, saliency and severity are weighted by (1 - detectability): this "
        "weighting is ours, not the papers'; 1 {one} box has none and weighs in full: missing it "
        "weighs more than the same miss where a value is known.",
        "many": "similarity, saliency and severity are weighted by (1 - detectability): this "
        "weighting is ours, not the papers'; {n:,} {one} boxes have none and weigh in full: a miss "
        "of these weighs more than the same miss where a value is known.",
    },
    facts.WeightedClaims: " (similarity, saliency and severity weighted by 1 - detectability)",
    facts.Estimated: "{what} the driver sees is estimated: {caution}.",
    facts.SeenBy: "encounters seen by: {regions:, }",
    facts.Region: "{name} {n:,}",
}

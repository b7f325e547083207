"""Introductions to the sections on what the systems did; templates, said by the page's content."""

from __future__ import annotations

from nvcore.figures.venn import MOST_MARKS
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.kernels import ABSORB_SHARE
from nvcore.metrics.linking import LINK_GAP, LINK_IOU
from nvcore.metrics.proximity.borrowing import borrows
from nvcore.palette import Theme, scheme_of
from nvcore.params import MIDPOINT_SHARE, SPREAD_SHARE, Params
from nvcore.report.html.blocks import Intro
from nvcore.report.words import saliency_caveat


def reading(params: Params, theme: Theme) -> tuple[str, ...]:
    """What X, Y, truth, match and encounter mean."""
    rule = (
        f"if the boxes overlap by an intersection over union of at least {params.iou:g}"
        if params.match == "iou"
        else f"if it lies at most {_percent(params.lateral_tolerance)} of the picture's width, or "
        "half the {one}'s, to the side of them"
    )
    if params.match_class == "same":
        rule += ", and is of the same class where the ground truth names one"
    styles = {letter: scheme_of(theme).style(letter) for letter in "xy"}
    drawn = [f"{letter.upper()} is {style.words}" for letter, style in styles.items()]
    return (
        "X and Y are two systems that detect {many}; both were given the same recordings.",
        "The ground truth says where {many} are: boxes that people drew in the pictures. A "
        "detection is a box of a system, with a score that says how sure it is; boxes with a score "
        "below the system's threshold are left out.",
        f"A detection matches {{a_one}} {rule}; each matches one at most, the best scores "
        "first. One that matches {nobody} is a false alarm, {a_one} {whom} nothing matches is "
        "missed. Regions that the ground truth marks as ignored count neither way.",
        "An encounter is one {one}, from the first to the last frame in which {he} is "
        "annotated. Frames count in which {he} is near enough (weight of nearness of "
        f"{RELEVANT_K:g} or more, see Similarity); an encounter without any is too far to count, "
        "in short: distant.",
        f"In the charts {' and '.join(drawn)}: each system has its colour and line, whichever is "
        "X. A dash in a table means not defined, never zero. Files such as encounters.csv are "
        "tables of the same comparison.",
    )


VERDICT = Intro(
    what="What the measures of this report support, in sentences that go no further than they do.",
    how="The first sentence says what is claimed. If X and Y are set to different operating "
    "points, it says so, and they are compared at equal false alarms. More than chance is what "
    "other recordings like these would show: by six recordings or more, in the primary measure, "
    "or in others corrected for one another where that is shown; at equal false alarms as well, "
    "and not turned round by strict pairing. Below it, topic by topic, is what that rests on.",
    limits="It says nothing about conditions that were not recorded and is no proof of safety.",
)


SHORT_ENCOUNTERS = (
    "Caution: most encounters here are one frame long, as sampled or unlinked annotation makes "
    "them. They are frames rather than {many}: shares of encounters are shares of frames, and "
    "late, dropout, lead time and saliency mean little."
)
SHORT_TESTS = (
    "Caution: most encounters here are one frame long, so one {one} may stand in many of them. "
    "Tests and intervals of single encounters would take them as independent and be far too sure, "
    "so they are not given. Go by the measures by recordings or blocks of time."
)
NO_PICTURES = (
    "There are no pictures of these frames: the boxes are drawn on an empty ground of the "
    "picture's size."
)


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def scorecard(params: Params) -> Intro:
    """Introduction of the scorecard."""
    return Intro(
        what="All measures side by side. X − Y is the difference; of shares it is given in "
        "percentage points (pp).",
        how="Each measure is explained in its own section below. An encounter is detected if at "
        f"least {_percent(params.coverage)} of its frames that count are matched. How the "
        "encounters went counts, for each system, the way in which it failed (or did not).",
        best="The last column says whether higher or lower is better.",
        limits="Whether a difference is more than chance: see Is the difference real.",
    )


def who(params: Params) -> Intro:
    """Introduction of the encounters by who detects them."""
    return Intro(
        what="Which {many} were detected by both systems, by one only, by neither.",
        how="A system detects an encounter if it matches the {one} in at least "
        f"{_percent(params.coverage)} of the frames that count, and in one at least. A first match "
        f"more than {params.lag_s:g} s late makes the encounter late, a gap of more than "
        f"{params.gap_s:g} s a dropout, the same after the last match an early loss; the first of "
        "these that holds is counted. Severity is what a system's failure weighs: the cost of each "
        "frame that counts in which it misses the {one} (weight of nearness times distance "
        "from the border over half the picture's width, 0 to 1; see Similarity), summed over time. "
        "1 s is {a_one} straight ahead and near, missed for 1 s; peak cost is the largest of "
        "a frame. Lead time is Y's delay of the first match minus X's. Jaccard index: "
        "shared misses over all misses. Phi: correlation of the two systems' misses.",
        best="Many in the middle of the diagram, few outside the circles, and little severity. A "
        "system dominates the other if it detects all that the other detects, and more. In the "
        f"diagram of up to {MOST_MARKS} encounters each is a mark, larger the more its failure "
        "weighs: {x.name} ({x.symbol}) where X's failure weighs more, {y.name} ({y.symbol}) where "
        "Y's does, a black square where neither detects or both weigh the same, an open circle "
        "where nothing was missed.",
        limits="A count takes an encounter once, however long it lasts and however near it comes: "
        "look at the severity, too. One class is named, though several failures may hold.",
    )


def classes() -> Intro:
    """Introduction of the classes."""
    return Intro(
        what="What the systems took the matched {many} for: the class in the truth, and the "
        "one that was read.",
        how="Boxes are matched by place alone, at the thresholds in use. What is right stands in "
        "the diagonal; a darker cell is a larger share of its row. {Many} without a class in "
        "the truth do not count.",
        best="Everything in the diagonal.",
        limits="The interval takes boxes as independent, though many are of one and the same "
        "object: it is too narrow.",
    )


def similarity(params: Params, midpoint: str, spread: str) -> Intro:
    """Introduction of similarity.

    Parameters
    ----------
    midpoint, spread
        The values in use, px.
    """
    a = params.alpha
    borrowed = " ({a_one}'s own, else one that {his} matches report)" if borrows(params) else ""
    weights = {
        "height": "1 / (1 + exp(−(height of the box − midpoint) / spread))",
        "horizon": "1 / (1 + exp(−(foot point below the horizon − midpoint) / spread))",
        "distance": f"1 / (1 + exp((distance{borrowed} − midpoint_m) / spread_m)), by the height "
        "of the box where the distance is unknown",
        "none": "1 for {everybody}",
    }
    values_in_use = [
        f"{name} {value} px"
        + ("" if setting is not None else f" ({share} of the height of each recording's picture)")
        for name, value, setting, share in (
            ("midpoint", midpoint, params.midpoint, _percent(MIDPOINT_SHARE)),
            ("spread", spread, params.spread, _percent(SPREAD_SHARE)),
        )
    ]
    if params.proximity == "distance":
        values_in_use.insert(
            0, f"midpoint_m {params.midpoint_m:g} m, spread_m {params.spread_m:g} m"
        )
    context = "as each recording says" if params.edge_weight is None else f"{params.edge_weight:g}"
    in_use = "" if params.proximity == "none" else f", here with {' and '.join(values_in_use)}"
    return Intro(
        what="How near what a system shows is to what is there, for each frame: 1 means that the "
        "detections fit the {many}.",
        how="Of all {many} of a frame the one is taken that is worst represented: its "
        "distance to the nearest detection, or to the border where that is nearer, times its "
        "weight of nearness. That is D(truth, system); D(system, truth) is the same for the "
        "detection that is farthest from any {one}. Similarity is 1 − "
        f"({a:g} × D(truth, system) + {1 - a:.4g} × D(system, truth)) / (half the picture's "
        "width). "
        f"The weight of nearness is {weights[params.proximity]}{in_use}. The border is the nearer "
        "edge of the picture (edge_weight 0, urban), half the picture's width away (1, rural), or "
        f"between; here {context}. A low interval is a run of frames with a "
        f"similarity below {params.low:g}; its depth is the sum of how far below, times the "
        "time step.",
        best="1; the mean over all frames of all recordings is compared.",
        limits="Only the worst {one} and the worst false alarm of a frame count, not how "
        "many there are.",
    )


def saliency(params: Params) -> Intro:
    """Introduction of saliency."""
    scope = "recording" if params.saliency_scope == "recording" else "encounter"
    whole = (
        "the largest event" if params.saliency_aggregate == "max" else "the sum of all its events"
    )
    weight, recency = "its duration", _recency(params, scope)
    if params.saliency_weight == "risk":
        weight = "its weighted distance over half the picture's width, summed over time,"
    who = "one {one} is the most salient miss"
    if params.saliency_of == "each":
        who = "one {one} is missed, whoever else is"
    return Intro(
        what="How much the misses will be noticed by a driver, in seconds: long ones more than "
        "short ones, late ones more than early ones.",
        how=f"A saliency event is a run of frames in which {who} (weighted distance above "
        f"{_percent(params.tolerance)} of half the picture's width). Its saliency is {weight} "
        f"times recency, and recency is {recency} when the event ends. A recording's saliency is "
        f"{whole}; over several recordings it is the mean of theirs.",
        best="0 s; in the plane of similarity and saliency bottom right (large open marks: means "
        "over the recordings).",
        limits="It is a model of what drivers remember, not a measurement of it. Part of the "
        "events' time may be of {many} too far to count: the share is below. "
        + saliency_caveat(params),
    )


def _recency(params: Params, scope: str) -> str:
    if params.recency_unit == "seconds":
        return (
            f"1 / (1 + exp((t − {params.recency_midpoint_s:g}) / {params.recency_spread_s:g})), t "
            f"being the seconds left to the end of the {scope}"
        )
    return (
        f"1 / (1 + exp(−(t − {params.recency_midpoint:g}) / {params.recency_spread:g})), t being "
        f"the share of the {scope} that has passed"
    )


DETECTION = Intro(
    what="The usual measures of detection benchmarks, over all score thresholds, from the same "
    "matching as everything else.",
    how="At each threshold: recall is matched {one} boxes over all of them, miss rate is 1 "
    "less recall, precision is matched over matched plus false; false positives are counted per "
    "image. Average precision is the mean, over recalls 0, 0.01, ... 1, of the largest precision "
    "at that or a larger recall. The log-average miss rate is the geometric mean of the miss "
    "rates at nine values from 0.01 to 1 false positives per image. {Many} that the protocol "
    "leaves out are ignored.",
    best="A low miss rate curve, a high precision-recall curve. Large marks are the thresholds "
    "in use.",
    limits="Boxes are counted, not {people}, and when something is missed makes no difference. "
    "The averages run over thresholds that nobody drives with.",
)

FALSE_ALERTS = Intro(
    what="Detections that match {nobody}, and how often a driver would notice one.",
    how="False alarms that overlap from frame to frame (intersection over union of "
    f"{LINK_IOU:g} or more, gaps of up to {LINK_GAP} evaluated frames) are one episode: a warning "
    "that flickers for two seconds annoys once. Detections with at least "
    f"{100 * ABSORB_SHARE:g} % of their area on an ignored region do not count.",
    best="0.",
    limits="A real {one} {whom} nobody annotated makes a false alarm. Rates per minute and "
    "hour are too low where only some frames of a recording are evaluated.",
)

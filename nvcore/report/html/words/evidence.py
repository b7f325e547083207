"""Introductions to the sections on how sure the differences are; templates, as all here."""

from __future__ import annotations

from nvcore.report.decisive_moments import APART_S, MOST
from nvcore.report.html.blocks import Intro

SIGNIFICANCE = Intro(
    what="Whether each difference between X and Y may be chance. Both systems saw the same "
    "{many}, so all tests are paired.",
    how="Whole recordings (or blocks of time within them, where there are fewer than six) are "
    "drawn again and again with replacement; the middle 95 % of the differences that come about, "
    "corrected for bias and skew (BCa), are the interval. For the p-value X and Y are exchanged "
    "within the recordings, in all ways where up to 16 of them differ, else in 10,000 random "
    "ways: the share of these that give at least so large a difference, if X and Y could be "
    "exchanged. Where a studentised bootstrap, which allows for skew, gives a larger p, that is "
    "taken. Blocks of time have no p. The row of encounters within these recordings has the exact "
    "McNemar test of those that only one detects: it takes them as independent and says nothing "
    "of other recordings. The primary measure, which is chosen before the result is seen, is "
    "tested by itself; the p of others is corrected for one another, and is at least that of the "
    "primary one; a hypothesis counts once. Effect size: mean difference over its standard "
    "deviation (Cohen's "
    "d_z), or the odds ratio of the encounters that only one detects.",
    best="An interval that does not touch 0 on the side of the better system; a corrected p of "
    "0.05 or less.",
    limits="A large p does not show that the systems are equal: it may be that there are too few "
    "data. The intervals do not allow for recordings of other kinds than these, nor for disasters "
    "that are in none of them.",
)

SUBGROUPS = Intro(
    what="The same measures for some of the encounters: near or far, in the centre or at the "
    "edge of the picture, occluded, in an unusual pose, by tags of the recordings.",
    how="The plot has the share of encounters that X detects minus the share that Y detects, with "
    "Newcombe's 95 % interval for paired shares and the exact McNemar test, within these "
    "recordings. The other measures are judged as in the section before: for a tag from the "
    "recordings that have it; for a group of {many} saliency from the events of these "
    "{many}, as the mean over the recordings that have any, and the log-average miss rate "
    "with all other {many} ignored. p (Holm) is corrected for all groups and measures. Only "
    "encounters that count are in a group; among them near means at least twice as high in the "
    "picture as {a_one} {who} counts half, far lower than that (distant encounters, which do "
    "not count, are not meant). Centre means the middle half of the picture's width; an unusual "
    "pose is one standard deviation or more from the mean ratio of height to width.",
    best="In the plot: right of 0 X detects more, left of it Y.",
    limits="A frame's similarity and a false alert belong to no single {one}: these measures "
    "are there for all and by tags only. Groups overlap, and small groups show little: look at "
    "the counts.",
)

PLAN = Intro(
    what="How many recordings like these would show the differences that these do not show, and "
    "which differences these exclude.",
    how="Studies are simulated by drawing whole recordings from these, with replacement, and "
    "tested as above; a study shows a difference where p, of this measure by itself, is at most "
    "0.05. Recordings: the fewest with which four of five studies do. Or rather: the range that "
    "these recordings leave open, as they tell only roughly how much recordings vary. Excluded is "
    "what lies outside the 95 % interval of the difference.",
    limits="It is for the differences as found here. The smallest difference that would matter, "
    "and whether a system is at most so much worse, can be asked of the program (nvcore plan).",
)

STABILITY = Intro(
    what="Whether the verdict depends on settings that the analyst chooses: alpha, which weighs "
    "misses against false alarms; the midpoint, the height (or distance) at which {a_one} "
    "counts half; the score thresholds; the matching rule; the traffic context (edge weight).",
    how="The comparison is made at every pair of settings of a map, all else as analysed. The "
    "table says in which share of the plausible range the verdict holds. One map is drawn: "
    "{x.name} where X is better, {y.name} where Y is; the line is where it turns, the dotted frame "
    "the range that is plausible.",
    best="A verdict that holds in all of the plausible range of every setting.",
    limits="It is about these data: a verdict that holds at all settings may still be chance.",
)

EVIDENCE = Intro(
    what="The frames behind the verdict: encounters that only one system detects, and the worst "
    "moments of each system.",
    how="Of such an encounter the frame is shown in which the similarities of the two systems "
    "differ most while one matches the {one} and the other does not, and those encounters in "
    "which they differ most; of a low interval the frame with the lowest similarity; of a time in "
    "which one system is clearly better the frame with the largest difference. Frames of one "
    f"recording within {APART_S:g} s are one scene and shown once for each system. Truth: thin "
    "white (dark where there is no picture); X: {x.words}; Y: {y.words}. A missed {one} "
    "has corners and a letter in the colour of the system that misses them; a triangle "
    "\N{BLACK DOWN-POINTING TRIANGLE} beside the letter marks the miss that stands out most in "
    "this frame. A false alarm is crossed out. The ellipse is around the {one} or the false "
    "alarm that the text is about. Numbers are track ids (like the truth) and scores (like their "
    "system), as far as there is room. Dotted boxes are ignored. Below each picture stand its "
    "{many}. Term: k times the smaller of border and near (the distance to the nearest "
    "detection), as a share of half the width; alpha times the largest is what that system loses "
    "to misses. Cost: k times border, as the same share: what missing this {one} weighs. "
    "Border and near are in pixels.",
    limits=f"{MOST} frames at most, chosen by rule: they show what happens, not how often.",
)

ONLY_ONE = Intro(
    what="Every encounter that one system detects and the other does not: what tells the two "
    "apart. The heaviest failures come first.",
    how="Sorted by the severity for the other system, which misses the {one} (see Who detects "
    "{what}). Coverage is the share of frames that count in which the {one} is matched. Missed "
    "from is the time of the first frame that counts in which the other system misses them.",
)

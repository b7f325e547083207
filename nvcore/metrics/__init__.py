"""The metrics of paper 11-0360: pure functions over columns."""

from nvcore.metrics.cost_map import CostMap, map_cost
from nvcore.metrics.encounters import RELEVANT_K, Encounters, find_encounters, judge_encounters
from nvcore.metrics.false_alarms import FalseAlarmSummary, find_episodes, summarise_false_alarms
from nvcore.metrics.fusion import fuse, pair_detections
from nvcore.metrics.linking import TruthTracks, link_boxes, track_truth
from nvcore.metrics.matching import Matches, count_per_frame, match_boxes
from nvcore.metrics.proximity import Weights, weigh_proximity
from nvcore.metrics.proximity.borrowing import Borrowed, borrowed_distances
from nvcore.metrics.proximity.horizon import Horizon, estimate_horizon, estimate_horizons
from nvcore.metrics.saliency import (
    find_events,
    mean_saliency,
    qualify,
    qualify_each,
    recency_weight,
    saliency_by_recording,
)
from nvcore.metrics.severity import cost_of_miss, weigh_failures
from nvcore.metrics.similarity import (
    Nearest,
    SetDistances,
    SimilaritySummary,
    border_of,
    find_low_intervals,
    find_nearest,
    measure_matched,
    measure_sets,
    miss_terms,
    runs_of,
    salient_detection,
    smooth,
    summarise_similarity,
    trace_similarity,
)
from nvcore.metrics.venn import (
    BoxVenn,
    Exclusivity,
    Venn,
    categorise,
    count_boxes,
    count_categories,
    measure_exclusivity,
)

__all__ = [
    "RELEVANT_K",
    "Borrowed",
    "BoxVenn",
    "CostMap",
    "Encounters",
    "Exclusivity",
    "FalseAlarmSummary",
    "Horizon",
    "Matches",
    "Nearest",
    "SetDistances",
    "SimilaritySummary",
    "TruthTracks",
    "Venn",
    "Weights",
    "border_of",
    "borrowed_distances",
    "categorise",
    "cost_of_miss",
    "count_boxes",
    "count_categories",
    "count_per_frame",
    "estimate_horizon",
    "estimate_horizons",
    "find_encounters",
    "find_episodes",
    "find_events",
    "find_low_intervals",
    "find_nearest",
    "fuse",
    "judge_encounters",
    "link_boxes",
    "map_cost",
    "match_boxes",
    "mean_saliency",
    "measure_exclusivity",
    "measure_matched",
    "measure_sets",
    "miss_terms",
    "pair_detections",
    "qualify",
    "qualify_each",
    "recency_weight",
    "runs_of",
    "saliency_by_recording",
    "salient_detection",
    "smooth",
    "summarise_false_alarms",
    "summarise_similarity",
    "trace_similarity",
    "track_truth",
    "weigh_failures",
    "weigh_proximity",
]

"""Tables of a result, and the meaning of each column."""

from nvcore.tables.boxes.states import FrameBoxes, gather_boxes
from nvcore.tables.classes import classes_table, has_classes
from nvcore.tables.columns import column_names, report_columns
from nvcore.tables.encounters.miss_classes import fusion_table, miss_class_counts, miss_class_totals
from nvcore.tables.encounters.severity import weighed_encounters
from nvcore.tables.encounters.weightings import Weightings, compare_weightings
from nvcore.tables.frame import FrameSummary, frame_summary
from nvcore.tables.inputs import (
    entries_as_cvat,
    entry_frames,
    finding_entries,
    inputs_table,
    left_out_table,
)
from nvcore.tables.lanes import lanes_table
from nvcore.tables.loss_strip import LossStrip, loss_strip
from nvcore.tables.moments import encounter_moments, next_misses, worst_moments
from nvcore.tables.result import (
    encounters_table,
    events_table,
    findings_table,
    frames_table,
    intervals_table,
    recordings_table,
    worst_events,
    worst_intervals,
)
from nvcore.tables.scorecard import score_rows
from nvcore.tables.summary import summary, system_summary
from nvcore.tables.windows import windows_table

__all__ = [
    "FrameBoxes",
    "FrameSummary",
    "LossStrip",
    "Weightings",
    "classes_table",
    "column_names",
    "compare_weightings",
    "encounter_moments",
    "encounters_table",
    "entries_as_cvat",
    "entry_frames",
    "events_table",
    "finding_entries",
    "findings_table",
    "frame_summary",
    "frames_table",
    "fusion_table",
    "gather_boxes",
    "has_classes",
    "inputs_table",
    "intervals_table",
    "lanes_table",
    "left_out_table",
    "loss_strip",
    "miss_class_counts",
    "miss_class_totals",
    "next_misses",
    "recordings_table",
    "report_columns",
    "score_rows",
    "summary",
    "system_summary",
    "weighed_encounters",
    "windows_table",
    "worst_events",
    "worst_intervals",
    "worst_moments",
]

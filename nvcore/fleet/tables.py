"""Tables of a store and of a scan's results: their columns, and where each lies."""

from __future__ import annotations

from typing import Final

import pyarrow as pa

from nvcore.schema import NO_TRACK, UNKNOWN_OCCLUSION

INDEX: Final = (
    pa.field("file", pa.string()),  # path within the table's folder
    pa.field("first_row", pa.int64()),  # its first row within the file
    pa.field("n_rows", pa.int64()),
)
"""Where the rows of a recording (or of one of its sources) lie: one stretch of one file."""

RECORDINGS: Final = pa.schema(
    [
        pa.field("recording", pa.string()),  # its name, the id by which results are ordered
        pa.field("sha256", pa.string()),  # over the facts below and its frames
        pa.field("ingested_at", pa.timestamp("us", "UTC")),
        pa.field("width", pa.float64()),
        pa.field("height", pa.float64()),
        pa.field("fps", pa.float64()),
        pa.field("horizon", pa.float64()),
        pa.field("context", pa.float64()),
        pa.field("speed_kmh", pa.float64()),
        pa.field("tags", pa.list_(pa.string())),  # "night", or "road=rural"
        pa.field("unit", pa.string()),  # drive, vehicle or route that it is part of; empty: none
        pa.field("recorded_at", pa.timestamp("us", "UTC")),  # null: unknown
        pa.field("pictures", pa.string()),  # source URI of its pictures; empty: none
        pa.field("first_picture", pa.int64()),  # frame that the first one shows; null: not stated
        pa.field("objects", pa.list_(pa.string())),  # what the boxes are of: singular, plural
        pa.field("duration_s", pa.float64()),
        pa.field("parameters", pa.string()),  # JSON of the session's settings; empty: by default
        pa.field("source", pa.string()),  # URI of the session that it came with
        *INDEX,  # its rows of `frames`
    ]
)
"""Rows of versions of recordings; a later row of a version replaces an earlier one."""

SOURCES: Final = pa.schema(
    [
        pa.field("recording", pa.string()),
        pa.field("source", pa.string()),  # "truth", or the name of a system
        pa.field("sha256", pa.string()),  # over its boxes: what tells versions apart
        pa.field("recording_sha256", pa.string()),  # version of the recording that it came with
        pa.field("label", pa.string()),  # what the user calls this version; empty: its number
        pa.field("kind", pa.string()),  # of a truth: annotated, automatic, absent; else system
        pa.field("ingested_at", pa.timestamp("us", "UTC")),
        pa.field("threshold", pa.float64()),  # of a system, by its session; null: none
        pa.field("inputs", pa.list_(pa.string())),  # sha256 of the files that it was read from
        pa.field("n_left_out", pa.int64()),  # rows of these files that could not be placed
        pa.field("amends", pa.bool_()),  # notes a label or kind; does not make it the newest
        *INDEX,  # its rows of `boxes`
    ]
)
"""Rows of versions of the truth or a system; a later row of a version replaces an earlier one.

They are written last: a version of a recording counts once there is a source that came with it.
"""

ADDED_LATER: Final = {"parameters": "", "amends": False}
"""Columns that older stores lack, and their values there."""

FRAMES: Final = pa.schema(
    [
        pa.field("recording", pa.string()),
        pa.field("frame", pa.int64()),
        pa.field("speed_kmh", pa.float64()),  # by a series of the car's speed; null: none
    ]
)
"""One row for each evaluated frame, by recording and frame."""

BOXES: Final = pa.schema(
    [
        pa.field("recording", pa.string()),
        pa.field("source", pa.string()),
        pa.field("frame", pa.int64()),
        pa.field("x", pa.float64()),
        pa.field("y", pa.float64()),
        pa.field("w", pa.float64()),
        pa.field("h", pa.float64()),
        pa.field("score", pa.float64()),
        pa.field("track", pa.int64()),
        pa.field("ignore", pa.bool_()),
        pa.field("distance_m", pa.float64()),
        pa.field("occlusion", pa.int8()),
        pa.field("label", pa.string()),  # class in the words of the objects; null: not said
        pa.field("attributes", pa.string()),  # what the truth says of the pedestrian; null: nothing
        pa.field("detectability", pa.float64()),
        pa.field("detectability_sd", pa.float64()),
        pa.field("is_outside", pa.bool_()),
        pa.field("is_adapted", pa.bool_()),
    ]
)
"""Boxes of truth and systems, by recording, source and frame; the order within a frame is kept."""

FACTS: Final = ("width", "height", "fps", "horizon", "context", "speed_kmh")
"""Columns of `RECORDINGS` that are numbers which a session states."""

MISSING: Final = {
    "track": NO_TRACK,
    "ignore": False,
    "occlusion": UNKNOWN_OCCLUSION,
    "is_outside": False,
    "is_adapted": False,
}
"""What stands in a dataset for a missing cell of a column of `BOXES` that has no NaN."""

TRUTH_KINDS: Final = ("annotated", "automatic", "absent")
"""Whether people annotated the truth, a program did, or there is none; the first by default."""

SCHEMAS: Final = {"frames": FRAMES, "boxes": BOXES, "recordings": RECORDINGS, "sources": SOURCES}
"""Tables of a store, each a Delta table in a folder of this name, in the order of writing: what
refers to others later than these."""

_TEXT: Final = pa.dictionary(pa.int32(), pa.string())
IN_MEMORY: Final = {
    name: pa.schema(
        [field.with_type(_TEXT) if field.type == pa.string() else field for field in SCHEMAS[name]]
    )
    for name in ("frames", "boxes")
}
"""Frames and boxes in memory: each text is held once."""

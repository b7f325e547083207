"""Tables of a store and of a scan's results: their columns, and where each lies."""

from __future__ import annotations

from typing import Final

import pyarrow as pa

from nvcore.dataset.schema import NO_TRACK, UNKNOWN_OCCLUSION

FACTS: Final = ("width", "height", "fps", "horizon", "context", "speed_kmh")
"""Columns of `RECORDINGS` with numbers that a session states."""

_INDEX: Final = (
    ("file", pa.string()),  # path within the table's folder
    ("first_row", pa.int64()),  # its first row within the file
    ("n_rows", pa.int64()),
)
"""Location of the rows of a recording (or of one of its sources): a range in one file."""

RECORDINGS: Final = pa.schema(
    [
        ("recording", pa.string()),  # its name, the id by which results are ordered
        ("sha256", pa.string()),  # over the facts below and its frames
        ("ingested_at", pa.timestamp("us", "UTC")),
        *((name, pa.float64()) for name in FACTS),
        ("tags", pa.list_(pa.string())),  # "night", or "road=rural"
        ("unit", pa.string()),  # drive, vehicle or route that it is part of; empty: none
        ("recorded_at", pa.timestamp("us", "UTC")),  # null: unknown
        ("pictures", pa.string()),  # source URI of its pictures; empty: none
        ("first_picture", pa.int64()),  # frame that the first one shows; null: not stated
        ("objects", pa.list_(pa.string())),  # kind of objects in the boxes: singular, plural
        ("duration_s", pa.float64()),
        ("parameters", pa.string()),  # JSON of the session's settings; empty: by default
        ("source", pa.string()),  # URI of the session that it came with
        *_INDEX,  # its rows of `frames`
    ]
)
"""Versions of recordings. A later row of a version replaces an earlier one."""

SOURCES: Final = pa.schema(
    [
        ("recording", pa.string()),
        ("source", pa.string()),  # "truth", or the name of a system
        ("sha256", pa.string()),  # over its boxes, identifies the version
        ("recording_sha256", pa.string()),  # version of the recording that it came with
        ("label", pa.string()),  # the user's name of this version; empty: its number
        ("kind", pa.string()),  # of a truth: annotated, automatic, absent; else system
        ("ingested_at", pa.timestamp("us", "UTC")),
        ("threshold", pa.float64()),  # of a system, by its session; null: none
        ("inputs", pa.list_(pa.string())),  # sha256 of the files that it was read from
        ("n_left_out", pa.int64()),  # rows of these files that could not be placed
        ("amends", pa.bool_()),  # notes a label or kind; does not make it the newest
        *_INDEX,  # its rows of `boxes`
    ]
)
"""Versions of the truth or a system. A later row of a version replaces an earlier one.

They are written last. A version of a recording counts once there is a source that came with it.
"""

ADDED_LATER: Final = {"parameters": "", "amends": False}
"""Columns that older stores lack, and their values there."""

FRAMES: Final = pa.schema(
    [
        ("recording", pa.string()),
        ("frame", pa.int64()),
        ("speed_kmh", pa.float64()),  # by a series of the car's speed; null: none
    ]
)
"""One row for each evaluated frame, by recording and frame."""

BOXES: Final = pa.schema(
    [
        ("recording", pa.string()),
        ("source", pa.string()),
        ("frame", pa.int64()),
        *((name, pa.float64()) for name in ("x", "y", "w", "h", "score")),
        ("track", pa.int64()),
        ("ignore", pa.bool_()),
        ("distance_m", pa.float64()),
        ("occlusion", pa.int8()),
        ("label", pa.string()),  # class in the objects' terms; null: unknown
        ("attributes", pa.string()),  # attributes of the pedestrian in the truth; null: none
        ("detectability", pa.float64()),
        ("detectability_sd", pa.float64()),
        ("is_outside", pa.bool_()),
        ("is_adapted", pa.bool_()),
    ]
)
"""Boxes of truth and systems, by recording, source and frame, in order within a frame."""

MISSING: Final = {
    "track": NO_TRACK,
    "ignore": False,
    "occlusion": UNKNOWN_OCCLUSION,
    "is_outside": False,
    "is_adapted": False,
}
"""Value in a dataset for a missing cell of a column of `BOXES` that cannot be NaN."""

TRUTH_KINDS: Final = ("annotated", "automatic", "absent")
"""Kinds of truth: annotated by people (default), by a program, or no truth."""

SCHEMAS: Final = {"frames": FRAMES, "boxes": BOXES, "recordings": RECORDINGS, "sources": SOURCES}
"""Tables of a store, each a Delta table in a folder of this name. They are written in this order,
so that rows refer only to existing ones."""

_TEXT: Final = pa.dictionary(pa.int32(), pa.string())
IN_MEMORY: Final = {
    name: pa.schema(
        [field.with_type(_TEXT) if field.type == pa.string() else field for field in SCHEMAS[name]]
    )
    for name in ("frames", "boxes")
}
"""Types of frames and boxes in memory, where each text is stored once."""

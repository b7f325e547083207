"""What every key of a report's ``summary.json`` holds: unit, type, and a sentence."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from nvcore.tables.columns import SIMILARITY_COLUMNS, Column, Kind

_TEXT, _INTEGER, _NUMBER = Kind.TEXT, Kind.INTEGER, Kind.NUMBER
_NO_EPISODES = "no episodes"
_NO_FRAMES = "no evaluated frames"

SYSTEM_KEYS: Final[tuple[Column, ...]] = (
    Column("name", _TEXT, "", "Name of the system."),
    Column(
        "threshold", _NUMBER, "", "Score below which detections are left out.",
        empty="none was given (every detection counts), or it is infinite",
    ),
    Column("detections", _INTEGER, "boxes", "Sum of `n_det` of `frames.csv`."),
    Column(
        "detections_without_distance", _INTEGER, "boxes",
        "Of these, weighted by height because `proximity` is `distance` and they have none.",
    ),
    *(replace(column, empty=_NO_FRAMES) for column in SIMILARITY_COLUMNS),
    Column(
        "saliency", _NUMBER, "s",
        "The largest saliency event, or the sum of all (`saliency_aggregate`); 0 without any.",
        "low",
    ),
    Column(
        "encounters_detected", _INTEGER, "encounters", "Encounters that the system detected.",
        "high",
    ),
    *(
        Column(
            f"miss_classes.{name}", _INTEGER, "encounters",
            f"Encounters with the miss class `{name}`, distant ones left out.", better,
        )
        for name, better in (
            ("never", "low"), ("late", "low"), ("dropout", "low"), ("lost_early", "low"),
            ("brief", "low"), ("none", "high"),
        )
    ),
    Column(
        "boxes_matched", _INTEGER, "boxes",
        "Annotated pedestrian boxes matched, those of distant encounters too.", "high",
    ),
    Column("false_alarms", _INTEGER, "boxes", "Detections that match nobody.", "low"),
    Column(
        "false_alarms_per_frame", _NUMBER, "1/frame", "The same per evaluated frame.",
        "low", _NO_FRAMES,
    ),
    Column("false_alarms_per_minute", _NUMBER, "1/min", "The same per minute.", "low", _NO_FRAMES),
    Column(
        "false_alert_episodes", _INTEGER, "episodes",
        "False alarms linked over frames: what the driver notices as one.", "low",
    ),
    Column(
        "false_alert_episodes_per_hour", _NUMBER, "1/h", "The same per hour.", "low", _NO_FRAMES
    ),
    Column("mean_episode_s", _NUMBER, "s", "Mean duration of an episode.", "low", _NO_EPISODES),
    Column("longest_episode_s", _NUMBER, "s", "The longest one.", "low", _NO_EPISODES),
)  # fmt: skip
"""Keys of each system: below `x` and `y`, and below `fusion` for their combinations."""

SUMMARY_KEYS: Final[tuple[Column, ...]] = (
    Column("version", _TEXT, "", "Version of nvcore."),
    Column(
        "fingerprint", _TEXT, "",
        "SHA-256 of the input files' content, how they were read, sizes, frame rates, and "
        "evaluated frames. The parameters are not in it.",
    ),
    Column("parameters", Kind.TABLE, "", "Every parameter by name; null where it has no value."),
    Column("recordings", _INTEGER, "recordings", "Recordings compared."),
    Column("frames", _INTEGER, "frames", "Evaluated frames."),
    Column("duration_s", _NUMBER, "s", "Sum of their time steps."),
    Column("truth.boxes", _INTEGER, "boxes", "Annotated pedestrians, ignore regions left out."),
    Column("truth.boxes_ignored", _INTEGER, "boxes", "Ignore regions."),
    Column("truth.encounters", _INTEGER, "encounters", "Encounters, distant ones included."),
    Column(
        "truth.recordings_with_linked_tracks", _INTEGER, "recordings",
        "Recordings whose truth has no track ids (or not everywhere), so that tracks were linked.",
    ),
    Column(
        "truth.boxes_without_distance", _INTEGER, "boxes",
        "Pedestrians weighted by height because `proximity` is `distance` and they have none.",
    ),
    Column("x", Kind.TABLE, "", "System X; the keys are those of each system, below."),
    Column("y", Kind.TABLE, "", "System Y; the same keys."),
    Column("venn.both", _INTEGER, "encounters", "Encounters that both systems detected."),
    Column("venn.x_only", _INTEGER, "encounters", "Encounters that only X detected."),
    Column("venn.y_only", _INTEGER, "encounters", "Encounters that only Y detected."),
    Column("venn.neither", _INTEGER, "encounters", "Encounters that neither system detected."),
    Column(
        "venn.distant", _INTEGER, "encounters", "Encounters that never came near enough to count."
    ),
    Column(
        "dominant", _TEXT, "",
        "`x` or `y`: the system that detects every encounter that the other does, and more.",
        empty="neither does",
    ),
    Column("exclusivity.missed_by_x", _INTEGER, "encounters", "Encounters that X missed.", "low"),
    Column("exclusivity.missed_by_y", _INTEGER, "encounters", "Encounters that Y missed.", "low"),
    Column("exclusivity.missed_by_both", _INTEGER, "encounters", "Those that both missed.", "low"),
    Column(
        "exclusivity.jaccard", _NUMBER, "0 to 1",
        "Shared misses over all misses: 0 no miss is shared, 1 all are.", empty="no misses",
    ),
    Column(
        "exclusivity.phi", _NUMBER, "-1 to 1", "Correlation of the two systems' misses.",
        empty="a system misses none or all",
    ),
    Column(
        "exclusivity.mcnemar_p", _NUMBER, "0 to 1",
        "Exact McNemar p: how likely a split of `x_only` against `y_only` at least this uneven is "
        "if both are equally good.",
    ),
    Column("boxes.both", _INTEGER, "boxes", "Pedestrian boxes that both systems matched."),
    Column("boxes.x_only", _INTEGER, "boxes", "Pedestrian boxes that only X matched."),
    Column("boxes.y_only", _INTEGER, "boxes", "Pedestrian boxes that only Y matched."),
    Column("boxes.neither", _INTEGER, "boxes", "Pedestrian boxes that neither system matched."),
    Column(
        "lead_time_s.encounters", _INTEGER, "encounters",
        "Encounters that both systems matched in a relevant frame.",
    ),
    Column(
        "lead_time_s.mean", _NUMBER, "s",
        "Mean lead of X over Y in these; negative: Y was first.", empty="no such encounter",
    ),
    Column("lead_time_s.median", _NUMBER, "s", "Its median.", empty="no such encounter"),
    Column("fusion.x_or_y", Kind.TABLE, "", "What `X or Y` would do; the same keys."),
    Column("fusion.x_and_y", Kind.TABLE, "", "What `X and Y` would do; the same keys."),
)  # fmt: skip
"""Keys of ``summary.json`` in order, nested ones with dots; those of a system are `SYSTEM_KEYS`."""

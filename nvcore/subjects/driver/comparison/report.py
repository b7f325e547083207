"""The driver in the report: notes for the verdict and the first page, and a section."""

from __future__ import annotations

from typing import Final

from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.report.remarks import Remarks
from nvcore.report.section import (
    Block,
    Columns,
    Paragraphs,
    Section,
    SectionOf,
    about,
    listing,
    of_both,
)
from nvcore.report.verdict import PointOf
from nvcore.subjects.driver.comparison.columns import driver_views
from nvcore.subjects.driver.comparison.encounters import driver_venn_table, saved_encounters
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.comparison.notes import (
    driver_notes,
    limits,
    weighted_claims,
    weighting,
    weighting_notes,
)
from nvcore.subjects.driver.comparison.steps import driver_in

POINTS: Final = (
    PointOf("Weighting", weighting_notes, after="Operating points", is_warning=True),
    PointOf("The driver", driver_notes, after="Time left"),
)


def _views(dataset: Dataset) -> list[str]:
    """List for each recording which data on the driver it has: pictures, light meter, gaze."""
    views = driver_views(dataset)
    words_of = {
        "pictures of visible light": views["has_visible"],
        "light meter": views["light_by"] == "meter",
        "gaze": views["has_gaze"],
    }
    return [
        capitalised(", ".join(text for text, is_there in words_of.items() if is_there[i]))
        for i in range(len(dataset.recordings))
    ]


REMARKS: Final = Remarks(weighting, limits, weighted_claims, ("Driver's view", _views))


def driver_section(result: Result) -> Section:
    """Return the report's section about the driver: notes, regions and saved encounters."""
    regions = driver_venn_table(result)
    is_shown = (regions["encounters"] > 0) | (regions["region"] != DriverRegion.UNKNOWN)
    of_regions: Columns = {
        "Seen by": "who",
        "Encounters": ("encounters", "d"),
        **of_both("Severity for {} (s)", "severity_{}", ".2f"),
        "Meaning": "meaning",
    }
    of_saved: Columns = {
        "Recording": "recording",
        "{One}": "track",
        "Alone in time": lambda row: row["system"].upper(),
        "Last chance (frame)": ("urgent_frame", ""),
        "Detectability": ("detectability", ".2f"),
        **of_both("Impact {} (km/h)", "impact_kmh_{}", ".0f"),
    }
    title = "Urgent encounters in time by one system alone, by neither driver nor the other"
    saved = saved_encounters(result)
    blocks: tuple[Block, ...] = (
        Paragraphs(driver_notes(result)),
        listing("Encounters by who sees them", regions[is_shown], of_regions),
        *([listing(title, saved, of_saved)] if len(saved) else []),
    )
    return Section("driver", "The driver", about("driver.section", result), blocks)


SECTIONS: Final = (
    SectionOf("driver", driver_section, applies=lambda result: driver_in(result).has_any),
)

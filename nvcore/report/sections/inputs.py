"""Sections on the inputs of the measures: findings, files, recordings, settings, reading aid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.common.findings import Finding
from nvcore.common.wording import UNDEFINED, capitalised, count_text
from nvcore.comparison.compare import Result
from nvcore.evidence.bootstrap import N_RESAMPLES, SEED
from nvcore.evidence.units import MIN_RECORDINGS
from nvcore.inputs.evaluated_frames import MIN_SAMPLED
from nvcore.inputs.files.hashes import source_hashes
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.kernels import ABSORB_SHARE
from nvcore.metrics.linking import LINK_GAP, LINK_IOU
from nvcore.metrics.proximity import in_use
from nvcore.notes import Note
from nvcore.report.remarks import all_remarks
from nvcore.report.section import (
    Block,
    Cell,
    Columns,
    Fold,
    Paragraphs,
    Row,
    Section,
    Table,
    about,
    listing,
    true_minus,
)
from nvcore.settings.params import SETTINGS
from nvcore.tables.inputs import inputs_table, left_out_table

NOT_SET: Final = "not set"
MOST_FILES: Final = 60
"""Maximum number of input files that are listed. The hash of all is always shown."""


def audit_section(result: Result, findings: Sequence[Finding]) -> Section:
    """Return the section on the findings of the audit."""
    columns: Columns = {
        "Severity": lambda row: row["severity"].value,
        "About": "subject",
        "What was found": "message",
        "First case": lambda row: row["place"] or UNDEFINED,
        "What to do": "advice",
    }
    block: Block = Paragraphs(("The audit found nothing.",))
    if findings:
        rows = [{**vars(finding), "place": finding.place} for finding in findings]
        block = listing(f"{count_text(len(findings), 'finding')}, worst first", rows, columns)
    return Section("audit", "Audit of the inputs", about("sections.audit", result), (block,))


def inputs_section(result: Result, pictures: pd.DataFrame) -> Section:
    """Return the section on input files, conversions, recordings, pictures and skipped rows.

    Parameters
    ----------
    pictures
        Table of `nvcore.tables.pictures.pictures_table`.
    """
    dataset = result.dataset
    blocks: list[Block] = _files(result) if len(dataset.inputs) else []
    recordings = (_recordings(result), *([_pictures(pictures)] if len(pictures) else []))
    blocks.append(Fold("Recordings: size, rate, horizon, tags and pictures", recordings))
    if dataset.notes:
        blocks.append(Paragraphs(tuple(f"{capitalised(note)}." for note in dataset.notes)))
    if n_linked := len(result.tracks.linked_recordings):
        blocks.append(Paragraphs((Note("sections.linked", n=n_linked),)))
    left_out = left_out_table(dataset)
    if len(left_out):
        columns: Columns = {"Source": "subject", "Reason": "reason", "Rows": ("n_rows", "")}
        blocks.append(listing("Rows that could not be placed", left_out, columns))
    introduction = about("sections.inputs", result)
    return Section("inputs", "Input files and recordings", introduction, tuple(blocks))


def _files(result: Result) -> list[Block]:
    dataset = result.dataset
    hashes = source_hashes(dataset)
    roles = {"truth": "ground truth", result.x.name: "X", result.y.name: "Y"}
    sources: Columns = {
        "Source": "subject",
        "Role": lambda row: roles.get(row["subject"], "not compared"),
        "Format": "format",
        "Conversion": "conversion",
        "Left out": lambda row: row["left_out"] or UNDEFINED,
        "Files": ("n_files", "d"),
        "Boxes": ("n_boxes", "d"),
        "SHA-256 of its files' hashes": lambda row: hashes[row["subject"]],
    }
    files: Columns = {"Source": "subject", "File": "file", "SHA-256": "sha256"}
    return [
        Fold(
            "Sources and files, with conversions and hashes",
            (
                listing("Sources", inputs_table(dataset), sources),
                listing("Files", dataset.inputs, files, most=MOST_FILES),
            ),
        ),
        Paragraphs((f"Fingerprint of all: {dataset.fingerprint}",)),
    ]


def span_in_use(result: Result, name: str) -> str:
    """Return a setting's value in use, px, such as "48", or "48 to 57.6" if recordings differ."""
    values = in_use(result.params, name, result.dataset.frame_columns)
    if not len(values):
        return NOT_SET
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _recordings(result: Result) -> Table:
    dataset = result.dataset
    frames = dataset.frame_columns
    rows = dataset.recordings.assign(
        n_frames=np.diff(frames.first),
        midpoint=in_use(result.params, "midpoint", frames),
        spread=in_use(result.params, "spread", frames),
    )
    columns: Columns = {
        "Recording": "name",
        "Size (px)": (lambda row: f"{row['width']:g} x {row['height']:g}", ""),
        "Frames per second": (lambda row: f"{row['fps']:g}", ""),
        "Evaluated frames": ("n_frames", "d"),
        "Midpoint (px)": (lambda row: f"{row['midpoint']:.4g}", ""),
        "Spread (px)": (lambda row: f"{row['spread']:.4g}", ""),
        "Horizon (px)": ("horizon", "g"),
        "Tags": lambda row: ", ".join(row["tags"]) or UNDEFINED,
    }
    for title, texts_of in (remarks.recordings for remarks in all_remarks()):
        texts = texts_of(dataset)
        if any(texts):
            rows[title] = [text or UNDEFINED for text in texts]
            columns[title] = title
    return listing("Recordings", rows, columns)


def _pictures(pictures: pd.DataFrame) -> Table:
    columns: Columns = {"Recording": "recording", "Pictures": "pictures"}
    columns |= {f"{of.capitalize()} frame": _picture_of(of) for of in ("first", "middle", "last")}
    columns["Without"] = (lambda row: f"{row['n_without']:,} of {row['n_frames']:,}", "")
    return listing("Which picture shows which frame", pictures, columns, most=MOST_FILES)


def _picture_of(which: str) -> Cell:
    return lambda row: f"{row[f'{which}_frame']}: {row[f'{which}_picture']}"


def parameters_section(result: Result) -> Section:
    """Return the section on all settings with their meanings, and on the constants."""
    stated = result.params.stated(result.dataset)
    rows = [_setting(result, name) for name in SETTINGS if name in stated]
    columns: Columns = {
        name.capitalize(): name for name in ("parameter", "value", "default", "range", "meaning")
    }
    constants = {
        "weight of nearness from which a frame counts": f"{RELEVANT_K:g}",
        "share of a detection on an ignored region that absorbs it": f"{ABSORB_SHARE:g}",
        "smallest overlap of linked boxes": f"{LINK_IOU:g}",
        "largest gap of linked boxes, evaluated frames": f"{LINK_GAP}",
        "annotated frames from which sampling is inferred": f"{MIN_SAMPLED}",
        "resamples of the bootstrap": f"{N_RESAMPLES:,}",
        "seed of the bootstrap and of random exchanges": f"{SEED}",
        "recordings below which blocks of time are resampled": f"{MIN_RECORDINGS}",
        "version of nvcore": __version__,
    }
    fixed = [{"name": name, "value": value} for name, value in constants.items()]
    changed = [row for row in rows if row["is_changed"]]
    of_fixed: Columns = {"What": "name", "Value": ("value", "")}
    blocks: tuple[Block, ...] = (
        listing("Parameters that are not at their defaults", changed, columns),
        Fold("All parameters", (listing("Parameters", rows, columns),)),
        Fold("Fixed numbers", (listing("Fixed numbers", fixed, of_fixed),)),
    )
    return Section("parameters", "Parameters", about("sections.parameters", result), blocks)


def _setting(result: Result, name: str) -> Row:
    """Return the table row of a setting. If it is not set, the row shows the value in use."""
    setting, value = SETTINGS[name], getattr(result.params, name)
    shown = _value(value)
    if value is None:
        shown = NOT_SET if setting.height_share is None else span_in_use(result, name)
    is_changed = value != setting.default
    unit = f" {setting.unit}" if setting.unit and shown != NOT_SET else ""
    return {
        "parameter": name,
        "value": f"{shown}{unit}{', changed' if is_changed else ''}",
        "default": _value(setting.default),
        "range": true_minus(setting.range_text),
        "meaning": result.objects.say(setting.meaning),
        "is_changed": is_changed,
    }


def _value(value: Any) -> str:
    if value is None:
        return UNDEFINED
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def reading_section(result: Result) -> Section:
    """Return the section that explains the report's terms: X, Y, truth, match and encounter."""
    notes = (
        Note("sections.systems"),
        Note("sections.truth"),
        about("sections.match", result),
        Note("sections.encounter", relevant_k=RELEVANT_K),
        about("sections.styles", result),
    )
    return Section("reading", "How to read this report", None, (Paragraphs(notes),))

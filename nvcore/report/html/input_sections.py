"""Sections on what the measures are computed from: findings, files, recordings, parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.comparison import Result
from nvcore.evidence.bootstrap import N_RESAMPLES, SEED
from nvcore.evidence.units import MIN_RECORDINGS
from nvcore.findings import Finding
from nvcore.inputs.evaluated_frames import MIN_SAMPLED
from nvcore.inputs.hashes import source_hashes
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.kernels import ABSORB_SHARE
from nvcore.metrics.linking import LINK_GAP, LINK_IOU
from nvcore.metrics.proximity import in_use
from nvcore.params import SETTINGS
from nvcore.report.html import words
from nvcore.report.html.blocks import Block, Fold, Section, Sentences, Table, table, true_minus
from nvcore.subjects import contributed
from nvcore.tables.inputs import inputs_table, left_out_table
from nvcore.wording import UNDEFINED, capitalised, count_text, number

NOT_SET: Final = "not set"
MOST_FILES: Final = 60
"""Most input files that are listed one by one; the hash of all is always shown."""


def audit_section(findings: Sequence[Finding]) -> Section:
    """What the audit of the inputs found."""
    if not findings:
        nothing = Sentences(("The audit found nothing.",))
        return Section("audit", "Audit of the inputs", words.AUDIT, (nothing,))
    rows = [
        (
            finding.severity.value,
            finding.subject,
            finding.message,
            finding.place or UNDEFINED,
            finding.advice,
        )
        for finding in findings
    ]
    head = ("Severity", "About", "What was found", "First case", "What to do")
    listing = table(f"{count_text(len(findings), 'finding')}, worst first", head, rows)
    return Section("audit", "Audit of the inputs", words.AUDIT, (listing,))


def inputs_section(result: Result, pictures: pd.DataFrame) -> Section:
    """Files with hashes and conversions, recordings, pictures, and what was left out.

    Parameters
    ----------
    pictures
        As `nvcore.tables.pictures.pictures_table` gives them.
    """
    dataset = result.dataset
    blocks: list[Block] = []
    if len(dataset.inputs):
        blocks += _files(result)
    recordings = (_recordings(result), *([_pictures(pictures)] if len(pictures) else []))
    blocks.append(Fold("Recordings: size, rate, horizon, tags and pictures", recordings))
    if dataset.notes:
        blocks.append(Sentences(tuple(f"{capitalised(note)}." for note in dataset.notes)))
    n_linked = len(result.tracks.linked_recordings)
    if n_linked:
        text = (
            f"The truth of {count_text(n_linked, 'recording')} has {result.objects.plural} without "
            "track ids: they were linked to encounters by overlap from frame to frame."
        )
        blocks.append(Sentences((text,)))
    left_out = left_out_table(dataset)
    if len(left_out):
        rows = [tuple(row) for row in left_out.itertuples(index=False)]
        blocks.append(
            table("Rows that could not be placed", ("Source", "Reason", "Rows"), rows, right=(2,))
        )
    return Section("inputs", "Input files and recordings", words.INPUTS, tuple(blocks))


def _files(result: Result) -> list[Block]:
    dataset = result.dataset
    hashes = source_hashes(dataset)
    roles = {"truth": "ground truth", result.x.name: "X", result.y.name: "Y"}
    sources = [
        (
            row["subject"],
            roles.get(row["subject"], "not compared"),
            row["format"],
            row["conversion"],
            row["left_out"] or UNDEFINED,
            f"{row['n_files']:,}",
            f"{row['n_boxes']:,}",
            hashes[row["subject"]],
        )
        for row in inputs_table(dataset).to_dict("records")
    ]
    head = (
        "Source",
        "Role",
        "Format",
        "Conversion",
        "Left out",
        "Files",
        "Boxes",
        "SHA-256 of its files' hashes",
    )
    files = dataset.inputs[["subject", "file", "sha256"]].to_numpy().tolist()
    return [
        Fold(
            "Sources and files, with conversions and hashes",
            (
                table("Sources", head, sources, right=(5, 6)),
                table("Files", ("Source", "File", "SHA-256"), files, most=MOST_FILES),
            ),
        ),
        Sentences((f"Fingerprint of all: {dataset.fingerprint}",)),
    ]


def span_in_use(result: Result, name: str) -> str:
    """The setting in use, px: "48", or "48 to 57.6" where recordings differ."""
    values = in_use(result.params, name, result.dataset.frame_columns)
    if not len(values):
        return NOT_SET
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def _recordings(result: Result) -> Table:
    dataset = result.dataset
    frames = dataset.frame_columns
    n_frames = np.diff(frames.first)
    midpoint, spread = (
        in_use(result.params, name, frames).tolist() for name in ("midpoint", "spread")
    )
    rows: list[tuple[str, ...]] = [
        (
            row["name"],
            f"{row['width']:g} x {row['height']:g}",
            f"{row['fps']:g}",
            f"{n_frames[i]:,}",
            f"{midpoint[i]:.4g}",
            f"{spread[i]:.4g}",
            number(row["horizon"], "g"),
            ", ".join(row["tags"]) or UNDEFINED,
        )
        for i, row in enumerate(dataset.recordings.to_dict("records"))
    ]
    head: tuple[str, ...] = (
        "Recording",
        "Size (px)",
        "Frames per second",
        "Evaluated frames",
        "Midpoint (px)",
        "Spread (px)",
        "Horizon (px)",
        "Tags",
    )
    for title, texts_of in (remarks.recordings for remarks in contributed("remarks")):
        texts = texts_of(dataset)
        if any(texts):
            head = (*head, title)
            rows = [(*row, text or UNDEFINED) for row, text in zip(rows, texts, strict=True)]
    return table("Recordings", head, rows, right=range(1, 7))


def _pictures(pictures: pd.DataFrame) -> Table:
    rows = [
        (
            row["recording"],
            row["pictures"],
            *(f"{row[f'{w}_frame']}: {row[f'{w}_picture']}" for w in ("first", "middle", "last")),
            f"{row['n_without']:,} of {row['n_frames']:,}",
        )
        for row in pictures.to_dict("records")
    ]
    head = ("Recording", "Pictures", "First frame", "Middle frame", "Last frame", "Without")
    return table("Which picture shows which frame", head, rows, right=(5,), most=MOST_FILES)


def parameters_section(result: Result) -> Section:
    """Every setting with its meaning, and the constants."""
    stated = result.params.stated(result.dataset)
    rows, rows_changed = [], []
    for name, setting in SETTINGS.items():
        if name not in stated:
            continue
        value = getattr(result.params, name)
        shown = _value(value) if value is not None else _fallback(result, name)
        in_unit = f"{shown} {setting.unit}" if setting.unit and shown != NOT_SET else shown
        is_changed = value != setting.default
        text = f"{in_unit}, changed" if is_changed else in_unit
        meaning = result.objects.say(setting.meaning)
        row = name, text, _value(setting.default), true_minus(setting.range_text), meaning
        rows.append(row)
        if is_changed:
            rows_changed.append(row)
    head = ("Parameter", "Value", "Default", "Range", "Meaning")
    constants = (
        ("weight of nearness from which a frame counts", f"{RELEVANT_K:g}"),
        ("share of a detection on an ignored region that absorbs it", f"{ABSORB_SHARE:g}"),
        ("smallest overlap of linked boxes", f"{LINK_IOU:g}"),
        ("largest gap of linked boxes, evaluated frames", f"{LINK_GAP}"),
        ("annotated frames from which sampling is inferred", f"{MIN_SAMPLED}"),
        ("resamples of the bootstrap", f"{N_RESAMPLES:,}"),
        ("seed of the bootstrap and of random exchanges", f"{SEED}"),
        ("recordings below which blocks of time are resampled", f"{MIN_RECORDINGS}"),
        ("version of nvcore", __version__),
    )
    return Section(
        "parameters",
        "Parameters",
        words.PARAMETERS,
        (
            table("Parameters that are not at their defaults", head, rows_changed),
            Fold("All parameters", (table("Parameters", head, rows),)),
            Fold(
                "Fixed numbers",
                (table("Fixed numbers", ("What", "Value"), constants, right=(1,)),),
            ),
        ),
    )


def _fallback(result: Result, name: str) -> str:
    """The value in place of a setting that is not set, in words."""
    return NOT_SET if SETTINGS[name].height_share is None else span_in_use(result, name)


def _value(value: Any) -> str:
    if value is None:
        return UNDEFINED
    return f"{value:g}" if isinstance(value, int | float) else str(value)

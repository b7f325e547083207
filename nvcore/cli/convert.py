"""``nvcore convert``: any readable format as plain CSV, Parquet, COCO or MOTChallenge."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.cli.options import (
    examples,
    format_option,
    objects_option,
    options_of,
    reading_options,
    with_options,
)
from nvcore.cli.remedies import ways_text
from nvcore.cli.session_options import objects_from_option, size_option, source_options
from nvcore.cli.steps import findings_shown, pasteable_errors, shown_paths
from nvcore.common.wording import one_line
from nvcore.inputs.session import Source
from nvcore.inputs.session.arguments import ConvertArguments

if TYPE_CHECKING:
    from nvcore.inputs.readers.base import Role

# As in nvcore/cli/__init__.py, numpy and pandas are imported by the command only.


@click.command(
    epilog=examples(
        "nvcore convert drives --to csv --out truth.csv",
        "nvcore convert results.json --role detections --truth truth.json --to mot --out drives",
    )
)
@click.argument("source", metavar="INPUT")
@click.argument(
    "target", metavar="[OUTPUT]", required=False, type=click.Path(path_type=Path), default=None
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="OUTPUT",
    help="The same as OUTPUT, for those who like a flag.",
)
@options_of(ConvertArguments)
@format_option
@objects_option
@with_options(*reading_options)
def convert(source: str, target: Path | None, out: Path | None, **options: Any) -> None:
    """Convert any readable format to plain CSV, Parquet, COCO or MOTChallenge.

    INPUT is a file, folder or quoted glob. OUTPUT is packed if its name ends in .gz, .zst, .xz or
    .bz2. MOTChallenge has one file a recording: OUTPUT is a folder where there are several.
    """
    from nvcore.inputs.conversion import convert
    from nvcore.report.terminal import render_findings

    if (target is None) == (out is None):
        raise click.UsageError("give the file or folder to write once: as OUTPUT or --out OUTPUT")
    target = target or out
    assert target is not None
    kind: Role = options["role"] or "truth"
    frames_out = options["frames_out"]
    if frames_out is not None and kind == "detections":
        raise click.UsageError("--frames-out is for ground truth, whose frames are evaluated")
    origin = Source((source,), format=options["format"], **source_options(options))
    truth = Source((options["truth"],)) if options["truth"] else None
    sources: list[tuple[Source, Role]] = [(origin, kind)]
    sources += [] if truth is None else [(truth, "truth")]
    with pasteable_errors(Path.cwd(), sources):
        conversion = convert(
            origin,
            target,
            options["to"],
            role=options["role"],
            truth=truth,
            frames_out=frames_out,
            force=options["force"],
            size=size_option(options),
            objects=objects_from_option(options),
        )
    _say(f"{source}: {conversion.conversion}")
    if conversion.findings:
        path = shown_paths(Path.cwd(), sources)
        click.echo(render_findings(findings_shown(conversion.findings, path)), err=True)
    files = conversion.files
    where = files[0] if len(files) == 1 else f"{len(files)} files in {target}"
    _say(f"written to {where}: {conversion.n_boxes} boxes")
    for warning in conversion.warnings:
        _say(f"warning: {warning}")
    if conversion.steps:
        _say(ways_text(conversion.steps, {}))
    if len(conversion.frame_files) == 1:
        _say(
            f"frame list written to {frames_out}: {conversion.n_frames} frames; give it as "
            f"--frames {frames_out}"
        )
    elif conversion.frame_files:
        _say(
            f"frame lists of {len(conversion.frame_files) - 1} recordings written to {frames_out}: "
            f"copy {conversion.frame_files[-1].name} there into a session file in that folder"
        )


def _say(text: str) -> None:
    click.echo(one_line(text), err=True)

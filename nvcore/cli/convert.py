"""``nvcore convert``: any readable format as plain CSV, Parquet, COCO or MOTChallenge."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.cli.options import examples, format_option, objects_option, reading_options
from nvcore.cli.session_options import objects_from_option, size_option, source_options
from nvcore.cli.steps import findings_shown, pasteable_errors, shown_paths
from nvcore.inputs.session import Source
from nvcore.objects import PEDESTRIAN
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.inputs.readers.base import Role

# As in nvcore/cli/__init__.py, numpy and pandas are imported by the command only.


def _reading_options(command: Any) -> Any:
    for option in reversed(reading_options):
        command = option(command)
    return command


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
@click.option(
    "--to",
    "to",
    type=click.Choice(["csv", "parquet", "coco", "mot"]),
    help="Format to write. Default: by the ending of OUTPUT: .csv, .parquet, .json (coco), .txt "
    "(mot).",
)
@click.option(
    "--role",
    type=click.Choice(["truth", "detections"]),
    help="What the input holds. Default: truth; an input with scores is refused without it.",
)
@click.option(
    "--truth", metavar="PATH", help="Ground truth, for results that name pictures by number."
)
@click.option(
    "--frames-out",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Write the evaluated frames of the truth here, for --frames: a file, or a folder if the "
    "recordings differ in them.",
)
@click.option("--force", is_flag=True, help="Replace files that exist (never the input).")
@format_option
@objects_option
@_reading_options
def convert(
    source: str,
    target: Path | None,
    out: Path | None,
    to: str | None,
    role: str | None,
    frames_out: Path | None,
    force: bool,
    **options: Any,
) -> None:
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
    kind: Role = "detections" if role == "detections" else "truth"
    if frames_out is not None and kind == "detections":
        raise click.UsageError("--frames-out is for ground truth, whose frames are evaluated")
    origin = Source((source,), format=options["format_"], **source_options(options))
    truth = Source((options["truth"],)) if options["truth"] else None
    sources: list[tuple[Source, Role]] = [(origin, kind)]
    sources += [] if truth is None else [(truth, "truth")]
    with pasteable_errors(Path.cwd(), sources):
        conversion = convert(
            origin,
            target,
            to,
            role=None if role is None else kind,
            truth=truth,
            size=size_option(options),
            objects=objects_from_option(options) or PEDESTRIAN,
            frames_out=frames_out,
            force=force,
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

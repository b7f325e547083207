"""``nvcore convert``: any readable format as plain CSV, COCO or MOTChallenge."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.cli.options import (
    findings_at_paths,
    format_option,
    pasteable_errors,
    reading_options,
    size_option,
    source_options,
)
from nvcore.errors import InputError, MissingFactError
from nvcore.inputs.session import Source
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.inputs.evaluated_frames import LostFrames
    from nvcore.inputs.readers.base import Format, Reading, Role, SourceFile

# As in cli.py, numpy and pandas are imported by the command only.


def _reading_options(command: Any) -> Any:
    for option in reversed(reading_options):
        command = option(command)
    return command


@click.command()
@click.argument("source", metavar="INPUT")
@click.argument("target", metavar="OUTPUT", type=click.Path(path_type=Path))
@click.option(
    "--to", "to", required=True, type=click.Choice(["csv", "coco", "mot"]), help="Format to write."
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
@_reading_options
def convert(
    source: str,
    target: Path,
    to: str,
    role: str | None,
    frames_out: Path | None,
    force: bool,
    **options: Any,
) -> None:
    """Convert any readable format to plain CSV, COCO or MOTChallenge.

    INPUT is a file, folder or quoted glob. MOTChallenge has one file a recording: OUTPUT is a
    folder where there are several.
    """
    from nvcore.inputs.convert import write
    from nvcore.inputs.evaluated_frames import frames_lost_without_list
    from nvcore.inputs.files import paths_to_show
    from nvcore.inputs.load import read_source
    from nvcore.report.terminal import render_findings

    kind: Role = "detections" if role == "detections" else "truth"
    if frames_out is not None and kind == "detections":
        raise click.UsageError("--frames-out is for ground truth, whose frames are evaluated")
    size = size_option(options)
    one = Source((source,), format=options["format_"], **source_options(options))
    other = Source((options["truth"],)) if options["truth"] else None
    sources: list[tuple[Source, Role]] = [(one, kind)]
    sources += [] if other is None else [(other, "truth")]
    inputs, truth = [], None
    with pasteable_errors(Path.cwd(), sources):
        if other is not None:
            inputs += [file.path for file in _files_of(other, "truth", is_guess=False)[0]]
            truth = read_source(other, role="truth", size=size)
        files, chosen = _files_of(one, kind, is_guess=role is None)
        inputs += [file.path for file in files]
        if role is None and _has_scores(files, chosen, one, size):
            raise click.UsageError(
                f"{source}: this has scores, as detections have; give --role detections to keep "
                "them, or --role truth to leave them out"
            )
        reading = _with_size(read_source(one, role=kind, size=size, truth=truth), size)
    shown = paths_to_show(Path.cwd(), sources)
    lost = None
    if kind == "truth":
        try:
            lost = frames_lost_without_list(reading)
        except MissingFactError as error:  # frame numbers such as times: boxes can be written
            if to == "coco" or frames_out is not None:
                raise
            _say(f"warning: {error}")
    images = None if truth is None else truth.images
    written = write(reading, to, target, role=kind, images=images, inputs=inputs, force=force)
    _say(f"{source}: {reading.conversion}")
    if reading.findings:
        click.echo(render_findings(findings_at_paths(reading.findings, shown)), err=True)
    where = written[0] if len(written) == 1 else f"{len(written)} files in {target}"
    _say(f"written to {where}: {len(reading.boxes)} boxes")
    if lost is None:
        return
    if to == "coco":
        _tell_lacking_size(reading)
    else:
        _tell_lost_frames(lost, to, frames_out is not None)
    if frames_out is not None:
        _write_frames(lost, frames_out, [*inputs, *written], force)


def _say(text: str) -> None:
    click.echo(one_line(text), err=True)


def _files_of(source: Source, role: Role, *, is_guess: bool) -> tuple[list[SourceFile], Format]:
    """The files of the input; an input that holds detections says which flag to give."""
    from nvcore.inputs.files import find_files
    from nvcore.inputs.readers import NOTHING

    folder = Path.cwd()
    try:
        return find_files(source, folder, role)
    except InputError:
        if not is_guess:
            raise
        with suppress(InputError):
            _, chosen = find_files(source, folder, "detections")
            if chosen is not NOTHING:
                raise click.UsageError(
                    f"{source.path[0]}: this holds detections; give --role detections"
                ) from None
        raise


def _has_scores(
    files: list[SourceFile], chosen: Format, source: Source, size: tuple[int, int] | None
) -> bool:
    """Whether files of ground truth, read as detections, have scores other than 0 and 1.

    Those two are MOTChallenge's mark of rows to ignore and to count, in the column of the scores.
    """
    from nvcore.inputs.readers.base import ReadOptions

    if "detections" not in chosen.roles:
        return False
    options = ReadOptions(
        role="detections",
        classes=source.classes,
        size=size,
        frame_base=source.frame_base,
        box_base=source.box_base,
    )
    try:
        scores = chosen.read(files, options).boxes["score"].dropna()
    except InputError:  # what is wrong is told when they are read as ground truth
        return False
    return bool((~scores.isin([0, 1, -1])).any())


def _with_size(reading: Reading, size: tuple[int, int] | None) -> Reading:
    """The reading with the given size for recordings whose files do not say theirs."""
    if size is None:
        return reading
    table = reading.recordings.copy()
    sides = ["width", "height"]
    is_unknown = ~(table[sides] > 0).all(axis=1)
    table.loc[is_unknown, sides] = [float(side) for side in size]
    n_others = int((table[sides].to_numpy() != size).any(axis=1).sum())
    if n_others:
        _say(
            f"warning: the data say another size than --size for {n_others} of {len(table)} "
            "recordings; theirs is written"
        )
    return replace(reading, recordings=table)


def _tell_lacking_size(reading: Reading) -> None:
    n_unknown = int((~(reading.recordings[["width", "height"]] > 0).all(axis=1)).sum())
    if n_unknown:
        _say(
            f"warning: the image size of {n_unknown} of {len(reading.recordings)} recordings is "
            "not known, and their images have no width and height, which many tools want; give "
            "--size WIDTHxHEIGHT"
        )


def _tell_lost_frames(lost: LostFrames, to: str, is_listed: bool) -> None:
    if lost.is_same:
        return
    advice = "" if is_listed else "; write the list too, with --frames-out PATH"
    _say(
        f"warning: {lost.n_empty} of {lost.n_frames} evaluated frames have no box, and {to} cannot "
        f"list frames: read back by itself, {lost.n_again} frames are evaluated{advice}"
    )


def _write_frames(lost: LostFrames, path: Path, inputs: list[Path], force: bool) -> None:
    from nvcore.inputs.convert import write_frame_lists

    files = write_frame_lists(lost.frames, path, inputs=inputs, force=force)
    if len(files) == 1:
        _say(f"frame list written to {path}: {lost.n_frames} frames; give it as --frames {path}")
    else:
        _say(
            f"frame lists of {len(files) - 1} recordings written to {path}: copy {files[-1].name} "
            "there into a session file in that folder"
        )

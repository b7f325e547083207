"""``nvcore sample``: a copy of the sample recordings."""

from __future__ import annotations

from pathlib import Path

import click

from nvcore.cli.app import dashboard
from nvcore.cli.options import examples
from nvcore.cli.steps import say_written
from nvcore.errors import InputError


@click.command(
    short_help="Copy the sample recordings.", epilog=examples("nvcore sample somewhere/else")
)
@click.argument("folder", default="sample_data", type=click.Path(file_okay=False, path_type=Path))
def sample(folder: Path) -> None:
    """Copy the sample recordings into FOLDER (default: sample_data).

    Files of the same names are replaced.
    """
    source = dashboard() / "sample_data"
    if folder.resolve() == source:
        raise InputError("is the folder that would be copied; give another one", file=folder)
    files = [path for path in source.rglob("*") if path.is_file()]
    try:
        for path in files:
            copy = folder / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=folder) from error
    say_written(folder)

"""``nvcore sample``: the sample recordings, generated again."""

from __future__ import annotations

from pathlib import Path

import click

from nvcore.cli.options import examples
from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.wording import one_line


@click.command(
    short_help="Generate the sample recordings again.",
    epilog=examples("nvcore sample somewhere/else"),
)
@click.argument("folder", default="sample_data", type=click.Path(file_okay=False, path_type=Path))
def sample(folder: Path) -> None:
    """Generate the sample recordings again, into FOLDER (default: sample_data)."""
    with needs("report", "drawing the sample recordings needs"):
        from nvcore.sample import generate

    def tell(share: float, name: str) -> None:
        if name:
            click.echo(f"{share:4.0%} {name}", err=True)

    try:
        generate(folder, progress=tell)
    except BrokenPipeError:  # by who reads the progress
        raise
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=folder) from error
    click.echo(one_line(f"written to {folder}"), err=True)

"""Draw the sample recordings again, pictures and simulated study included.

python -m tools.sample                    # into sample_data; some minutes
python -m tools.sample somewhere/else
"""

from __future__ import annotations

from pathlib import Path

import click

from tools.sample import generate


@click.command()
@click.argument("folder", default="sample_data", type=click.Path(file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Generate the sample recordings again, into FOLDER (default: sample_data)."""
    generate(folder, progress=lambda share, name: click.echo(f"{share:4.0%} {name}", err=True))


if __name__ == "__main__":
    main()

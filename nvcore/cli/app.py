"""``nvcore app`` serves the dashboard on this computer, ``nvcore sample`` copies its sample."""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

import click

from nvcore.cli.options import examples
from nvcore.cli.program import EXIT_BAD_INPUT
from nvcore.cli.steps import say_written
from nvcore.common.errors import InputError
from nvcore.common.extras import PACKAGES, needs
from nvcore.inputs.session.toml import read_session

PACKAGE = Path(__file__).resolve().parents[1]


@click.command(
    short_help="Start the dashboard.",
    epilog=examples("nvcore app", "nvcore app night.toml --local-root /path/to/drives"),
)
@click.argument(
    "session", required=False, type=click.Path(dir_okay=False, path_type=Path), metavar="[SESSION]"
)
@click.option(
    "--local-root",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    metavar="DIR",
    help="Visitors may open what lies below this folder.",
)
@click.option(
    "--address",
    metavar="HOST",
    help="Where to listen. Default: localhost, this computer alone; 0.0.0.0 is every network.",
)
@click.option("--port", type=click.IntRange(1, 65535), help="Default: 8501, or the next free one.")
@click.option(
    "--login",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Visitors log in by OpenID Connect, as the section [auth] of this TOML file says.",
)
@click.option("--no-browser", is_flag=True, help="Start without opening a browser.")
def app(
    session: Path | None,
    local_root: Path | None,
    address: str | None,
    port: int | None,
    login: Path | None,
    no_browser: bool,
) -> None:
    """Start the dashboard; Ctrl+C ends it.

    It opens on the sample recordings, or for every visitor on the comparison of the session file
    SESSION (TOML). Other settings of the server are Streamlit's environment variables, such as
    STREAMLIT_SERVER_BASE_URL_PATH. Exit code 0: ended, 2: bad input.
    """
    given = [] if session is None else [f"--session={_checked(session)}"]
    given += [] if local_root is None else [f"--local-root={local_root.absolute()}"]
    given += [] if login is None else [f"--login={login.absolute()}"]
    serve(given, address=address, port=port, no_browser=no_browser)


def serve(given: Sequence[str], *, address: str | None, port: int | None, no_browser: bool) -> None:
    """Run the dashboard until the user stops it.

    Parameters
    ----------
    given
        Flags of ``app.py``.
    address, port, no_browser
        As in ``nvcore app``.

    Raises
    ------
    InputError
        If it is not installed, or cannot listen at the address.
    """
    with needs("app", "the dashboard needs"):
        for package in PACKAGES["app"]:
            import_module(package)
        from streamlit.web.cli import main as streamlit

    # Streamlit takes packages outside a folder "site-packages" for its own checkout
    flags = ["--global.developmentMode=false"]
    flags += [] if address is None else [f"--server.address={address}"]
    flags += [] if port is None else [f"--server.port={port}"]
    flags += ["--server.headless=true"] if no_browser else []
    with _told_where_it_cannot_listen(address), suppress(KeyboardInterrupt, click.Abort):
        # Ctrl+C is the regular way to stop it
        streamlit(
            ["run", str(dashboard() / "app.py"), *flags, "--", *given],
            prog_name="nvcore app",
            standalone_mode=False,
        )


@contextmanager
def _told_where_it_cannot_listen(address: str | None) -> Iterator[None]:
    try:
        yield
    except SystemExit as end:
        # Streamlit has reported that the port is not available
        raise SystemExit(EXIT_BAD_INPUT if end.code == 1 else end.code) from end
    except OSError as error:
        if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
            raise InputError(
                f"the server cannot listen on {address or 'that address'} ({error.strerror}); "
                "expected an address of this computer"
            ) from error
        raise


def dashboard() -> Path:
    """Return the folder of the dashboard, within the installed package or in a checkout.

    Raises
    ------
    InputError
        If the dashboard is not installed.
    """
    for folder in (PACKAGE / "dashboard", PACKAGE.parent):
        if (folder / "app.py").is_file() and (folder / "ui" / "main.py").is_file():
            return folder
    raise InputError(
        "the dashboard is not in this installation; install the wheel of nvcore, or start it from "
        "a checkout"
    )


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


def _checked(path: Path) -> Path:
    """Check that a session file and its files exist, before visitors need them.

    Returns the absolute path.

    Raises
    ------
    InputError
        If one of them is missing.
    """
    from nvcore.inputs.files.find import find_all

    find_all(read_session(path))
    return path.absolute()

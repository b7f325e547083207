"""Optional dependencies (extras), and errors that say how to install them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain
from typing import Final

from nvcore.errors import MissingExtraError
from nvcore.subjects import subjects

REPORT: Final = ("av", "cv2", "plotly", "tsdownsample")
OF_SUBJECTS: Final = dict(chain(*(added.extras.items() for _, added in subjects().values())))
OF_PAGES: Final = chain(*(of.extras.get(name, ()) for name, (_, of) in subjects().items() if of.ui))
APP: Final = (*REPORT, *OF_PAGES, "streamlit")
PACKAGES: Final = {
    "report": REPORT,
    "app": APP,
    "login": (*APP, "authlib", "httpx"),
    **OF_SUBJECTS,
}
"""Names by which the packages of each extra of pyproject.toml are imported."""


@contextmanager
def needs(extra: str, subject: str) -> Iterator[None]:
    """Make failing imports inside this context say which extra to install.

    Parameters
    ----------
    extra
        Of pyproject.toml, which brings the packages.
    subject
        Who needs them, with its verb: ``figures need``.

    Raises
    ------
    MissingExtraError
        If a package of the extra is not installed, in the words of the outermost `needs`; any
        other import error stays as it is.
    """
    try:
        yield
    except (ModuleNotFoundError, MissingExtraError) as error:
        if (error.name or "").partition(".")[0] not in PACKAGES[extra]:
            raise
        raise MissingExtraError(
            f"{subject} more packages: pip install 'nvcore[{extra}]'", name=error.name
        ) from error

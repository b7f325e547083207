"""Optional dependencies (extras), and errors that name the extra to install."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain
from typing import Final

from nvcore.common.errors import MissingExtraError
from nvcore.common.subject import subjects

REPORT: Final = ("av", "cv2", "plotly", "tsdownsample")
OF_SUBJECTS: Final = dict(chain(*(subject.extras.items() for subject in subjects())))
OF_PAGES: Final = chain(*(of.extras.get(of.name, ()) for of in subjects() if of.has_pages))
APP: Final = (*REPORT, *OF_PAGES, "streamlit")
PACKAGES: Final = {"report": REPORT, "app": APP, "login": (*APP, "authlib", "httpx"), **OF_SUBJECTS}
"""Import names of the packages of each extra of pyproject.toml."""


@contextmanager
def needs(extra: str, subject: str) -> Iterator[None]:
    """Turn failing imports inside this context into errors that name the extra to install.

    Parameters
    ----------
    extra
        Extra of pyproject.toml that provides the packages.
    subject
        Subject and verb of the message: ``figures need``.

    Raises
    ------
    MissingExtraError
        If a package of the extra is not installed, with the subject of the outermost `needs`. Other
        import errors are not changed.
    """
    try:
        yield
    except (ModuleNotFoundError, MissingExtraError) as error:
        if (error.name or "").partition(".")[0] not in PACKAGES[extra]:
            raise
        raise MissingExtraError(
            f"{subject} more packages: pip install 'nvcore[{extra}]'", name=error.name
        ) from error

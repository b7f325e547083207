"""The extras, which the light core does without: a plain error where one is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, Literal

from nvcore.errors import MissingExtraError

Extra = Literal["app", "detectors", "driver", "login", "onnx", "report"]

DETECTORS: Final = ("av", "cv2")
DRIVER: Final = ("av", "cv2", "sklearn")
REPORT: Final = ("av", "cv2", "jinja2", "plotly", "tsdownsample")
APP: Final = (*REPORT, *DRIVER, "streamlit")
PACKAGES: Final[dict[Extra, tuple[str, ...]]] = {
    "report": REPORT,
    "app": APP,
    "login": (*APP, "authlib", "httpx"),
    "detectors": DETECTORS,
    "driver": DRIVER,
    "onnx": (*DETECTORS, "google", "onnxruntime"),
}
"""Names by which the packages of each extra of pyproject.toml are imported."""


@contextmanager
def needs(extra: Extra, subject: str) -> Iterator[None]:
    """Within it, an import that fails for want of an extra says how to get it.

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

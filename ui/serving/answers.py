"""Answers of people whose study is over are deleted, also where nobody opens its page."""

from __future__ import annotations

import asyncio
import logging
from typing import Final

from nvcore.errors import InputError
from ui.subjects import contributed

EVERY_S: Final = 3600.0
"""A study that ends on a day is gone on that day."""
_LOG = logging.getLogger("nvcore.ui")


async def keep_deleting_ended() -> None:
    """Delete what is over, now and every hour, until cancelled."""
    while True:
        await asyncio.to_thread(delete_ended)
        await asyncio.sleep(EVERY_S)


def delete_ended() -> None:
    """Delete the studies that are over, with all answers."""
    for studies in contributed("STUDIES"):
        if not studies.file().is_file():
            continue
        try:
            studies.store()  # which deletes them
        except InputError as error:
            _LOG.warning("Answers that are over could not be deleted: %s", error)

"""What the server does when it starts and when it ends."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from nvcore.errors import NvcoreError
from ui.confined import process
from ui.session import ending, folders


@asynccontextmanager
async def lifespan(_app: Any) -> AsyncIterator[None]:
    """Ends sessions on the server's own loop; uploads go with the server, however it is stopped."""
    ending.close_sessions_on(asyncio.get_running_loop())
    threading.Thread(target=_prepare, name="prepare", daemon=True).start()
    try:
        yield
    finally:
        folders.remove_own()


def _prepare() -> None:
    with contextlib.suppress(NvcoreError, OSError):  # what fails now is said when it is needed
        process.warm_up()

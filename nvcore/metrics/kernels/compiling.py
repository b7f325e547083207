"""Compilation of the loops, and the location of their cached machine code.

numba caches it next to the source, in the user's cache folder, or in ``$NUMBA_CACHE_DIR``. If none
of these is writable (read-only packages and no home), we use a temporary folder that only this user
can change, because whoever can write the machine code decides what it does. Without such a folder,
each process compiles again, which takes some seconds.

The wheel of a release contains the machine code of the loops that a comparison needs
(`scripts/machine_code.py`). It is used on processors that can run it, with the version of numba
that made it, and for sources that have not changed since.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from llvmlite.binding import get_host_cpu_features
from numba import config, njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

from nvcore.common.output.private import make_private

SHIPPED: Final = Path(__file__).with_name("machine_code")
"""Folder of the machine code in the wheel of a release. A checkout has none."""

SHIPPED_CPU: Final = ("x86-64-v3", "")
"""Name and features of the processor that this code is made for, as LLVM calls them."""

SHIPPED_NEEDS: Final = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
"""Features of x86-64-v3 that a processor may lack."""


class KernelCache(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Cache of a loop's machine code that also finds the code in `SHIPPED`."""

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled loop for a signature, or None if it is in neither cache."""
        found = super()._load_overload(sig, target_context)
        if found is not None:
            return found
        _, (machine, *_), hashes = self._index_key(sig, target_context.codegen())
        stamp = self._impl.locator.get_source_stamp()
        shipped = IndexDataCacheFile(str(SHIPPED), self._impl.filename_base, stamp)
        data = shipped.load((sig, (machine, *SHIPPED_CPU), hashes))
        return None if data is None else self._impl.rebuild(target_context, data)


def compiler() -> Callable[[Callable[..., Any]], Any]:
    """Return the decorator for compiled loops, which finds a place for their machine code."""
    with_cache, without = (
        njit(cache=is_kept, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
        for is_kept in (True, False)
    )

    features = get_host_cpu_features() if SHIPPED.is_dir() else {}
    is_shipped = all(features.get(name) for name in SHIPPED_NEEDS)

    def cached(loop: Callable[..., Any]) -> Any:
        dispatcher = with_cache(loop)
        if is_shipped:
            dispatcher._cache = KernelCache(loop)
        return dispatcher

    def compiled(loop: Callable[..., Any]) -> Any:
        try:
            return cached(loop)
        except RuntimeError:  # "no locator available": nowhere to write
            folder = private_folder()
        if folder is None:
            return without(loop)
        config.CACHE_DIR = str(folder)
        return cached(loop)

    return compiled


def private_folder() -> Path | None:
    """Return a temporary folder that belongs to this user, or None if there cannot be one."""
    try:
        folder = Path(tempfile.gettempdir()) / f"nvcore-kernels-{os.getuid()}"
        is_usable = make_private(folder) and os.access(folder, os.W_OK)
    except (OSError, AttributeError):  # AttributeError: Windows, where the home always exists
        return None
    return folder if is_usable else None

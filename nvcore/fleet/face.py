"""The calls of Python users: `nvcore.ingest`, `nvcore.open_store`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

from nvcore.api.inputs import load
from nvcore.arguments import PathLike
from nvcore.dataset import Dataset
from nvcore.fleet.ingest import Ingested, ingest_all, session_files
from nvcore.fleet.location import Location
from nvcore.fleet.store import Store
from nvcore.inputs.session import Session


def ingest(
    *inputs: PathLike | Session | Dataset,
    store: PathLike | Store,
    partition: str | None = None,
    labels: Mapping[str, str] | None = None,
    truth_kind: str = "annotated",
) -> Ingested:
    """Append recordings to a store; what is there already is left out, what changed is a version.

    Parameters
    ----------
    inputs
        Session files, folders that are searched for session files, sessions, or datasets made by
        `load`. One that cannot be read is left out whole, see `Ingested.errors`.
    store
        A folder, ``s3://bucket/folder`` (with what the environment says of the server), or what
        `open_store` returns; a new one is made.
    partition
        How a new store is divided: by ``month``, ``unit``, or the key of a tag, such as ``route``
        where recordings have tags such as ``route=A9``.
    labels
        What to call these versions, by ``truth`` or the system's name: ``{"FIR": "2026-03"}``.
    truth_kind
        Whether the ground truth is ``"annotated"`` by people, ``"automatic"``, or ``"absent"``.

    Returns
    -------
    Ingested
        What was appended, and what could not be.

    Raises
    ------
    InputError
        If a folder holds no session file, or the store is divided in another way.
    StoreError
        If the store cannot be read or written; what was appended until then is in it.

    Examples
    --------
    >>> done = ingest("drives", store="fleet", labels={"FIR": "2026-03"})  # doctest: +SKIP
    >>> len(done.recordings), done.errors  # doctest: +SKIP
    (10, {})
    """
    if not isinstance(store, Store):
        store = Store(Location(store), partition=partition)
    return ingest_all(_named(inputs), store, truth_kind=truth_kind, labels=labels)


def _named(
    inputs: tuple[PathLike | Session | Dataset, ...],
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    for place, of in enumerate(inputs):
        if isinstance(of, Session | Dataset):
            yield f"input {place + 1}", partial(load, of)
        else:
            for path in session_files(Path(of)):
                yield str(path), partial(load, path)


def open_store(uri: PathLike, *, options: Mapping[str, str] | None = None) -> Store:
    """A store of recordings: `Store.snapshot` shows what it holds, `ingest` appends to it.

    Parameters
    ----------
    uri
        A folder, or ``s3://bucket/folder``.
    options
        Of the server, by keys such as ``aws_endpoint_url``; what is not given is taken from the
        environment (``AWS_ENDPOINT_URL``).

    Raises
    ------
    InputError
        If there can be no store at such a place. Whether there is one is asked for later.
    """
    return Store(Location(uri, options))

"""Weights that an ONNX model keeps in other files: found by the model's own messages.

ONNX Runtime refuses those outside the model's folder, too, when it loads them. They are looked for
here to say so in plain words, and for the fingerprint: the model is all of its files.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

from nvcore.detectors.base import DetectorError
from nvcore.extras import needs

with needs("onnx", "ONNX models need"):
    from google.protobuf import descriptor_pb2, descriptor_pool, message, message_factory

MAX_BYTES: Final = (1 << 31) - 1
"""Of a model file: protobuf has no larger messages."""

_MESSAGES: Final[dict[str, dict[int, tuple[str, str]]]] = {
    "Model": {7: ("graph", "Graph"), 20: ("training", "Training"), 25: ("functions", "Function")},
    "Training": {1: ("initialization", "Graph"), 2: ("algorithm", "Graph")},
    "Function": {7: ("node", "Node"), 11: ("attribute", "Attribute")},
    "Graph": {1: ("node", "Node"), 5: ("initializer", "Tensor"), 15: ("sparse", "Sparse")},
    "Node": {5: ("attribute", "Attribute")},
    "Attribute": {
        5: ("t", "Tensor"),
        6: ("g", "Graph"),
        10: ("tensors", "Tensor"),
        11: ("graphs", "Graph"),
        22: ("sparse", "Sparse"),
        23: ("sparses", "Sparse"),
    },
    "Sparse": {1: ("values", "Tensor"), 2: ("indices", "Tensor")},
    "Tensor": {13: ("external_data", "Entry")},
    "Entry": {1: ("key", ""), 2: ("value", "")},
}
"""The parts of onnx.proto in which a tensor can be: number, name and message of each field."""


def external_files(content: bytes, path: Path, name: str) -> list[Path]:
    """Files that hold weights of a model, each once, in the order of their names.

    Parameters
    ----------
    content
        Of the model file.
    path
        Where it lies.
    name
        What it is called in errors.

    Raises
    ------
    DetectorError
        If it is no ONNX model, or names a file outside its folder, links followed.
    """
    model = _model_class()()
    try:
        model.ParseFromString(content)
    except message.DecodeError as error:
        raise DetectorError("is damaged, or no ONNX model", file=name) from error
    folder = path.resolve().parent
    files = set()
    for location in sorted({*_locations(model)}):
        file = _resolved(folder, location)
        if file is None or Path(location).is_absolute() or not file.is_relative_to(folder):
            raise DetectorError(
                f"keeps weights in {location!r}, outside its own folder, and is refused; export it "
                "anew as one file",
                file=name,
            )
        if not file.is_file():
            raise DetectorError(f"keeps weights in {location!r}, which is not there", file=name)
        files.add(file)
    return sorted(files)


def _resolved(folder: Path, location: str) -> Path | None:
    try:
        return (folder / location).resolve()
    except (OSError, ValueError):  # links in a circle; NUL
        return None


def _locations(part: Any) -> Iterator[str]:
    """The places named by all tensors in a message, from the outside to the inside."""
    todo = [part]
    while todo:
        part = todo.pop()
        if part.DESCRIPTOR.name == "Entry":
            if part.key == b"location":
                yield part.value.decode(errors="replace")
            continue
        for _, value in part.ListFields():
            todo.extend(value)


@cache
def _model_class() -> Any:
    """The class of messages that `_MESSAGES` describes; all other fields are passed over."""
    kinds = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(
        name="nvcore/onnx.proto", package="nvcore.onnx", syntax="proto2"
    )
    for title, parts in _MESSAGES.items():
        entry = file.message_type.add(name=title)
        for number, (name, kind) in parts.items():
            entry.field.add(
                name=name,
                number=number,
                # a field that stands once may come twice: both count
                label=kinds.LABEL_REPEATED if kind else kinds.LABEL_OPTIONAL,
                type=kinds.TYPE_MESSAGE if kind else kinds.TYPE_BYTES,
                type_name=f".nvcore.onnx.{kind}" if kind else None,
            )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("nvcore.onnx.Model"))

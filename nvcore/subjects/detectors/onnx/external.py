"""External weight files of an ONNX model, found by parsing its protobuf messages.

ONNX Runtime also rejects files outside the model's folder when it loads them. This module finds the
files first for a plain error message, and for the fingerprint over all files of the model.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Final

from nvcore.common.extras import needs
from nvcore.subjects.detectors.base import DetectorError

with needs("onnx", "ONNX models need"):
    from google.protobuf import descriptor_pb2, descriptor_pool, message, message_factory

MAX_BYTES: Final = (1 << 31) - 1
"""Maximum size of a model file. Protobuf has no larger messages."""

_MESSAGES: Final[dict[str, dict[int, str]]] = {
    "Model": {7: "Graph", 20: "Training", 25: "Function"},
    "Training": {1: "Graph", 2: "Graph"},
    "Function": {7: "Node", 11: "Attribute"},
    "Graph": {1: "Node", 5: "Tensor", 15: "Sparse"},
    "Node": {5: "Attribute"},
    "Attribute": {5: "Tensor", 6: "Graph", 10: "Tensor", 11: "Graph", 22: "Sparse", 23: "Sparse"},
    "Sparse": {1: "Tensor", 2: "Tensor"},
    "Tensor": {13: "Entry"},
    "Entry": {1: "key", 2: "value"},
}
"""Parts of onnx.proto that can hold a tensor: message of each field, or its name if bytes."""


def external_files(content: bytes, path: Path, name: str) -> list[Path]:
    """Return the files that hold weights of a model, sorted by name and without duplicates.

    Parameters
    ----------
    content
        Content of the model file.
    path
        Path of the model file.
    name
        Name of the model for error messages.

    Raises
    ------
    DetectorError
        If the content is not an ONNX model, or a weight file is outside its folder (links
        resolved).
    """
    model = _model_class()()
    try:
        model.ParseFromString(content)
    except message.DecodeError as error:
        raise DetectorError("is damaged, or no ONNX model", file=name) from error
    folder = path.resolve().parent
    files = set()
    for location in sorted({*_locations(model)}):
        try:
            file = (folder / location).resolve()
        except (OSError, ValueError):  # circular links, or NUL in the name
            file = Path()  # relative, so in no folder
        if Path(location).is_absolute() or not file.is_relative_to(folder):
            raise DetectorError(
                f"keeps weights in {location!r}, outside its own folder, and is refused; export it "
                "anew as one file",
                file=name,
            )
        if not file.is_file():
            raise DetectorError(f"keeps weights in {location!r}, which is not there", file=name)
        files.add(file)
    return sorted(files)


def _locations(part: Any) -> Iterator[str]:
    """Yield the locations named by all tensors in a message, outer messages first."""
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
    """Return the protobuf class described by `_MESSAGES`, which ignores all other fields."""
    kinds = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(
        name="nvcore/onnx.proto", package="nvcore.onnx", syntax="proto2"
    )
    for title, parts in _MESSAGES.items():
        entry = file.message_type.add(name=title)
        for number, kind in parts.items():
            is_message = kind in _MESSAGES
            entry.field.add(
                name=f"part{number}" if is_message else kind,
                number=number,
                # protobuf allows a singular field to occur twice, and both values count
                label=kinds.LABEL_REPEATED if is_message else kinds.LABEL_OPTIONAL,
                type=kinds.TYPE_MESSAGE if is_message else kinds.TYPE_BYTES,
                type_name=f".nvcore.onnx.{kind}" if is_message else None,
            )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("nvcore.onnx.Model"))

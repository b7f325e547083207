"""Small networks in ONNX, made for tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from onnx import TensorProto, helper, numpy_helper

CELL = 8
"""Side of the cells of `blob_model`, px."""


def save(
    path: Path,
    nodes: Sequence[Any],
    outputs: Mapping[str, int],
    *,
    shape: Sequence[int | str] = (1, 3, 64, 64),
    kind: int = TensorProto.FLOAT,
    names: str = "",
    weights: Sequence[Any] = (),
) -> Path:
    """A model of these nodes; outputs by name with their type."""
    graph = helper.make_graph(
        list(nodes),
        "test",
        [helper.make_tensor_value_info("images", kind, list(shape))],
        [helper.make_tensor_value_info(name, of, None) for name, of in outputs.items()],
        list(weights),
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    if names:
        helper.set_model_props(model, {"names": names})
    path.write_bytes(model.SerializeToString())
    return path


def constant(name: str, array: np.ndarray) -> Any:
    return helper.make_node("Constant", [], [name], value=numpy_helper.from_array(array))


def fixed_model(path: Path, outputs: Mapping[str, np.ndarray], **options: Any) -> Path:
    """A network that always answers the same."""
    arrays = {
        name: array.astype(np.float32) if array.dtype == np.float64 else array
        for name, array in outputs.items()
    }
    nodes = [constant(name, array) for name, array in arrays.items()]
    kinds = {name: helper.np_dtype_to_tensor_dtype(array.dtype) for name, array in arrays.items()}
    return save(path, nodes, kinds, **options)


def blob_model(path: Path, width: int = 64, height: int = 64, **options: Any) -> Path:
    """A network of YOLOv8's layout: the score of each cell is its mean brightness, 0..1."""
    across, down = np.meshgrid(np.arange(width // CELL), np.arange(height // CELL))
    n = across.size
    boxes = np.empty((1, 4, n), np.float32)
    boxes[0, 0], boxes[0, 1] = CELL * (across.ravel() + 0.5), CELL * (down.ravel() + 0.5)
    boxes[0, 2:] = CELL
    nodes = [
        helper.make_node("ReduceMean", ["images"], ["grey"], axes=[1], keepdims=1),
        helper.make_node(
            "AveragePool", ["grey"], ["cells"], kernel_shape=[CELL, CELL], strides=[CELL, CELL]
        ),
        constant("form", np.array([1, 1, n], np.int64)),
        helper.make_node("Reshape", ["cells", "form"], ["scores"]),
        constant("boxes", boxes),
        helper.make_node("Concat", ["boxes", "scores"], ["output0"], axis=1),
    ]
    shape = (1, 3, height, width)
    return save(path, nodes, {"output0": TensorProto.FLOAT}, shape=shape, **options)


def external_model(path: Path, location: str, *, in_node: bool = False) -> Path:
    """A network whose weights lie in another file."""
    tensor = TensorProto()
    tensor.name, tensor.data_type = "w", TensorProto.FLOAT
    tensor.dims.extend([1, 300, 6])
    tensor.data_location = TensorProto.EXTERNAL
    for key, value in (("location", location), ("offset", "0"), ("length", str(4 * 1800))):
        entry = tensor.external_data.add()
        entry.key, entry.value = key, value
    if in_node:
        nodes = [helper.make_node("Constant", [], ["output0"], value=tensor)]
        weights: list[Any] = []
    else:
        nodes, weights = [helper.make_node("Identity", ["w"], ["output0"])], [tensor]
    graph = helper.make_graph(
        nodes,
        "test",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, 64, 64])],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, None)],
        weights,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path.write_bytes(model.SerializeToString())
    return path

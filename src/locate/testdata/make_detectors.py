#!/usr/bin/env python3
"""Writes yolov8.onnx and yolox.onnx beside this script: detectors of 64 x 64 pixels and two classes whose
only box tells what they were shown.

yolov8: at the first place a person of middle (64 r, 64 g), width 64 b and height 32, sure to 0.9, with r, g
and b the means of the input's three channels.
yolox: at the first place of the second grid (16 pixels) a person of middle (b, g) of a cell, width of
exp(r) cells and height of one, sure to 0.8 times 0.75, with b, g and r the means over 255.
"""
import os

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper, save

SIZE, PLACES = 64, 64 + 16 + 4


def write(name, nodes, constants, shape):
    tensors = [numpy_helper.from_array(v, k) for k, v in constants.items()]
    value = lambda n, s: helper.make_tensor_value_info(n, TensorProto.FLOAT, s)
    graph = helper.make_graph(nodes, name, [value("images", [1, 3, SIZE, SIZE])], [value("output0", shape)],
                              tensors)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 11)], ir_version=6)
    checker.check_model(model)
    save(model, os.path.join(os.path.dirname(os.path.abspath(__file__)), name + ".onnx"))


def nodes(axis):
    """A convolution puts each mean where it is told, as OpenCV 4.6 multiplies few shapes."""
    node = helper.make_node
    return [
        node("GlobalAveragePool", ["images"], ["means"]),
        node("Conv", ["means", "weight"], ["spread"], kernel_shape=[1, 1]),
        node("Reshape", ["spread", "shape"], ["told"]),
        node("Concat", ["told", "rest"], ["output0"], axis=axis),
    ]


def yolov8():
    weight = np.zeros((3, PLACES, 3, 1, 1), np.float32)
    for channel in range(3):
        weight[channel, 0, channel] = 64
    rest = np.zeros((1, 3, PLACES), np.float32)
    rest[0, :, 0] = [32, 0.9, 0.1]
    constants = {"weight": weight.reshape(-1, 3, 1, 1), "shape": np.array([1, 3, PLACES], np.int64),
                 "rest": rest}
    write("yolov8", nodes(axis=1), constants, [1, 6, PLACES])


def yolox():
    weight = np.zeros((PLACES, 3, 3, 1, 1), np.float32)
    for channel in range(3):
        weight[64, channel, channel] = 1 / 255
    rest = np.zeros((1, PLACES, 4), np.float32)
    rest[0, 64] = [0, 0.8, 0.75, 0.1]
    constants = {"weight": weight.reshape(-1, 3, 1, 1), "shape": np.array([1, PLACES, 3], np.int64),
                 "rest": rest}
    write("yolox", nodes(axis=2), constants, [1, PLACES, 7])


yolov8()
yolox()

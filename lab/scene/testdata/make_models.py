#!/usr/bin/env python3
"""Writes the small models that the importer is tested with: an L-shaped room, three ways.

The room in our frame (x front, y left, z up): the floor is the polygon CORNERS, 18 m2, the walls
are 2.5 m high; all faces together have 86 m2 and enclose 45 m3.

  room.obj   y up, one polygon per face (the floor and ceiling have six corners and are not convex),
             surfaces named in room.mtl, one texture (tiles.png)
  room.glb   y up, centimetres under a node that scales by 0.01 and turns by 90 degrees, the ceiling
             under a node of its own that mirrors, the texture inside
  room.ply   z up, binary, quads, one colour per vertex

Run it in this folder; it needs nothing but Python.
"""

import json
import struct
import zlib

CORNERS = [(0, 0), (6, 0), (6, 2), (3, 2), (3, 4), (0, 4)]
HEIGHT = 2.5


def png(width, height, pixel):
    """An RGB picture, pixel(x, y) with y from the top."""
    rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(width)) for y in range(height))
    chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data
                                + struct.pack(">I", zlib.crc32(kind + data)))
    return (b"\x89PNG\r\n\x1a\n"
            + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def tiles(x, y):
    return (200, 0, 0) if y < 4 else (0, 0, 200)  # red above, blue below


def y_up(point):
    x, y, z = point
    return (y, z, x)


def wall(i):
    (ax, ay), (bx, by) = CORNERS[i], CORNERS[(i + 1) % len(CORNERS)]
    return [(bx, by, 0), (ax, ay, 0), (ax, ay, HEIGHT), (bx, by, HEIGHT)]  # looks inward


def write_obj():
    lines = ["mtllib room.mtl", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    count = 0

    def face(points, uvs=None):
        nonlocal count
        for p in points:
            lines.append("v %g %g %g" % y_up(p))
        refs = [str(count + i + 1) + ("/%d" % (i + 1) if uvs else "") for i in range(len(points))]
        lines.append("f " + " ".join(refs))
        count += len(points)

    lines += ["o floor", "usemtl Carpet_Grey"]
    face([(x, y, 0) for x, y in CORNERS])
    lines += ["o lid", "usemtl white.001"]  # the material says nothing; the object does not either
    face([(x, y, HEIGHT) for x, y in reversed(CORNERS)])
    lines += ["o Wall_1", "usemtl Tiles"]
    face(wall(0), uvs=True)
    lines += ["o Wall_2", "usemtl white.001"]  # the object's name tells what it is
    for i in range(1, 6):
        face(wall(i))
    open("room.obj", "w").write("\n".join(lines) + "\n")
    open("room.mtl", "w").write(
        "newmtl Carpet_Grey\nKd 0.5 0.5 0.5\n\nnewmtl white.001\nKd 1 1 1\n\n"
        "newmtl Tiles\nKd 1 1 1\nmap_Kd tiles.png\n")
    open("tiles.png", "wb").write(png(8, 8, tiles))


def triangles_of(points):
    """Cuts a floor of this room, or any convex polygon."""
    if len(points) < 6:
        return [(0, i, i + 1) for i in range(1, len(points) - 1)]
    return [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]


def write_glb():
    binary = b""
    views, accessors, meshes = [], [], []

    def view(data):
        nonlocal binary
        binary += b"\0" * (-len(binary) % 4)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
        return len(views) - 1

    def accessor(data, component, kind, count, **more):
        accessors.append({"bufferView": view(data), "componentType": component, "type": kind,
                          "count": count, **more})
        return len(accessors) - 1

    def mesh(name, faces, material, uvs=False):
        points, indices = [], []
        for face in faces:
            indices += [len(points) + i for t in triangles_of(face) for i in t]
            points += face
        flat = [c for p in points for c in p]
        attributes = {"POSITION": accessor(
            struct.pack("<%df" % len(flat), *flat), 5126, "VEC3", len(points),
            min=[min(p[k] for p in points) for k in range(3)],
            max=[max(p[k] for p in points) for k in range(3)])}
        if uvs:
            corners = [0, 1, 1, 1, 1, 0, 0, 0]  # v from the top
            attributes["TEXCOORD_0"] = accessor(struct.pack("<8f", *corners), 5126, "VEC2", 4)
        meshes.append({"name": name, "primitives": [{
            "attributes": attributes, "material": material,
            "indices": accessor(struct.pack("<%dH" % len(indices), *indices), 5123, "SCALAR",
                                len(indices))}]})
        return len(meshes) - 1

    # In the file: centimetres, turned by -90 degrees about the up axis, undone by the node.
    def stored(point):
        x, y, z = y_up(point)
        return (-100 * z, 100 * y, 100 * x)

    floor = mesh("floor", [[stored((x, y, 0)) for x, y in CORNERS]], 0)
    tiled = mesh("tiled", [[stored(p) for p in wall(0)]], 1, uvs=True)
    walls = mesh("walls", [[stored(p) for p in wall(i)] for i in range(1, 6)], 2)
    # Mirrored in x, so that the node's scale of -1 brings it back; the corners run the other way.
    mirrored = [y_up((x, y, HEIGHT)) for x, y in CORNERS]
    ceiling = mesh("ceiling", [[(-x, y, z) for x, y, z in mirrored]], 3)
    half = 0.5 ** 0.5
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 4]}],
        "nodes": [{"name": "turned", "rotation": [0, half, 0, half], "scale": [0.01, 0.01, 0.01],
                   "children": [1, 2, 3]},
                  {"name": "floor", "mesh": floor}, {"name": "tiled", "mesh": tiled},
                  {"name": "walls", "mesh": walls},
                  {"name": "ceiling", "mesh": ceiling, "scale": [-1, 1, 1]}],
        "meshes": meshes, "accessors": accessors,
        "materials": [
            {"name": "parquet", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1]}},
            {"name": "bath tiles", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
            {"name": "brick wall"}, {"name": "acoustic ceiling"}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": view(png(8, 8, tiles)), "mimeType": "image/png"}],
        "bufferViews": views}
    binary += b"\0" * (-len(binary) % 4)
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    open("room.glb", "wb").write(
        struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary))
        + struct.pack("<II", len(text), 0x4E4F534A) + text
        + struct.pack("<II", len(binary), 0x004E4942) + binary)


def write_ply():
    quads = [wall(i) for i in range(6)]
    floor = [[(0, 0, 0), (6, 0, 0), (6, 2, 0), (0, 2, 0)], [(0, 2, 0), (3, 2, 0), (3, 4, 0), (0, 4, 0)]]
    quads += floor + [[(x, y, HEIGHT) for x, y, _ in reversed(face)] for face in floor]
    vertices, faces = b"", b""
    for i, quad in enumerate(quads):
        colour = (200, 200, 200) if i < 6 else (120, 60, 30) if i < 8 else (250, 250, 250)
        for x, y, z in quad:
            vertices += struct.pack("<fffBBB", x, y, z, *colour)
        faces += struct.pack("<Biiii", 4, *range(4 * i, 4 * i + 4))
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n"
              "property float x\nproperty float y\nproperty float z\n"
              "property uchar red\nproperty uchar green\nproperty uchar blue\n"
              "element face %d\nproperty list uchar int vertex_indices\nend_header\n"
              % (4 * len(quads), len(quads)))
    open("room.ply", "wb").write(header.encode() + vertices + faces)


write_obj()
write_glb()
write_ply()

#!/usr/bin/env python3
"""Compares earpoint trace with pyroomacoustics in rooms with a known answer.

usage: experiments/peers/compare_tracers.py EARPOINT [--triangles N,N,...] >tracers.json

A room of 6 x 5 x 3 m whose walls absorb 20 % and scatter half, as a box and as meshes of the same walls with
more and more triangles. The reference is independent of both: particles that bounce between the walls,
counted in a sphere at the microphone. Both programs run alternately on one core. Needs pyroomacoustics 0.10
or later (pip install pyroomacoustics), numpy and scipy for the python3 that runs it.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings

SIZE = (6.0, 5.0, 3.0)
SOURCE = (1.0, 2.0, 1.5)
MICROPHONE = (4.0, 3.0, 1.2)
ABSORPTION, SCATTERING = 0.2, 0.5
RATE_HZ = 16000
SOUND_SPEED = 343.2
DURATION_S = 1.0
BAND_HZ = (707.0, 1414.0)  # the octave of 1 kHz, where air absorbs little

try:
    import numpy as np
    import pyroomacoustics as pra
    from scipy.io import wavfile
    from scipy.signal import butter, sosfiltfilt
except ImportError as error:
    sys.exit(f"compare_tracers: {error}; pip install 'pyroomacoustics>=0.10' scipy")


def particles_in_room(count=400000, seed=1):
    """Reverberation time and level of everything but the direct sound, re the direct sound."""
    random = np.random.default_rng(seed)
    size = np.array(SIZE)
    middle, radius = np.array(MICROPHONE), 0.25
    position = np.tile(np.array(SOURCE), (count, 1))
    direction = random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    energy, elapsed = np.ones(count), np.zeros(count)
    bins = np.zeros(int(3 * DURATION_S * 1000))  # by milliseconds
    for bounce in range(160):
        with np.errstate(divide="ignore", invalid="ignore"):
            ways = np.where(direction > 0, (size - position) / direction, -position / direction)
        ways[direction == 0] = np.inf
        axis = np.argmin(ways, axis=1)
        way = ways[np.arange(count), axis]
        # The chord of this leg through the sphere.
        towards = middle - position
        along = np.einsum("ij,ij->i", towards, direction)
        apart = np.einsum("ij,ij->i", towards, towards) - along**2
        half = np.sqrt(np.maximum(radius**2 - apart, 0.0))
        chord = np.maximum(np.minimum(along + half, way) - np.maximum(along - half, 0.0), 0.0)
        heard = chord > 0
        if bounce > 0:
            index = ((elapsed + along)[heard] / SOUND_SPEED * 1000).astype(int)
            np.add.at(bins, np.minimum(index, len(bins) - 1), (energy * chord)[heard])
        position += direction * way[:, None]
        elapsed += way
        energy *= 1.0 - ABSORPTION
        # A share of the particles is scattered by Lambert's law, the others are reflected.
        rows = np.arange(count)
        outward = np.sign(direction[rows, axis])
        direction[rows, axis] *= -1.0
        anew = random.random(count) < SCATTERING
        cosine = np.sqrt(random.random(count))
        turn = 2 * np.pi * random.random(count)
        lambert = np.zeros((count, 3))
        lambert[rows, axis] = -outward * cosine
        sine = np.sqrt(1.0 - cosine**2)
        lambert[rows, (axis + 1) % 3] = sine * np.cos(turn)
        lambert[rows, (axis + 2) % 3] = sine * np.sin(turn)
        direction[anew] = lambert[anew]
    volume = 4.0 / 3.0 * np.pi * radius**3
    distance = np.linalg.norm(middle - np.array(SOURCE))
    level_db = 10 * np.log10(bins.sum() / count / volume * 4 * np.pi * distance**2)
    return reverberation_time_s(bins, 1000), level_db


def reverberation_time_s(energy, rate_hz):
    """T30 by Schroeder's backward integration."""
    decay = np.cumsum(energy[::-1])[::-1]
    decay_db = 10 * np.log10(decay / decay[0] + 1e-30)
    first, last = np.argmax(decay_db <= -5), np.argmax(decay_db <= -35)
    slope = np.polyfit(np.arange(first, last) / rate_hz, decay_db[first:last], 1)[0]
    return -60.0 / slope


def measured(response, seconds):
    """T30 and level of all but the direct sound, in the band; the direct sound stands apart by 2 ms."""
    band = sosfiltfilt(butter(4, BAND_HZ, "bandpass", fs=RATE_HZ, output="sos"), response)
    first = int(np.argmax(np.abs(response) > 0.5 * np.max(np.abs(response))))
    direct = np.zeros(len(response) + RATE_HZ)
    reach = RATE_HZ // 1000
    part = response[max(first - reach, 0) : first + reach]
    direct[RATE_HZ // 2 : RATE_HZ // 2 + len(part)] = part
    direct = sosfiltfilt(butter(4, BAND_HZ, "bandpass", fs=RATE_HZ, output="sos"), direct)
    rest = np.array(response, dtype=float)
    rest[: first + reach] = 0.0
    rest = sosfiltfilt(butter(4, BAND_HZ, "bandpass", fs=RATE_HZ, output="sos"), rest)
    return {"t30_s": reverberation_time_s(band[first:] ** 2, RATE_HZ),
            "level_db": float(10 * np.log10(np.sum(rest**2) / np.sum(direct**2))),
            "processor_s": seconds}


def walls(pieces):
    """Triangles of the box, every wall cut into pieces x pieces squares: corners [triangles][3][3]."""
    triangles = []
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            for i in range(pieces):
                for j in range(pieces):
                    corner = np.zeros((4, 3))
                    corner[:, axis] = side * SIZE[axis]
                    corner[:, first] = np.array([i, i + 1, i + 1, i]) * SIZE[first] / pieces
                    corner[:, second] = np.array([j, j, j + 1, j + 1]) * SIZE[second] / pieces
                    if side == 0:
                        corner = corner[::-1]
                    triangles += [corner[[0, 1, 2]], corner[[0, 2, 3]]]
    return np.array(triangles)


def write_mesh(folder, triangles):
    path = os.path.join(folder, f"room-{len(triangles)}.obj")
    with open(path, "w") as file:
        for corner in triangles.reshape(-1, 3):
            file.write("v {} {} {}\n".format(*corner))
        file.write("usemtl wall\n")
        for i in range(len(triangles)):
            file.write(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n")
    with open(path + ".json", "w") as file:
        wall = {"absorption": [ABSORPTION] * 8, "scattering": [SCATTERING] * 8,
                "absorption_source": "the comparison", "scattering_source": "the comparison"}
        json.dump({"format": "earpoint-materials-1", "materials": {"wall": wall},
                   "patterns": [{"material": "wall", "words": ["wall"]}], "default": "wall"}, file)
    return path


def traced(earpoint, scene, folder, seed):
    output = os.path.join(folder, "response.wav")
    point = lambda p: ",".join(map(str, p))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([earpoint, "trace", *scene, "--source", point(SOURCE), "--listener", point(MICROPHONE),
                    "--mono", "--duration", str(DURATION_S), "--rate", str(RATE_HZ), "--jobs", "1",
                    "--seed", str(seed), "-o", output], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # chunks of the file that scipy does not know
        response = wavfile.read(output)[1]
    return measured(response,
                    after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def peer(triangles, rays, seed):
    """pyroomacoustics: image sources of order 3 where the room is a box, rays for the rest."""
    np.random.seed(seed)
    material = pra.Material(ABSORPTION, SCATTERING)
    start = time.process_time()
    if triangles is None:
        room = pra.ShoeBox(SIZE, fs=RATE_HZ, materials=material, max_order=3, ray_tracing=True,
                           air_absorption=True)
    else:
        faces = [pra.wall_factory(t.T, material.energy_absorption["coeffs"],
                                  material.scattering["coeffs"]) for t in triangles]
        room = pra.Room(faces, fs=RATE_HZ, max_order=0, ray_tracing=True, air_absorption=True)
    room.set_ray_tracing(n_rays=rays, receiver_radius=0.25)
    room.add_source(SOURCE)
    room.add_microphone(MICROPHONE)
    room.compute_rir()
    return measured(np.array(room.rir[0][0]), time.process_time() - start)


def summary(runs, reference):
    t30_s, level_db = reference
    return {"t30_error_percent": float(np.mean([100 * (r["t30_s"] / t30_s - 1) for r in runs])),
            "t30_spread_percent": float(np.std([100 * r["t30_s"] / t30_s for r in runs], ddof=1)),
            "level_error_db": float(np.mean([r["level_db"] - level_db for r in runs])),
            "processor_s": float(np.median([r["processor_s"] for r in runs]))}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("earpoint")
    parser.add_argument("--triangles", default="1000,10000,50000")
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    pra.constants.set("num_threads", 1)
    version = subprocess.run([arguments.earpoint, "--version"], capture_output=True, text=True).stdout
    reference = particles_in_room()
    print(f"reference: T30 {reference[0]:.4f} s, level {reference[1]:.2f} dB", file=sys.stderr)
    box = "{},{},{},absorption={},scattering={}".format(*SIZE, ABSORPTION, SCATTERING)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        cases = [(None, ["--shoebox", box], 10000)]
        for count in map(int, arguments.triangles.split(",")):
            mesh = walls(max(1, round((count / 12) ** 0.5)))
            path = write_mesh(folder, mesh)
            # Without a tree over the walls the cost of a ray grows with the number of triangles.
            cases.append((mesh, [path, "--materials", path + ".json", "--up", "z"],
                          max(100, int(1e7 / count))))
        for mesh, scene, rays in cases:
            ours, theirs = [], []
            for seed in range(1, arguments.runs + 1):
                ours.append(traced(arguments.earpoint, scene, folder, seed))
                theirs.append(peer(mesh, min(rays, 10000), seed))
            rows.append({"triangles": 12 if mesh is None else len(mesh), "box": mesh is None,
                         "earpoint": {**summary(ours, reference), "rays": 5000},
                         "peer": {**summary(theirs, reference), "rays": min(rays, 10000)}})
            print(json.dumps(rows[-1]), file=sys.stderr)
    json.dump({"earpoint": version.strip(), "pyroomacoustics": pra.__version__, "runs": arguments.runs,
               "t30_s": reference[0], "level_db": reference[1], "rows": rows}, sys.stdout, indent=1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes the head-related impulse responses of FABIAN, another dummy head than KEMAR, as a SOFA file.

usage: experiments/publish/fabian_sofa.py hrirs_fabian_min_phase_eq.wav FABIAN.sofa

The WAV file of Debian's soundscaperenderer-common holds 360 azimuths in the horizontal plane: channels 2 a and
2 a + 1 are the left and right ear of azimuth a, counted to the left. Other elevations take the azimuth with the
same angle to the interaural axis, in front or behind: interaural delays and levels are right there, but the
spectral cues of elevation are missing. Needs python3-netcdf4 and python3-numpy.
"""
import sys
import wave

import netCDF4
import numpy

DISTANCE_M = 2.5  # any beyond the head's near field will do: Earpoint uses only the direction
EAR_M = 0.08
STEP_DEG = 5
ELEVATIONS_DEG = range(-80, 81, 10)


def read_hrirs(path):
    """@return rate in Hz, [360 azimuths][2 ears][taps]"""
    with wave.open(path, "rb") as file:
        channels, width = file.getnchannels(), file.getsampwidth()
        if channels != 720 or width != 3:
            sys.exit(f"{path}: expected 720 channels of 24 bits, found {channels} of {8 * width}")
        rate = file.getframerate()
        raw = numpy.frombuffer(file.readframes(file.getnframes()), numpy.uint8)
    raw = raw.reshape(-1, channels, 3).astype(numpy.int32)
    values = raw[..., 0] | raw[..., 1] << 8 | raw[..., 2] << 16
    values = numpy.where(values >= 1 << 23, values - (1 << 24), values) / (1 << 23)
    return rate, values.T.reshape(360, 2, -1)


def horizontal_azimuth_deg(azimuth_deg, elevation_deg):
    """The azimuth in the horizontal plane with the same angle to the interaural axis."""
    azimuth, elevation = numpy.radians(azimuth_deg), numpy.radians(elevation_deg)
    lateral = numpy.degrees(numpy.arcsin(numpy.sin(azimuth) * numpy.cos(elevation)))
    return round(lateral if numpy.cos(azimuth) >= 0 else 180 - lateral) % 360


def directions():
    yield from ((azimuth, elevation) for elevation in ELEVATIONS_DEG
                for azimuth in range(0, 360, STEP_DEG))
    yield from ((0, -90), (0, 90))


def main():
    rate, hrirs = read_hrirs(sys.argv[1])
    places = list(directions())
    with netCDF4.Dataset(sys.argv[2], "w") as sofa:
        for name, value in (("Conventions", "SOFA"), ("Version", "1.0"), ("DataType", "FIR"),
                            ("SOFAConventions", "SimpleFreeFieldHRIR"),
                            ("SOFAConventionsVersion", "1.0"), ("APIName", "netCDF4"),
                            ("RoomType", "free field"), ("DatabaseName", "FABIAN"),
                            ("ListenerShortName", "FABIAN"), ("Title", "HRIR of FABIAN"),
                            ("License", "GPL-3+")):
            setattr(sofa, name, value)
        for name, size in (("I", 1), ("C", 3), ("R", 2), ("E", 1), ("M", len(places)),
                           ("N", hrirs.shape[2])):
            sofa.createDimension(name, size)

        def add(name, shape, values, **attributes):
            variable = sofa.createVariable(name, "f8", shape)
            variable[:] = numpy.asarray(values, float)
            for key, value in attributes.items():
                setattr(variable, key, value)

        metres = {"Type": "cartesian", "Units": "metre"}
        add("ListenerPosition", ("I", "C"), [[0, 0, 0]], **metres)
        add("ListenerView", ("I", "C"), [[1, 0, 0]], **metres)
        add("ListenerUp", ("I", "C"), [[0, 0, 1]])
        add("ReceiverPosition", ("R", "C", "I"), [[[0], [EAR_M], [0]], [[0], [-EAR_M], [0]]], **metres)
        add("EmitterPosition", ("E", "C", "I"), [[[0], [0], [0]]], **metres)
        add("SourcePosition", ("M", "C"), [[a, e, DISTANCE_M] for a, e in places], Type="spherical",
            Units="degree, degree, metre")
        add("Data.SamplingRate", ("I",), [rate], Units="hertz")
        add("Data.Delay", ("I", "R"), [[0, 0]])
        add("Data.IR", ("M", "R", "N"), [hrirs[horizontal_azimuth_deg(a, e)] for a, e in places])


if __name__ == "__main__":
    main()

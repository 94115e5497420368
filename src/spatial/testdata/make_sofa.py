#!/usr/bin/env python3
"""Makes the small SOFA files of the tests: a rigid-sphere head seen by two impulses.

Each measurement is one delayed impulse per ear: delay and level follow from the angle between the
source and the ear. So a test knows every number. Needs python3-netcdf4. Run in this folder.
"""
import math

import netCDF4
import numpy as np

RATE_HZ = 48000
TAPS = 64
AZIMUTHS_DEG = range(0, 360, 45)


def ear_response(azimuth_deg, ear_azimuth_deg):
    """(delay in samples, level) at an ear for a source on the horizon."""
    angle = math.acos(math.cos(math.radians(azimuth_deg - ear_azimuth_deg)))
    lag_s = 0.0875 / 343.2 * (-math.cos(angle) if angle < math.pi / 2 else angle - math.pi / 2)
    return round(24 + lag_s * RATE_HZ), 0.75 + 0.25 * math.cos(angle)


def write(name, *, cartesian=False, swapped=False, delays=False, turned=False, wrong_ears=False,
          convention="SimpleFreeFieldHRIR", nan=False, rate_hz=RATE_HZ):
    with netCDF4.Dataset(name, "w", format="NETCDF4") as f:
        for size, count in [("M", len(AZIMUTHS_DEG)), ("R", 2), ("E", 1), ("N", TAPS), ("C", 3),
                            ("I", 1), ("S", 1)]:
            f.createDimension(size, count)
        for key, value in {
            "Conventions": "SOFA", "Version": "1.0", "SOFAConventions": convention,
            "SOFAConventionsVersion": "1.0", "DataType": "FIR", "RoomType": "free field",
            "Title": "two impulses around a sphere", "License": "Apache-2.0",
            "DatabaseName": "earpoint tests", "ListenerShortName": "sphere",
            "AuthorContact": "", "Organization": "", "DateCreated": "2026-01-01 00:00:00",
            "DateModified": "2026-01-01 00:00:00", "APIName": "", "APIVersion": "",
        }.items():
            f.setncattr(key, value)

        def variable(key, dimensions, values, **attributes):
            v = f.createVariable(key, "f8", dimensions)
            v[:] = np.asarray(values, dtype=float).reshape([len(f.dimensions[d]) for d in dimensions])
            for attribute, value in attributes.items():
                v.setncattr(attribute, value)

        # Turned: the listener stands elsewhere and looks to the world's left.
        turn_deg = 90.0 if turned else 0.0
        place = np.array([1.0, 2.0, 0.5]) if turned else np.zeros(3)
        spherical = {"Type": "spherical", "Units": "degree, degree, metre"}
        plain = {"Type": "cartesian", "Units": "metre"}
        positions, responses, lags = [], [], []
        for azimuth_deg in AZIMUTHS_DEG:
            world_deg = azimuth_deg + turn_deg
            if cartesian or turned:
                offset = 1.5 * np.array([math.cos(math.radians(world_deg)),
                                         math.sin(math.radians(world_deg)), 0.0])
                positions.append(place + offset)
            else:
                positions.append([world_deg, 0.0, 1.5])
            ears = [ear_response(azimuth_deg, 90), ear_response(azimuth_deg, -90)]
            if swapped != wrong_ears:
                ears.reverse()
            lags.append([delay for delay, _ in ears])
            for delay, level in ears:
                response = np.zeros(TAPS)
                response[0 if delays else delay] = level
                responses.append(response)
        if nan:
            responses[3][5] = math.nan
        left_y = -0.0875 if swapped else 0.0875
        variable("ListenerPosition", ("I", "C"), place, **plain)
        variable("ReceiverPosition", ("R", "C", "I"), [0, left_y, 0, 0, -left_y, 0], **plain)
        variable("SourcePosition", ("M", "C"), positions,
                 **(plain if cartesian or turned else spherical))
        variable("EmitterPosition", ("E", "C", "I"), [0, 0, 0], **plain)
        variable("ListenerUp", ("I", "C"), [0, 0, 1], **plain)
        variable("ListenerView", ("I", "C"), [0, 1, 0] if turned else [1, 0, 0], **plain)
        variable("Data.IR", ("M", "R", "N"), responses)
        variable("Data.SamplingRate", ("I",), [rate_hz], Units="hertz")
        if delays:
            variable("Data.Delay", ("M", "R"), lags)
        else:
            variable("Data.Delay", ("I", "R"), [0, 0])


if __name__ == "__main__":
    write("sphere.sofa")
    write("sphere_cartesian_swapped_delays.sofa", cartesian=True, swapped=True, delays=True)
    write("sphere_turned.sofa", turned=True)
    write("wrong_ears.sofa", wrong_ears=True)
    write("wrong_convention.sofa", convention="GeneralFIR")
    write("wrong_value.sofa", nan=True)
    write("wrong_rate.sofa", rate_hz=0.5)

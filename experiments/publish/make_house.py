#!/usr/bin/env python3
"""Writes an OBJ file of a building unlike the generated homes: an octagonal brick hall of 9 m under a steep
roof, a bare corridor of 8 m, and an attic with sloping ceilings.

usage: experiments/publish/make_house.py HOUSE.obj

Metres, z up. Groups have the names of their materials, which `earpoint simulate --scene` knows.
"""
import math
import sys

HALL_M, HALL_HEIGHT_M, HALL_TOP_M = 4.0, 4.0, 7.0  # from the middle to a wall; eaves; tip of the roof
CORRIDOR_END_M, CORRIDOR_HALF_M, CORRIDOR_HEIGHT_M = 12.0, 1.0, 2.5
ATTIC_END_M, ATTIC_HALF_M, EAVES_M, RIDGE_M = 20.0, 3.0, 1.4, 4.0
HALL_DOOR_M, ATTIC_DOOR_M, ATTIC_DOOR_HALF_M = 2.2, 2.1, 0.6


class House:
    def __init__(self):
        self.lines, self.count = [], 0

    def add(self, material, *polygons):
        self.lines.append(f"g {material}")
        for polygon in polygons:
            for x, y, z in polygon:
                self.lines.append(f"v {x:.4f} {y:.4f} {z:.4f}")
            first = self.count + 1
            self.count += len(polygon)
            self.lines.append("f " + " ".join(str(i) for i in range(first, self.count + 1)))

    def box(self, material, x, y, z):
        """From and to along each axis."""
        def face(axis, at):
            ranges = [x, y, z]
            ranges[axis] = (at, at)
            u, v = [i for i in range(3) if i != axis]
            corners = []
            for iu, iv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [ranges[i][0] for i in range(3)]
                corner[u], corner[v] = ranges[u][iu], ranges[v][iv]
                corners.append(tuple(corner))
            return corners
        self.add(material, *(face(axis, at) for axis in range(3) for at in (x, y, z)[axis]))


def add_hall(house):
    radius = HALL_M / math.cos(math.pi / 8)
    corners = [(radius * math.cos(math.pi / 8 * (2 * i - 1)), radius * math.sin(math.pi / 8 * (2 * i - 1)))
               for i in range(8)]
    half = corners[1][1]
    house.add("stone floor", [(x, y, 0) for x, y in corners])
    following = corners[1:] + corners[:1]
    house.add("brick wall", *([(*a, 0), (*b, 0), (*b, HALL_HEIGHT_M), (*a, HALL_HEIGHT_M)]
                              for a, b in list(zip(corners, following))[1:]))
    # The wall to the corridor has an opening of the corridor's width.
    x, door = HALL_M, CORRIDOR_HALF_M
    house.add("brick wall",
              [(x, -half, 0), (x, -door, 0), (x, -door, HALL_HEIGHT_M), (x, -half, HALL_HEIGHT_M)],
              [(x, door, 0), (x, half, 0), (x, half, HALL_HEIGHT_M), (x, door, HALL_HEIGHT_M)],
              [(x, -door, HALL_DOOR_M), (x, door, HALL_DOOR_M), (x, door, HALL_HEIGHT_M),
               (x, -door, HALL_HEIGHT_M)])
    house.add("wood ceiling", *([(*a, HALL_HEIGHT_M), (*b, HALL_HEIGHT_M), (0, 0, HALL_TOP_M)]
                                for a, b in zip(corners, following)))
    house.box("wood table", (-0.6, 0.6), (-0.6, 0.6), (0.0, 0.75))


def add_corridor(house):
    a, b, y, z = HALL_M, CORRIDOR_END_M, CORRIDOR_HALF_M, CORRIDOR_HEIGHT_M
    house.add("wood floor", [(a, -y, 0), (b, -y, 0), (b, y, 0), (a, y, 0)])
    house.add("plaster wall", *([(a, side, 0), (b, side, 0), (b, side, z), (a, side, z)]
                                for side in (-y, y)))
    house.add("plaster ceiling", [(a, -y, z), (b, -y, z), (b, y, z), (a, y, z)])


def add_attic(house):
    a, b, y, door = CORRIDOR_END_M, ATTIC_END_M, ATTIC_HALF_M, ATTIC_DOOR_HALF_M
    slope = (RIDGE_M - EAVES_M) / y
    over_door = RIDGE_M - slope * door
    house.add("carpet floor", [(a, -y, 0), (b, -y, 0), (b, y, 0), (a, y, 0)])
    house.add("plaster wall",
              *([(a, side * y, 0), (a, side * door, 0), (a, side * door, over_door),
                 (a, side * y, EAVES_M)] for side in (-1, 1)),
              [(a, -door, ATTIC_DOOR_M), (a, door, ATTIC_DOOR_M), (a, door, over_door), (a, 0, RIDGE_M),
               (a, -door, over_door)],
              [(b, -y, 0), (b, y, 0), (b, y, EAVES_M), (b, 0, RIDGE_M), (b, -y, EAVES_M)],
              *([(a, side * y, 0), (b, side * y, 0), (b, side * y, EAVES_M), (a, side * y, EAVES_M)]
                for side in (-1, 1)))
    house.add("wood ceiling", *([(a, side * y, EAVES_M), (b, side * y, EAVES_M), (b, 0, RIDGE_M),
                                 (a, 0, RIDGE_M)] for side in (-1, 1)))
    house.box("fabric sofa", (17.0, 19.0), (-2.6, -1.8), (0.0, 0.8))
    house.box("wood cupboard", (13.0, 14.2), (2.2, 2.7), (0.0, 1.5))


def main():
    house = House()
    add_hall(house)
    add_corridor(house)
    add_attic(house)
    with open(sys.argv[1], "w") as file:
        file.write("\n".join(house.lines) + "\n")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Draws docs/images/method.svg: from picture and sound at the source to the sound at the target.

usage: experiments/publish/method_figure.py > docs/images/method.svg
"""

GIVEN = ("#eceff3", "#7a828e")
COMPUTED = ("#dbe8f6", "#2563a8")
LEARNED = ("#fbe6cd", "#c8761c")
WIDTH, HEIGHT = 940, 430

# Name: left, top, width, kind, lines; a box is 52 high.
BOXES = {
    "picture": (15, 20, 130, GIVEN, ["picture, box", "64 px, 90 degrees"]),
    "sound": (15, 190, 130, GIVEN, ["source sound", "two ears, 1 s"]),
    "pose": (205, 20, 130, GIVEN, ["target pose", "every 10 ms"]),
    "spectra": (15, 335, 130, COMPUTED, ["spectra", "magnitude, phase"]),
    "summary": (205, 190, 130, COMPUTED, ["summary", "levels, lags"]),
    "speaker": (205, 105, 130, LEARNED, ["speaker", "position, heading"]),
    "geometry": (395, 20, 150, COMPUTED, ["geometry", "angles, levels, delays"]),
    "conditions": (395, 105, 150, LEARNED, ["conditions", "of all that follows"]),
    "trunk": (395, 190, 150, LEARNED, ["trunk", "6 dilated convolutions"]),
    "kernels": (605, 190, 150, LEARNED, ["kernels, gains", "per band, per bin"]),
    "phase": (605, 20, 150, COMPUTED, ["delays, levels", "expected for each ear"]),
    "share": (605, 105, 150, LEARNED, ["share of the voice", "per band and ear"]),
    "filter": (605, 335, 150, COMPUTED, ["filter", "magnitudes x phases"]),
    "texture": (205, 262, 130, GIVEN, ["texture", "natural or mean"]),
    "rounds": (800, 335, 125, COMPUTED, ["phase rounds", "consistent frames"]),
    "output": (800, 245, 125, GIVEN, ["target sound", "two ears"]),
}
H = 52


def side(name, where):
    x, y, w = BOXES[name][:3]
    return {"left": (x, y + H / 2), "right": (x + w, y + H / 2),
            "top": (x + w / 2, y), "bottom": (x + w / 2, y + H)}[where]


def box(name):
    x, y, w, (fill, stroke), lines = BOXES[name]
    middle = x + w / 2
    return (f'<rect x="{x}" y="{y}" width="{w}" height="{H}" rx="6" fill="{fill}" '
            f'stroke="{stroke}" stroke-width="1.5"/>'
            f'<text x="{middle}" y="{y + 22}" font-weight="bold">{lines[0]}</text>'
            f'<text x="{middle}" y="{y + 40}" font-size="11.5" fill="#4a5361">{lines[1]}</text>')


def arrow(points):
    path = " L".join(f"{x:.0f} {y:.0f}" for x, y in points)
    return (f'<path d="M{path}" fill="none" stroke="#4a5361" stroke-width="1.5" '
            f'marker-end="url(#head)"/>')


def straight(a, from_side, b, to_side):
    return arrow([side(a, from_side), side(b, to_side)])


def bent(a, from_side, b, to_side, x):
    """Across to the column x, along it, and across again."""
    start, end = side(a, from_side), side(b, to_side)
    return arrow([start, (x, start[1]), (x, end[1]), end])


def arrows():
    yield bent("picture", "right", "speaker", "left", 175)
    yield straight("sound", "bottom", "spectra", "top")
    yield arrow([side("spectra", "right"), (175, 361), (175, 216), side("summary", "left")])
    yield straight("summary", "top", "speaker", "bottom")
    yield straight("pose", "right", "geometry", "left")
    yield arrow([side("speaker", "right"), (365, 131), (365, 58), (395, 58)])
    yield straight("geometry", "bottom", "conditions", "top")
    yield arrow([(335, 208), (380, 208), (380, 131), (395, 131)])
    yield straight("conditions", "bottom", "trunk", "top")
    yield arrow([(175, 361), (365, 361), (365, 222), (395, 222)])
    yield straight("trunk", "right", "kernels", "left")
    yield straight("geometry", "right", "phase", "left")
    yield straight("conditions", "right", "share", "left")
    yield arrow([(545, 143), (575, 143), (575, 206), (605, 206)])
    yield straight("kernels", "bottom", "filter", "top")
    yield arrow([side("phase", "right"), (785, 46), (785, 300), (720, 300), (720, 335)])
    yield arrow([side("share", "right"), (772, 131), (772, 285), (700, 285), (700, 335)])
    yield arrow([side("spectra", "right"), side("filter", "left")])
    yield arrow([side("texture", "right"), (387, 288), (387, 146), (395, 146)])
    yield straight("filter", "right", "rounds", "left")
    yield straight("rounds", "top", "output", "bottom")


def main():
    print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
          f'width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="13" '
          'fill="#1d2430" text-anchor="middle">'
          '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
          'markerHeight="7" orient="auto"><path d="M0 0 L8 4 L0 8 z" fill="#4a5361"/></marker>'
          f'</defs><rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>')
    for line in arrows():
        print(line)
    for name in BOXES:
        print(box(name))
    for x, (fill, stroke), word in ((20, GIVEN, "given"), (90, COMPUTED, "computed"),
                                    (180, LEARNED, "learned")):
        print(f'<rect x="{x}" y="407" width="14" height="14" fill="{fill}" stroke="{stroke}"/>'
              f'<text x="{x + 20}" y="419" font-size="12" text-anchor="start">{word}</text>')
    print("</svg>")


if __name__ == "__main__":
    main()

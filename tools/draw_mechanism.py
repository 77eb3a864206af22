"""The drawing of the mechanism in the README: every dimension, sign and name.

    python3 tools/run.py python tools/draw_mechanism.py

The deformed neck is a solution of the model. Dimensions that are zero in the presets (`head.b`, `tendons.pulley_x`) are
drawn large enough to be seen.
"""

import math
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

import ecm_fast as ecm

TARGET = Path(__file__).resolve().parent.parent / ".pictures" / "mechanism.svg"
WIDTH, HEIGHT, SCALE = 1040, 640, 2900.0  # [px], [px], [px/m]
ORIGIN = (400.0, 545.0)  # the clamp's center O [px]
HALF_WIDTH = 0.022  # of the drawn beam [m]; the model is a line
NECK = ecm.Mechanism.preset("slender").replace(
    b=0.02, pulley_x=0.018, pulley_z=0.078, **{"tendons.pulley_radius": 0.011}
)
LOADS = (150.0, 20.0)
INK, BLUE, RED, GREEN, GRAY = "#1c2733", "#1f5fbf", "#b3261e", "#2e7d32", "#8592a0"

Point = tuple[float, float]


def place(x: float, z: float) -> Point:
    """Return the pixel of a point of the plane: x points up, z to the left."""
    return ORIGIN[0] - z * SCALE, ORIGIN[1] - x * SCALE


def between(a: Point, b: Point, share: float) -> Point:
    """Return the point at a share of the way from `a` to `b`."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def line(a: Point, b: Point, color: str = INK, width: float = 1.5, dash: str = "", ends: str = "") -> str:
    """Return a line; `ends` names the ends that bear an arrow head, of "ab"."""
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    (ax, ay), (bx, by) = a, b
    ends_at = f'x1="{ax:.1f}" y1="{ay:.1f}" x2="{bx:.1f}" y2="{by:.1f}"'
    drawn = f'<line {ends_at} stroke="{color}" stroke-width="{width}"{dashed}/>'
    for end, tip, tail in (("a", a, b), ("b", b, a)):
        if end in ends:
            drawn += head(tip, math.atan2(tip[1] - tail[1], tip[0] - tail[0]), color, 6.0 + 1.5 * width)
    return drawn


def head(tip: Point, angle: float, color: str, size: float) -> str:
    """Return an arrow head at `tip` that points along `angle`."""
    corners = [tip] + [
        (tip[0] - size * math.cos(angle + side), tip[1] - size * math.sin(angle + side)) for side in (0.35, -0.35)
    ]
    return f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in corners)}" fill="{color}"/>'


def text(at: Point, words: str, color: str = INK, anchor: str = "middle", size: int = 15, style: str = "") -> str:
    """Return a line of text whose baseline is at `at`."""
    return (
        f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{color}" font-size="{size}" text-anchor="{anchor}"{style}>'
        f"{escape(words)}</text>"
    )


def dot(at: Point, color: str = INK, radius: float = 4.0, fill: bool = True) -> str:
    """Return a disk or a circle."""
    return (
        f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:.1f}" stroke="{color}" stroke-width="1.5" '
        f'fill="{color if fill else "none"}"/>'
    )


def path(points: list[Point], color: str, width: float, fill: str = "none", dash: str = "") -> str:
    """Return a polyline, or a filled outline."""
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" stroke="{color}" '
        f'stroke-width="{width}" fill="{fill}"{dashed}/>'
    )


def arc(center: Point, radius: float, start: float, end: float, color: str) -> str:
    """Return an arc with an arrow head at `end`; angles in rad, counterclockwise from the right on the page."""
    angles = np.linspace(start, end, 25)
    points = [(center[0] + radius * math.cos(a), center[1] - radius * math.sin(a)) for a in angles]
    (px, py), (qx, qy) = points[-3], points[-1]
    return path(points[:-1], color, 1.8) + head(points[-1], math.atan2(qy - py, qx - px), color, 9.0)


class Frame:
    """A point of the head and its axes on the page: `along` is e_x^H, `across` e_z^H, distances in m."""

    def __init__(self, eq: ecm.Equilibrium) -> None:
        self.x, self.z, self.sin, self.cos = eq.x, eq.z, math.sin(eq.theta), math.cos(eq.theta)

    def __call__(self, along: float, across: float) -> Point:
        return place(self.x + along * self.cos + across * self.sin, self.z - along * self.sin + across * self.cos)


def ground(eq: ecm.Equilibrium) -> list[str]:
    """Return the clamp, the axes, the neck at rest and the deformed neck."""
    shape = eq.shape(41)
    edges = [
        [place(x + side * HALF_WIDTH * math.sin(t), z + side * HALF_WIDTH * math.cos(t)) for x, z, t in shape]
        for side in (1.0, -1.0)
    ]
    length = NECK.beam.length
    rest = [place(0.0, HALF_WIDTH), place(length, HALF_WIDTH), place(length, -HALF_WIDTH), place(0.0, -HALF_WIDTH)]
    o, at_length = place(0.0, 0.0), place(length, -0.033)
    hatch = [line(place(0.0, z), place(-0.006, z - 0.006), GRAY) for z in np.arange(-0.03, 0.0361, 0.006)]
    return [
        path([*edges[0], *edges[1][::-1]], "none", 0.0, fill="#dbe6f5"),
        path(rest, GRAY, 1.2, dash="6 5"),
        line(o, place(0.172, 0.0), GRAY, 1.2, dash="2 4", ends="b"),
        text((o[0] + 8, place(0.172, 0.0)[1] + 6), "x", GRAY, "start", 17),
        line(o, place(0.0, 0.121), GRAY, 1.2, dash="2 4", ends="b"),
        text((place(0.0, 0.121)[0] - 4, o[1] - 8), "z", GRAY, "middle", 17),
        path([place(x, z) for x, z, _ in shape], BLUE, 3.0),
        line(place(0.0, 0.038), place(0.0, -0.038), INK, 2.5),
        *hatch,
        dot(o),
        text((o[0] - 14, o[1] - 8), "O", size=16),
        line(place(0.0, -0.033), at_length, INK, 1.0, ends="ab"),
        line(place(length, -HALF_WIDTH), place(length, -0.037), INK, 0.7),
        text((at_length[0] + 8, place(0.045, 0.0)[1] - 8), "L", size=16, anchor="start"),
        text((at_length[0] + 8, place(0.045, 0.0)[1] + 11), "length", BLUE, "start", 14),
    ]


def tendon(frame: Frame, side: float) -> list[str]:
    """Return a tendon with its pulley; `side` is 1 on the left, -1 on the right."""
    tendons = NECK.tendons
    anchor = frame(0.0, side * tendons.plate_half_width)
    center, radius = place(tendons.pulley_x, side * tendons.pulley_z), tendons.pulley_radius * SCALE
    dx, dy = anchor[0] - center[0], anchor[1] - center[1]
    angle = math.atan2(dy, dx) - side * math.acos(radius / math.hypot(dx, dy))
    touch = center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle)
    outermost = math.pi if side > 0.0 else 0.0
    start = angle % (2.0 * math.pi) if side > 0.0 else angle
    wrapped = [
        (center[0] + radius * math.cos(a), center[1] + radius * math.sin(a)) for a in np.linspace(start, outermost, 9)
    ]
    cell = wrapped[-1][0], center[1] + 42.0
    pull = between(anchor, touch, 70.0 / math.hypot(touch[0] - anchor[0], touch[1] - anchor[1]))
    return [
        dot(center, INK, radius, fill=False),
        dot(center, INK, 2.5),
        line(anchor, touch, GREEN, 2.0),
        path(wrapped, GREEN, 2.0),
        line(wrapped[-1], cell, GREEN, 2.0),
        f'<rect x="{cell[0] - 9:.1f}" y="{cell[1]:.1f}" width="18" height="14" fill="white" stroke="{INK}"/>',
        line(anchor, pull, GREEN, 4.0, ends="b"),
    ]


def dimensions(frame: Frame) -> list[str]:
    """Return the plate, the pulleys and the head with their dimensions."""
    tendons, head_ = NECK.tendons, NECK.head
    q, p, r = frame(0.0, 0.0), frame(0.0, tendons.plate_half_width), frame(0.0, -tendons.plate_half_width)
    foot, s = frame(head_.h, 0.0), frame(head_.h, head_.b)
    offset = frame(0.009, -0.001), frame(0.009, -tendons.plate_half_width)
    o, pulley = place(0.0, 0.0), place(tendons.pulley_x, -tendons.pulley_z)
    left = place(tendons.pulley_x, tendons.pulley_z)
    radius, below, aside = tendons.pulley_radius * SCALE, o[1] + 62.0, pulley[0] + 62.0
    edge = left[0] + radius * math.cos(0.9), left[1] - radius * math.sin(0.9)
    turned = math.degrees(math.atan2(offset[1][1] - offset[0][1], offset[1][0] - offset[0][0]))
    label = between(frame(0.0125, 0.0), frame(0.0125, -tendons.plate_half_width), 0.62)
    slanted = f' transform="rotate({turned:.1f} {label[0]:.1f} {label[1]:.1f})"'
    return [
        line(p, r, INK, 6.0),
        line(q, foot, GRAY, 1.5),
        line(foot, s, GRAY, 1.5),
        line(q, frame(0.024, 0.0), INK, 2.5, ends="b"),
        text((frame(0.024, 0.0)[0] - 10, frame(0.024, 0.0)[1] + 14), "e_x^H", size=14, anchor="end"),
        line(p, frame(0.0, tendons.plate_half_width + 0.014), INK, 2.5, ends="b"),
        text((frame(0.0, tendons.plate_half_width + 0.014)[0] - 4, p[1] + 14), "e_z^H", size=14, anchor="end"),
        *(dot(point) for point in (q, p, r)),
        text((q[0] + 16, q[1] + 20), "Q", size=16),
        text((p[0] - 2, p[1] - 12), "P", size=16),
        text((r[0] + 14, r[1] - 4), "R", size=16),
        dot(s, INK, 7.0),
        text((s[0] - 14, s[1] - 6), "S", size=16, anchor="end"),
        line(s, (s[0], s[1] + 58.0), RED, 2.5, ends="b"),
        text((s[0] - 8, s[1] + 50.0), "mass g", RED, "end"),
        text((between(q, foot, 0.72)[0] - 8, between(q, foot, 0.72)[1] + 4), "h", BLUE, "end", 16),
        text((between(foot, s, 0.5)[0] - 2, between(foot, s, 0.5)[1] - 7), "b", BLUE, "middle", 16),
        line(*offset, INK, 1.0, ends="ab"),
        text(label, "d plate_half_width", BLUE, size=14, style=slanted),
        line((o[0], below), (pulley[0], below), INK, 1.0, ends="ab"),
        line(pulley, (pulley[0], below + 6.0), INK, 0.7),
        line((o[0], o[1] + 8.0), (o[0], below + 6.0), INK, 0.7),
        text((0.5 * (o[0] + pulley[0]), below - 7.0), "pulley_z", BLUE, size=14),
        line(pulley, (aside + 6.0, pulley[1]), INK, 0.7),
        line((pulley[0] - 100.0, o[1]), (aside + 6.0, o[1]), INK, 0.7),
        line((aside, o[1]), (aside, pulley[1]), INK, 1.0, ends="ab"),
        text((aside + 8.0, 0.5 * (o[1] + pulley[1]) + 5.0), "pulley_x", BLUE, "start", 14),
        line(left, edge, INK, 1.0, ends="b"),
        text((edge[0] + 8.0, edge[1] - 2.0), "pulley_radius", BLUE, "start", 14),
    ]


def loads(frame: Frame) -> list[str]:
    """Return tip angle, tendon forces and the wrench at Q, by the names of their columns."""
    q, up = frame(0.0, 0.0), math.pi / 2.0
    p, r = frame(0.0, NECK.tendons.plate_half_width), frame(0.0, -NECK.tendons.plate_half_width)
    return [
        line(q, (q[0], q[1] - 150.0), GRAY, 1.2, dash="2 4"),
        arc(q, 112.0, up, up + math.asin(-frame.sin), INK),
        text((q[0], q[1] - 156.0), "theta < 0"),
        line(q, (q[0], q[1] - 60.0), RED, 3.0, ends="b"),
        text((q[0] + 7, q[1] - 50.0), "fx_N", RED, "start", 14),
        line(q, (q[0] - 75.0, q[1]), RED, 3.0, ends="b"),
        text((q[0] - 82, q[1] + 4.0), "fz_N", RED, "end", 14),
        arc(q, 44.0, -0.35 * math.pi, -0.72 * math.pi, RED),
        text((q[0] - 10, q[1] + 64.0), "tau_Nm", RED, "end", 14),
        text((p[0] + 12, p[1] + 62.0), "lam_l_N", GREEN, "start", 14),
        text((r[0] + 38, r[1] + 48.0), "lam_r_N", GREEN, "start", 14),
        text((p[0] + 14, place(0.0, 0.0)[1] + 24.0), "force cell", INK, "middle", 12),
        text((p[0] + 12, p[1] + 80.0), "left tendon", GREEN, "start", 12),
        text((r[0] + 45, r[1] + 66.0), "right tendon", GREEN, "start", 12),
    ]


def legend() -> list[str]:
    """Return the signs, and the names that are no lengths."""
    o = (850.0, 130.0)
    names = [
        ("beam", "EA, GA, EI, mass_per_length, axial_law"),
        ("head", "mass, in S; rigid with the plate P-R"),
        ("gravity", "g, along -x; tilt > 0 (or tilt_deg) turns it to -z"),
        ("tendons", "free in the air from P, R to the pulleys,"),
        ("", "tangent on the outer side, no friction"),
        ("", ""),
        ("blue", "names in mechanism files and replace()"),
        ("red, green", "loads, as columns of a data file"),
        ("dashed", "the unloaded neck"),
    ]
    signs = [
        line(o, (o[0], o[1] - 75.0), GRAY, 2.0, ends="b"),
        text((o[0] + 12, o[1] - 66.0), "x", GRAY, size=17),
        line(o, (o[0] - 75.0, o[1]), GRAY, 2.0, ends="b"),
        text((o[0] - 68.0, o[1] - 10.0), "z", GRAY, size=17),
        dot(o, GRAY, 7.0, fill=False),
        line((o[0] - 5, o[1] - 5), (o[0] + 5, o[1] + 5), GRAY),
        line((o[0] - 5, o[1] + 5), (o[0] + 5, o[1] - 5), GRAY),
        text((o[0] + 14, o[1] + 16.0), "y, into the page", GRAY, "start", 13),
        arc(o, 50.0, 0.47 * math.pi, 0.1 * math.pi, INK),
        text((o[0] + 50.0, o[1] - 38.0), "theta > 0, tau > 0", INK, "start", 13),
    ]
    rows = []
    for number, (section, words) in enumerate(names):
        y = 230.0 + 22.0 * number
        rows += [text((700.0, y), section, BLUE, "start", 13), text((780.0, y), words, INK, "start", 12)]
    return signs + rows


def drawing() -> str:
    """Return the drawing as SVG."""
    eq = ecm.FiniteElementModel(NECK).solve(LOADS)
    frame = Frame(eq)
    parts = [*ground(eq), *tendon(frame, 1.0), *tendon(frame, -1.0), *dimensions(frame), *loads(frame), *legend()]
    size = f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="Helvetica, Arial, sans-serif"'
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" {size}>', '<rect width="100%" height="100%" fill="white"/>']
    return "\n".join([*lines, *parts, "</svg>\n"])


def main() -> None:
    """Write the drawing."""
    TARGET.write_text(drawing(), encoding="utf-8")


if __name__ == "__main__":
    main()

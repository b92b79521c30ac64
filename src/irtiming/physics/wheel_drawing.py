"""The wheel draws itself: figure 4(a) of Schatz 2023 as SVG, with the rig's own angles and beam positions.

All angles and both light beams are to scale; the radii of wheel, cutouts and mask, which no formula needs, are not.
Everything is drawn for a clockwise wheel and mirrored about the vertical for a counterclockwise one; text is not.
"""

from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, pi, sin, tan
from typing import TypeAlias, final
from xml.sax.saxutils import escape

from irtiming.records.rig import Rotation
from irtiming.records.wheel_geometry import GateAngles, WheelModel

_WIDTH, _HEIGHT = 990, 664
_AXLE = (366.0, 326.0)
_RIM = 252.0
_INK, _FAINT = "#1d2733", "#7a8794"
_WHEEL, _WHEEL_EDGE = "#5b8ec4", "#1f4e86"
_MASK, _MASK_EDGE = "#9fd3a6", "#1d7a3a"
_BEAM = "#c0271d"
_ANGLE = "#7b3fa0"
_TURN = 2 * pi
_SHOWN_ANGLE_RAD = 50 * pi / 180

_Place: TypeAlias = tuple[float, float]


@final
@dataclass(frozen=True)
class _Style:
    """How a line or a label looks; ``halo`` keeps a label readable on what lies below it."""

    colour: str
    width: float = 1.2
    dash: str = ""
    size: float = 15
    anchor: str = "middle"
    halo: bool = False


@final
@dataclass(frozen=True)
class _Scene:
    """The model at one wheel angle; radii in drawing units, polar angles as in the model (clockwise from the right)."""

    model: WheelModel
    gates: GateAngles
    rotation: Rotation
    wheel_angle_rad: float
    control_slots: int

    @property
    def beside_m(self) -> tuple[float, float]:
        """Distances of the application beam and of the control beam from the vertical through the axle."""
        gates = self.gates
        return gates.height_m * tan(gates.application_rad), gates.control_height_m * tan(gates.control_rad)

    @property
    def scale(self) -> float:
        """Drawing units per metre: the application beam lies just inside the rim."""
        return 0.935 * _RIM / hypot(self.beside_m[0], self.gates.height_m)

    @property
    def application_radius(self) -> float:
        return 0.935 * _RIM

    @property
    def control_radius(self) -> float:
        return hypot(self.beside_m[1], self.gates.control_height_m) * self.scale

    @property
    def cutout_radii(self) -> tuple[float, float]:
        return 0.30 * self.control_radius, 0.85 * self.control_radius

    @property
    def mask_radii(self) -> tuple[float, float]:
        return 0.40 * self.control_radius, 0.78 * self.control_radius

    def edge_rad(self, edge: int) -> float:
        """Polar angle of a cutout edge."""
        return self.model.gate_angle_rad + self.wheel_angle_rad - self.model.cutout_edges_rad[edge]

    def at(self, radius: float, polar_rad: float) -> tuple[float, float]:
        """Place in the drawing; mirrored for a counterclockwise wheel."""
        side = 1 if self.rotation == "clockwise" else -1
        return _AXLE[0] + side * radius * cos(polar_rad), _AXLE[1] + radius * sin(polar_rad)

    def sweep(self, *, forwards: bool) -> int:
        """SVG's sweep flag of an arc in the direction of growing polar angle, or against it."""
        return int(forwards == (self.rotation == "clockwise"))


def drawing(
    model: WheelModel,
    gates: GateAngles,
    *,
    rotation: Rotation = "clockwise",
    wheel_angle_rad: float = _SHOWN_ANGLE_RAD,
    control_slots: int = 100,
) -> str:
    """Wheel, mask opening and light beams as the camera sees them, with every symbol of the definitions.

    Parameters
    ----------
    model, gates
        Geometry, as :func:`irtiming.physics.wheel.wheel_model` and
        :func:`irtiming.physics.light_gates.gate_angles` give it.
    rotation
        As the camera sees it.
    wheel_angle_rad
        At which the wheel is drawn, rad; 0 puts the reference edge on the application beam.
    control_slots
        Of the ring.

    Returns
    -------
    A complete SVG element as text, without links to anything outside.
    """
    scene = _Scene(model, gates, rotation, wheel_angle_rad, control_slots)
    title = f"Chopper wheel, mask opening and light beams at wheel angle {degrees(wheel_angle_rad):.1f} degrees"
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
            'font-family="Helvetica, Arial, \'DejaVu Sans\', sans-serif" font-size="15">',
            f"<title>{escape(title)}</title>",
            f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="white"/>',
            *_opening(scene),
            *_wheel(scene),
            *_opening_labels(scene),
            *_beams(scene),
            *_dimensions(scene),
            *_edges(scene),
            *_motion(scene),
            *_axle(),
            *_key(scene),
            "</svg>",
        ]
    )


def _opening(scene: _Scene) -> list[str]:
    """The mask's opening, behind the wheel."""
    low, high = _opening_ends(scene)
    return [f'<path d="{_sector(scene, scene.mask_radii, (low, high))}" fill="{_MASK}"/>']


def _opening_ends(scene: _Scene) -> tuple[float, float]:
    half = scene.model.opening_angle_rad / 2
    return scene.model.centre_angle_rad - half, scene.model.centre_angle_rad + half


def _wheel(scene: _Scene) -> list[str]:
    """Disc with its two cutouts, the two application slots and the ring of control slots, all cut through."""
    disc = _sector(scene, (_RIM, _RIM), (0, _TURN))
    cutouts = [(scene.edge_rad(2), scene.edge_rad(1)), (scene.edge_rad(0) - _TURN, scene.edge_rad(3))]
    band = (scene.application_radius - 6, scene.application_radius + 6)
    holes = [_sector(scene, radii, ends) for ends in cutouts for radii in (scene.cutout_radii, band)]
    low, high = scene.control_radius - 6, scene.control_radius + 6
    first, pitch = scene.edge_rad(0), _TURN / scene.control_slots
    slots = [
        _sector(scene, (low, high), (first - pitch * (j + 0.5), first - pitch * j)) for j in range(scene.control_slots)
    ]
    outline = f'fill="{_WHEEL}" fill-opacity="0.62" fill-rule="evenodd" stroke="{_WHEEL_EDGE}" stroke-width="1.1"'
    covered = _path(_sector(scene, scene.mask_radii, _opening_ends(scene)), _Style(_MASK_EDGE, width=1.8, dash="6 4"))
    return [f'<path d="{" ".join([disc, *holes, *slots])}" {outline}/>', covered]


def _opening_labels(scene: _Scene) -> list[str]:
    """Opening angle gamma between the mask's edges, and the direction phi_M of its bisector."""
    low, high = _opening_ends(scene)
    centre, middle = scene.model.centre_angle_rad, sum(scene.mask_radii) / 2
    radius = scene.mask_radii[1] - 16
    return [
        _line(scene.at(0, 0), scene.at(_RIM + 40, centre), _Style(_MASK_EDGE, dash="10 3 2 3")),
        _label(scene.at(_RIM + 56, centre), "φ_M", _Style(_MASK_EDGE, size=18)),
        *_arc(scene, radius, ends=(low, high), style=_Style(_MASK_EDGE), both=True),
        _label(scene.at(radius - 18, centre - 0.20), "γ", _Style(_MASK_EDGE, size=19, halo=True)),
        _label(scene.at(middle - 4, centre + 0.30), "mask", _Style(_MASK_EDGE, size=13, halo=True)),
        _label(scene.at(middle - 22, centre + 0.34), "opening", _Style(_MASK_EDGE, size=13, halo=True)),
    ]


def _beams(scene: _Scene) -> list[str]:
    """Rays from the axle to both beams, their angles from the vertical, and the beams themselves."""
    application, control = scene.model.gate_angle_rad, pi / 2 - scene.gates.control_rad
    return [
        _line(scene.at(0, 0), scene.at(_RIM + 12, pi / 2), _Style(_FAINT, dash="4 4")),
        _line(scene.at(0, 0), scene.at(scene.application_radius, application), _Style(_BEAM)),
        _line(scene.at(0, 0), scene.at(scene.control_radius, control), _Style(_BEAM)),
        *_arc(scene, 0.60 * _RIM, ends=(pi / 2, application), style=_Style(_BEAM)),
        *_arc(scene, 0.60 * _RIM, ends=(pi / 2, control), style=_Style(_BEAM)),
        _label(scene.at(0.67 * _RIM, (application + pi / 2) / 2), "β_1", _Style(_BEAM, size=17, halo=True)),
        _label(scene.at(0.67 * _RIM, (control + pi / 2) / 2), "β_2", _Style(_BEAM, size=17, halo=True)),
        *(_dot(scene.at(r, phi)) for r, phi in _beam_places(scene)),
    ]


def _beam_places(scene: _Scene) -> tuple[tuple[float, float], tuple[float, float]]:
    """Radius and polar angle of the application beam and of the control beam."""
    control = atan2(scene.gates.control_height_m, scene.beside_m[1])
    return (scene.application_radius, scene.model.gate_angle_rad), (scene.control_radius, control)


def _dimensions(scene: _Scene) -> list[str]:
    """Distance d below the wheel, h on the application beam's side, h - dh and dh on the control beam's side."""
    side = 1 if scene.rotation == "clockwise" else -1
    (left, low), (right, high) = (scene.at(r, phi) for r, phi in _beam_places(scene))
    bottom = _AXLE[1] + _RIM + 34
    far = _AXLE[0] - side * (_RIM + 46), _AXLE[0] + side * (_RIM + 46)
    beyond = 8 * side
    parts = [
        _line((left, low), (left, bottom + 8), _Style(_INK, width=0.7)),
        _line((right, high), (right, bottom + 8), _Style(_INK, width=0.7)),
        _line((_AXLE[0], _AXLE[1] + _RIM + 12), (_AXLE[0], bottom + 8), _Style(_INK, width=0.7)),
        _line(_AXLE, (far[0] - beyond, _AXLE[1]), _Style(_INK, width=0.7, dash="2 3")),
        _line(_AXLE, (far[1] + beyond, _AXLE[1]), _Style(_INK, width=0.7, dash="2 3")),
        _line((left, low), (far[0] - beyond, low), _Style(_INK, width=0.7)),
        _line((right, high), (far[1] + beyond, high), _Style(_INK, width=0.7)),
        _line((left, low), (far[1] + beyond, low), _Style(_INK, width=0.7)),
    ]
    for start, end, text, place in (
        ((left, bottom), (_AXLE[0], bottom), "d", ((left + _AXLE[0]) / 2, bottom + 18)),
        ((_AXLE[0], bottom), (right, bottom), "d", ((right + _AXLE[0]) / 2, bottom + 18)),
        ((far[0], _AXLE[1]), (far[0], low), "h", (far[0] - 14 * side, (_AXLE[1] + low) / 2)),
        ((far[1], _AXLE[1]), (far[1], high), "h − Δh", (far[1] + 32 * side, (_AXLE[1] + high) / 2)),
        ((far[1], high), (far[1], low), "Δh", (far[1] + 22 * side, (low + high) / 2)),
    ):
        parts += [
            _line(start, end, _Style(_INK)),
            *_tips(start, end),
            _label(place, text, _Style(_INK, size=17)),
        ]
    parts += [
        _label((left - 12 * side, bottom - 1), "application beam", _Style(_BEAM, anchor=_outwards(-side))),
        _label((right + 12 * side, bottom - 1), "control beam", _Style(_BEAM, anchor=_outwards(side))),
    ]
    return parts


def _edges(scene: _Scene) -> list[str]:
    """The four cutout edges, labelled outside the rim."""
    parts = []
    for edge in range(4):
        polar = scene.edge_rad(edge)
        start, end = scene.at(scene.cutout_radii[0], polar), scene.at(_RIM + 14, polar)
        parts += [
            _line(start, end, _Style(_WHEEL_EDGE, width=2.4)),
            _label(scene.at(_RIM + 28, polar), f"α_{edge}", _Style(_WHEEL_EDGE, size=19, halo=True)),
        ]
    return parts


def _motion(scene: _Scene) -> list[str]:
    """Wheel angle theta from the application beam to edge 0, and the direction of rotation."""
    gate, first = scene.model.gate_angle_rad, scene.edge_rad(0)
    turned = scene.wheel_angle_rad % _TURN
    outside = _RIM + 24
    rotation = -1.22, -0.80
    parts = [
        *_arc(scene, outside, ends=rotation, style=_Style(_INK, width=2.2)),
        _label(scene.at(outside + 12, sum(rotation) / 2), "rotation", _Style(_INK, anchor=_outwards(_side(scene)))),
    ]
    if turned > 0.12:
        radius = 0.47 * _RIM
        parts += [
            _line(scene.at(0, 0), scene.at(scene.cutout_radii[0], first), _Style(_ANGLE, dash="3 3")),
            *_arc(scene, radius, ends=(gate, gate + turned), style=_Style(_ANGLE, width=1.8)),
            _label(scene.at(radius + 15, gate + turned / 2), "θ", _Style(_ANGLE, size=20, halo=True)),
        ]
    return parts


def _side(scene: _Scene) -> int:
    return 1 if scene.rotation == "clockwise" else -1


def _outwards(side: int) -> str:
    return "start" if side > 0 else "end"


def _axle() -> list[str]:
    x, y = _AXLE
    return [
        f'<circle cx="{x}" cy="{y}" r="7" fill="white" stroke="{_INK}" stroke-width="1.6"/>',
        _line((x - 11, y), (x + 11, y), _Style(_INK)),
        _line((x, y - 11), (x, y + 11), _Style(_INK)),
    ]


def _key(scene: _Scene) -> list[str]:
    """The numbers behind the symbols, in a column to the right."""
    edges, gates = scene.model.cutout_edges_rad, scene.gates
    centre = scene.model.centre_angle_rad if _side(scene) > 0 else pi - scene.model.centre_angle_rad
    centre = (centre + pi) % _TURN - pi
    rows = [
        ("θ", f"{degrees(scene.wheel_angle_rad):.2f}°", "wheel angle here", _ANGLE),
        *((f"α_{i}", f"{degrees(edges[i]):.3f}°", f"cutout edge {i}", _WHEEL_EDGE) for i in range(4)),
        ("γ", f"{degrees(scene.model.opening_angle_rad):.2f}°", "opening angle", _MASK_EDGE),
        ("φ_M", f"{degrees(centre):.3f}°", "opening centre", _MASK_EDGE),
        ("β_1", f"{degrees(gates.application_rad):.3f}°", "application beam", _BEAM),
        ("β_2", f"{degrees(gates.control_rad):.3f}°", "control beam", _BEAM),
        ("d", f"{1e3 * sum(scene.beside_m) / 2:.2f} mm", "half beam spacing", _INK),
        ("h", f"{1e3 * gates.height_m:.2f} mm", "application beam", _INK),
        ("Δh", f"{1e3 * (gates.height_m - gates.control_height_m):.2f} mm", "control beam up", _INK),
    ]
    parts = []
    for row, (symbol, number, meaning, colour) in enumerate(rows):
        y = 110 + 32 * row
        parts += [
            _label((756, y), symbol, _Style(colour, size=17, anchor="start")),
            _label((860, y), number.replace("-", "−"), _Style(_INK, size=14, anchor="end")),
            _label((872, y), meaning, _Style(_FAINT, size=12.5, anchor="start")),
        ]
    notes = ("as the camera sees it;", "φ grows clockwise from 3 o’clock;", "angles and beams to scale, radii not")
    parts += [
        _label((756, 110 + 32 * len(rows) + 8 + 18 * line), note, _Style(_FAINT, size=12.5, anchor="start"))
        for line, note in enumerate(notes)
    ]
    return parts


def _sector(scene: _Scene, radii: tuple[float, float], ends: tuple[float, float]) -> str:
    """Path of an annular sector; a whole disc where both radii are the same and the ends a turn apart."""
    inner, outer = radii
    start, end = ends[0], ends[0] + (ends[1] - ends[0]) % _TURN
    if end == start:
        a, b = scene.at(outer, 0), scene.at(outer, pi)
        return f"M{_xy(a)} A{outer:.2f} {outer:.2f} 0 1 1 {_xy(b)} A{outer:.2f} {outer:.2f} 0 1 1 {_xy(a)} Z"
    large = int(end - start > pi)
    out, back = scene.sweep(forwards=True), scene.sweep(forwards=False)
    return (
        f"M{_xy(scene.at(outer, start))} A{outer:.2f} {outer:.2f} 0 {large} {out} {_xy(scene.at(outer, end))} "
        f"L{_xy(scene.at(inner, end))} A{inner:.2f} {inner:.2f} 0 {large} {back} {_xy(scene.at(inner, start))} Z"
    )


def _arc(
    scene: _Scene, radius: float, *, ends: tuple[float, float], style: _Style, both: bool = False
) -> list[str]:  # fmt: skip
    """Arc with an arrowhead at its end, or at both."""
    start, end = ends
    forwards = end > start
    flags = f"0 {int(abs(end - start) > pi)} {scene.sweep(forwards=forwards)}"
    curve = f"M{_xy(scene.at(radius, start))} A{radius:.2f} {radius:.2f} {flags} {_xy(scene.at(radius, end))}"
    back = min(8 / radius, abs(end - start) / 2) * (-1 if forwards else 1)
    parts = [_path(curve, style), _tip(scene.at(radius, end + back), scene.at(radius, end), style.colour)]
    if both:
        parts.append(_tip(scene.at(radius, start - back), scene.at(radius, start), style.colour))
    return parts


def _tips(start: _Place, end: _Place) -> list[str]:
    return [_tip(start, end, _INK), _tip(end, start, _INK)]


def _tip(origin: _Place, end: _Place, colour: str) -> str:
    """Arrowhead at ``end``, pointing away from ``origin``; smaller on short arrows."""
    length = max(hypot(end[0] - origin[0], end[1] - origin[1]), 1e-6)
    along = (end[0] - origin[0]) / length, (end[1] - origin[1]) / length
    size = min(9.0, 1.2 * length)
    foot = end[0] - size * along[0], end[1] - size * along[1]
    half = 0.36 * size
    a = foot[0] - half * along[1], foot[1] + half * along[0]
    b = foot[0] + half * along[1], foot[1] - half * along[0]
    return f'<path d="M{_xy(end)} L{_xy(a)} L{_xy(b)} Z" fill="{colour}"/>'


def _dot(place: _Place) -> str:
    x, y = place
    return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="6" fill="{_BEAM}" stroke="white" stroke-width="1.5"/>'


def _xy(place: _Place) -> str:
    return f"{place[0]:.2f} {place[1]:.2f}"


def _path(d: str, style: _Style) -> str:
    dashes = f' stroke-dasharray="{style.dash}"' if style.dash else ""
    return f'<path d="{d}" fill="none" stroke="{style.colour}" stroke-width="{style.width}"{dashes}/>'


def _line(start: _Place, end: _Place, style: _Style) -> str:
    return _path(f"M{_xy(start)} L{_xy(end)}", style)


def _label(place: _Place, text: str, style: _Style) -> str:
    """Text centred in height on a place; ``name_index`` sets the index below."""
    name, _, index = text.partition("_")
    below, _, rest = index.partition(" ")
    inner = escape(name)
    if below:
        inner += f'<tspan font-size="72%" dy="0.28em">{escape(below)}</tspan>'
    if rest:
        inner += f'<tspan dy="-0.2em"> {escape(rest)}</tspan>'
    halo = ' stroke="white" stroke-opacity="0.75" stroke-width="3.5" paint-order="stroke" stroke-linejoin="round"'
    look = f'fill="{style.colour}" font-size="{style.size}" text-anchor="{style.anchor}"'
    look += halo if style.halo else ""
    return f'<text x="{place[0]:.2f}" y="{place[1] + 0.35 * style.size:.2f}" {look}>{inner}</text>'

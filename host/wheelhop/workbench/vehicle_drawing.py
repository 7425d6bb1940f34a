"""What each number of a vehicle is, in a drawing from the side and from behind."""

from __future__ import annotations

SYMBOLS = {
    "geometry.wheelbase_m": "L",
    "geometry.track_width_m": "W",
    "geometry.cg_to_front_axle_m": "a",
    "geometry.cg_height_m": "h",
    "body.mass_kg": "m",
    "body.pitch_inertia_kg_m2": "J<sub>p</sub>",
    "body.roll_inertia_kg_m2": "J<sub>r</sub>",
    **{
        f"{table}.{end}.{key}": f"{symbol}<sub>{letter}</sub>"
        for end, letter in (("front", "f"), ("rear", "r"))
        for table, key, symbol in (
            ("suspension", "stiffness_N_m", "k"),
            ("suspension", "damping_N_s_m", "c"),
            ("wheel", "unsprung_mass_kg", "u"),
            ("wheel", "tyre_stiffness_N_m", "t"),
            ("wheel", "tyre_damping_N_s_m", "d"),
            ("wheel", "radius_m", "R"),
        )
    },
}
"""By the numbers' dotted names, as HTML."""


def drawing() -> str:
    """Both views with every sign of `SYMBOLS`, as SVG."""
    side = [
        *_wheel(90, "r"),
        *_wheel(250, "f"),
        '<path class="shape" d="M60 70 h220 v26 h-220 z"/>',
        _text(118, 88, "m, J", "p"),
        '<circle class="mark" cx="185" cy="83" r="4"/>',
        *_span(90, 250, 196, "L"),
        *_span(185, 250, 54, "a"),
        *_rise(185, 83, 172, "h"),
    ]
    behind = [
        '<rect class="wheel" x="345" y="124" width="16" height="48" rx="5"/>',
        '<rect class="wheel" x="449" y="124" width="16" height="48" rx="5"/>',
        '<path class="shape" d="M362 70 h86 v26 h-86 z"/>',
        _text(405, 88, "J", "r", anchor="middle"),
        '<path class="line" d="M361 148 L375 96 M449 148 L435 96"/>',
        *_span(353, 457, 196, "W"),
    ]
    return (
        '<svg class="vehicle" viewBox="0 0 500 214" role="img"'
        ' aria-label="what each number is: from the side and from behind">'
        f'<path class="line" d="M20 172 H480"/>{"".join(side)}{"".join(behind)}</svg>'
    )


def _wheel(x: int, letter: str) -> list[str]:
    """A wheel with its tyre's spring and damper below the hub, the strut's above."""
    return [
        f'<circle class="wheel" cx="{x}" cy="144" r="28"/>',
        f'<path class="line" d="M{x - 8} 96 v10 l-5 3 10 5 -10 5 10 5 -5 3 v17"/>',
        f'<path class="line" d="M{x + 8} 96 v14 M{x + 2} 112 v10 h12 v-10 M{x + 2} 116 h12'
        f' M{x + 8} 122 v22"/>',
        f'<circle class="mark" cx="{x}" cy="144" r="3"/>',
        _text(x - 34, 118, "k", letter),
        _text(x + 20, 118, "c", letter),
        _text(x + 8, 142, "u", letter),
        _text(x - 8, 164, "t, d", letter),
        _text(x + 33, 158, "R", letter),
    ]


def _span(left: int, right: int, y: int, name: str) -> list[str]:
    """A length, horizontally."""
    return [
        f'<path class="measure" d="M{left} {y} H{right} M{left} {y - 5} v10'
        f' M{right} {y - 5} v10"/>',
        _text((left + right) // 2, y - 4, name, anchor="middle"),
    ]


def _rise(x: int, top: int, bottom: int, name: str) -> list[str]:
    """A height."""
    return [
        f'<path class="measure" d="M{x} {top} V{bottom}"/>',
        _text(x + 5, (top + bottom) // 2 + 12, name),
    ]


def _text(x: int, y: int, name: str, index: str = "", anchor: str = "start") -> str:
    low = f'<tspan dy="3" font-size="9">{index}</tspan>' if index else ""
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}">{name}{low}</text>'

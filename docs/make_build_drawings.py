"""Draw the pictures of firmware/BUILD.md into firmware/drawings.

Run it from anywhere: python docs/make_build_drawings.py
"""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from pathlib import Path

DRAWINGS = Path(__file__).parent.parent / "firmware/drawings"
INK, SOFT, RED, BLUE, GREEN = "#1b1f24", "#5b6470", "#c0392b", "#2166ac", "#2e7d32"
FONT = "DejaVu Sans, Arial, sans-serif"

# The printed sheet: what hands and eyes check, and what `wheelhop health` then judges.
BY_HAND = (
    ("Sensors", "bolted, M4 2 N·m, paint mark across each head; Z up within 5°"),
    ("Cables", "loop at the sensor, tie every 150 mm, free over the whole travel of the wheel"),
    ("Pull", "every plug and every cable once, firmly; nothing moves"),
    ("Supply", "5V pin 4.7 V or more while recording; AREF 3.2 to 3.4 V"),
    ("Sensors' supply", "at each plug 30 to 40 mV below AREF"),
    ("Isolation", "more than 1 MΩ from the logger's ground to the chassis"),
    ("Card", "in, taped over; LED: one short flash every 2 s"),
    ("Reset", "pressed while recording: the LED is on again within ten seconds; box shut"),
)
THE_SESSION = (
    "Vehicle on its wheels, engine off. Press the button: the LED is on.",
    "Ten seconds hands off.",
    "One strike downwards with a rubber hammer beside each sensor, 3 s apart,",
    "in this order:  B1  B2  B3  B4  A1  A2  A3  A4.",
    "Ten seconds hands off. Press the button: one flash every 2 s again.",
)
JUDGED = (
    ("settings", "the logger has a number and a calibration, HOP.CFG is understood"),
    ("supply", "3.3 V ± 10 %, no sag, no brown-out"),
    ("card", "closed by the button, nothing lost, no error"),
    ("clock", "measured, no late conversion"),
    ("quiet", "at rest below 1 code rms, no hum, every level that of a sensor"),
    ("places", "each strike felt by the sensor it was for"),
    ("upright", "each sensor went down when struck downwards"),
)


@dataclass
class Drawing:
    """An SVG that grows; coordinates in pixels, y down."""

    width: int
    height: int
    title: str
    parts: list[str] = field(default_factory=list)

    def wire(self, *points: tuple[float, float], colour: str = INK, dash: str = "") -> None:
        """A line through the points."""
        path = "M" + "L".join(f"{x:g} {y:g}" for x, y in points)
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="2"{dashed}/>'
        )

    def dot(self, x: float, y: float, colour: str = INK) -> None:
        """Where wires are joined."""
        self.parts.append(f'<circle cx="{x:g}" cy="{y:g}" r="4" fill="{colour}"/>')

    def box(
        self, x: float, y: float, width: float, height: float, fill: str = "#fff", dash: str = ""
    ) -> None:
        """A rectangle."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="5"'
            f' fill="{fill}" stroke="{INK}" stroke-width="1.5"{dashed}/>'
        )

    def shape(self, points: str, fill: str) -> None:
        """A filled polygon."""
        self.parts.append(
            f'<polygon points="{points}" fill="{fill}" stroke="{INK}" stroke-width="1.5"/>'
        )

    def text(
        self, x: float, y: float, words: str, *, size: float = 14, anchor: str = "start",
        bold: bool = False, colour: str = INK,
    ) -> None:  # fmt: skip
        """A line of text."""
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(
            f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" text-anchor="{anchor}"{weight}'
            f' fill="{colour}">{escape(words)}</text>'
        )

    def resistor(self, x: float, y: float, words: str, *, upright: bool = False) -> None:
        """A resistor about (x, y), 50 long."""
        width, height = (14, 50) if upright else (50, 14)
        self.parts.append(
            f'<rect x="{x - width / 2:g}" y="{y - height / 2:g}" width="{width}"'
            f' height="{height}" fill="#fff" stroke="{INK}" stroke-width="2"/>'
        )
        if upright:
            self.text(x + 13, y + 5, words)
        else:
            self.text(x, y - 12, words, anchor="middle")

    def capacitor(self, x: float, y: float, words: str, depth: float = 44) -> None:
        """A capacitor from (x, y) down to a ground."""
        middle = y + depth / 2
        self.wire((x, y), (x, middle - 4))
        self.wire((x - 12, middle - 4), (x + 12, middle - 4))
        self.wire((x - 12, middle + 4), (x + 12, middle + 4))
        self.wire((x, middle + 4), (x, y + depth))
        self.ground(x, y + depth)
        self.text(x + 17, middle + 5, words)

    def ground(self, x: float, y: float) -> None:
        """A ground sign hanging from (x, y)."""
        for k, half in enumerate((11, 7, 3)):
            self.wire((x - half, y + 4 * k), (x + half, y + 4 * k))

    def svg(self) -> str:
        """The file."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}"'
            f' font-family="{FONT}">'
        )
        paper = f'<rect width="{self.width}" height="{self.height}" fill="#fff"/>'
        return "\n".join(
            [head, f"<title>{escape(self.title)}</title>", paper, *self.parts, "</svg>\n"]
        )


def channel() -> Drawing:
    """One sensor from its plug to the converter, and what all eight share."""
    d = Drawing(1120, 640, "One channel and the supply, as built for a car")
    d.box(24, 60, 300, 262, "#f4f7fb", "6 4")
    d.text(36, 84, "at each of the eight places", bold=True)
    d.box(50, 110, 110, 170, "#fff")
    d.text(58, 185, "ADXL326", bold=True)
    for y, name in ((140, "Vs"), (200, "Z out"), (260, "GND")):
        d.text(154, y + 5, name, anchor="end", size=12)
    d.wire((160, 140), (470, 140), colour=RED)
    d.wire((160, 200), (470, 200), colour=BLUE)
    d.wire((160, 260), (470, 260))
    d.dot(200, 140, RED)
    d.capacitor(200, 140, "0.1 µF", 40)
    d.dot(250, 200, BLUE)
    d.capacitor(250, 200, "0.1 µF", 40)
    d.text(36, 312, "on most boards; Z: 50 Hz", size=12, colour=SOFT)

    d.box(344, 116, 112, 168, "none", "3 3")
    d.text(400, 84, "cable, to 3 m", anchor="middle", bold=True)
    d.text(400, 104, "3 × 0.14 mm², shield", anchor="middle", size=12)
    d.text(400, 302, "shield", anchor="middle", size=12, colour=SOFT)

    d.box(480, 60, 616, 556, "#f8f6ef", "6 4")
    d.text(492, 84, "in the box", bold=True)
    d.wire((470, 140), (515, 140), colour=RED)
    d.resistor(540, 140, "100 Ω")
    d.wire((565, 140), (660, 140), colour=RED)
    d.wire((470, 200), (515, 200), colour=BLUE)
    d.resistor(540, 200, "10 kΩ")
    d.wire((565, 200), (860, 200), colour=BLUE)
    d.dot(585, 200, BLUE)
    d.capacitor(585, 200, "1 nF", 40)
    d.wire((470, 260), (500, 260), (500, 316))
    d.wire((440, 284), (440, 308), (500, 308), dash="3 3")
    d.dot(500, 308)
    d.ground(500, 316)
    d.text(515, 300, "shield: here only", size=12, colour=SOFT)

    d.wire((660, 120), (660, 470), colour=RED)
    d.dot(660, 140, RED)
    d.text(600, 114, "3.3 V rail: 8 × 100 Ω, and AREF", size=13, colour=RED)
    d.wire((660, 160), (860, 160), colour=RED)
    d.dot(660, 160, RED)
    d.dot(720, 160, RED)
    d.capacitor(720, 160, "0.1 µF", 22)

    d.box(860, 100, 200, 300, "#eef3fa")
    d.text(960, 128, "Arduino Nano", anchor="middle", bold=True, size=16)
    for y, name in ((165, "AREF"), (205, "A0 … A7"), (275, "D10"), (345, "5V"), (385, "GND")):
        d.text(870, y, name, size=13)
    d.text(1050, 240, "3V3: leave open", anchor="end", size=12, colour=SOFT)
    d.text(1050, 310, "VIN: 8 NiMH cells", anchor="end", size=12, colour=SOFT)
    d.wire((860, 381), (830, 381), (830, 392))
    d.ground(830, 392)

    d.wire((720, 340), (860, 340), colour=GREEN)
    d.text(728, 334, "5 V", size=13, colour=GREEN)
    d.wire((720, 340), (720, 530), colour=GREEN)
    d.wire((790, 340), (790, 325), colour=GREEN)
    d.dot(790, 340, GREEN)
    d.resistor(790, 300, "10 kΩ", upright=True)
    d.wire((790, 275), (790, 270))
    d.wire((860, 270), (750, 270), (750, 472), (860, 472))
    d.dot(790, 270)
    d.box(860, 430, 200, 120, "#eef3fa")
    d.text(960, 456, "SD card module", anchor="middle", bold=True)
    d.text(870, 476, "CS", size=13)
    d.text(960, 500, "D11, D12, D13: README", anchor="middle", size=12, colour=SOFT)
    d.text(870, 536, "5V", size=13)
    d.wire((860, 530), (560, 530), colour=GREEN)
    d.dot(720, 530, GREEN)
    d.dot(780, 530, GREEN)
    d.capacitor(780, 530, "470 µF", 44)

    d.box(620, 470, 80, 40, "#fff")
    d.text(660, 487, "MCP1700", anchor="middle", size=12, bold=True)
    d.text(660, 502, "-3302", anchor="middle", size=12)
    d.wire((660, 510), (660, 530), colour=GREEN)
    d.dot(660, 530, GREEN)
    d.text(540, 557, "1 µF", size=13, anchor="end")
    d.dot(560, 530, GREEN)
    d.capacitor(560, 530, "", 44)
    d.dot(660, 420, RED)
    d.wire((560, 420), (660, 420), colour=RED)
    d.capacitor(560, 420, "", 40)
    d.text(540, 445, "1 µF", size=13, anchor="end")
    d.text(24, 34, "One channel and the supply", size=20, bold=True)
    d.text(36, 380, "What each part is for", bold=True)
    for k, line in enumerate(
        (
            "100 Ω: Vs on ground takes 33 mA, the rail and",
            "the other seven sensors stay as they are",
            "10 kΩ: a battery on the signal wire puts 0.9 mA",
            "into the input, which bears it",
            "1 nF: sparks and radio; the converter's charge",
            "0.1 µF at Z: 50 Hz, the anti-aliasing filter",
            "10 kΩ at CS: no commands to the card in a reset",
            "470 µF: a plug that bounces for 4 ms",
        )
    ):
        d.text(36, 406 + 22 * k, line, size=13)
    return d


def mount() -> Drawing:
    """A sensor on a tube, cut through, and where on the vehicle."""
    d = Drawing(1120, 560, "How a sensor is mounted")
    d.text(24, 34, "A sensor on a tube, cut through", size=20, bold=True)
    d.parts.append(
        f'<circle cx="270" cy="420" r="70" fill="#e3e7ec" stroke="{INK}" stroke-width="2"/>'
        f'<circle cx="270" cy="420" r="58" fill="#fff" stroke="{INK}" stroke-width="1.5"/>'
    )
    d.shape("180,330 360,330 360,350 330,350 300,357 240,357 210,350 180,350", "#b9c2cc")
    d.parts.append(
        f'<path d="M196 336 V420 A74 74 0 0 0 344 420 V336" fill="none" stroke="{SOFT}"'
        ' stroke-width="5"/>'
    )
    d.box(190, 302, 160, 28, "#cfd6de")
    d.box(200, 232, 140, 70, "#fbe9c6")
    d.box(200, 288, 140, 14, "#7fb38a")
    d.box(252, 276, 30, 12, "#333")
    for x in (206, 322):
        d.box(x, 280, 12, 8, "#888")
        d.box(x + 3, 284, 6, 46, "#888")
    d.wire((340, 262), (372, 262), (384, 240), (384, 190), (420, 176), (500, 176))
    d.wire((270, 268), (270, 200), colour=RED)
    d.shape("262,206 278,206 270,188", RED)
    d.text(254, 204, "Z, within 5° of upright", anchor="end", colour=RED)
    for y, x, lines in (
        (258, 206, ("filled with", "neutral silicone")),
        (295, 206, ("board: two M3,", "epoxy at its corners")),
        (340, 186, ("saddle, epoxied to", "the bare tube")),
        (400, 196, ("two band clamps,", "3 N·m")),
        (466, 212, ("tube at a node,", "axle or upright")),
    ):
        d.wire((160, y), (x, y), colour=SOFT)
        for k, line in enumerate(lines):
            d.text(152, y + 15 * k - 2, line, anchor="end", size=12)
    d.text(372, 320, "plate, aluminium 3 mm", size=12)
    d.wire((350, 316), (368, 316), colour=SOFT)
    d.text(396, 226, "first tie on the same part,", size=12)
    d.text(396, 242, "then a loop 60 mm across", size=12)

    d.text(600, 34, "Where", size=20, bold=True)
    d.box(640, 150, 420, 26, "#e3e7ec")
    d.text(850, 168, "frame", anchor="middle")
    for x, b, a in ((700, "B1 B2", "A1 A2"), (1000, "B3 B4", "A3 A4")):
        d.parts.append(
            f'<circle cx="{x}" cy="380" r="62" fill="#f3f3f3" stroke="{INK}" stroke-width="2"/>'
            f'<circle cx="{x}" cy="380" r="20" fill="#cfd6de" stroke="{INK}" stroke-width="2"/>'
        )
        zigzag = [(x, 176), (x, 200)]
        zigzag += [(x + (14 if k % 2 else -14), 208 + 16 * k) for k in range(8)]
        d.wire(*zigzag, (x, 336), (x, 362))
        d.box(x - 16, 128, 32, 22, "#f6b26b")
        d.box(x - 50, 356, 30, 20, "#f6b26b")
        d.text(x, 118, b, anchor="middle", bold=True)
        d.text(x - 92, 346, a, anchor="middle", bold=True)
    d.text(850, 226, "B: where the strut meets the frame,", anchor="middle", size=13)
    d.text(850, 244, "at a node of tubes, not mid-span", anchor="middle", size=13)
    d.text(850, 282, "A: on the axle or upright, near", anchor="middle", size=13)
    d.text(850, 300, "the wheel and the steering axis", anchor="middle", size=13)
    d.text(700, 470, "front", anchor="middle", size=13, colour=SOFT)
    d.text(1000, 470, "rear", anchor="middle", size=13, colour=SOFT)
    d.text(610, 520, "Logger: in its box on rubber, anywhere dry.", size=13)
    d.text(610, 540, "Sensors: never on rubber, foam or cable ties.", size=13)
    return d


def checklist() -> Drawing:
    """The sheet to print, A4."""
    d = Drawing(840, 1188, "Commissioning the logger")
    d.text(60, 84, "Commissioning the logger", size=28, bold=True)
    d.text(
        60, 116, "Vehicle ____________________   Logger no. ______   Date ______________", size=15
    )
    y = 162.0
    d.text(60, y, "1  By hand", size=19, bold=True)
    for title, words in BY_HAND:
        y += 32
        d.box(62, y - 14, 16, 16)
        d.text(92, y, title, bold=True)
        d.text(226, y, words, size=13)
    y += 52
    d.text(60, y, "2  A session at rest, one minute", size=19, bold=True)
    for line in THE_SESSION:
        y += 27
        d.text(92, y, line)
    y += 52
    d.text(60, y, "3  wheelhop health HOP_____.HOP --checklist", size=19, bold=True)
    for title, words in JUDGED:
        y += 32
        d.box(62, y - 14, 16, 16)
        d.text(92, y, title, bold=True)
        d.text(226, y, words, size=13)
    y += 34
    d.text(92, y, "All seven must say pass. Otherwise the line below says what to do.", size=13)
    y += 52
    d.text(60, y, "4  First drive, ten minutes, then", size=19, bold=True)
    for title, words in (
        (
            "health",
            "wheelhop health of three drives together: polarity, exchange, mounts, clipping",
        ),
        ("info", "wheelhop info: nothing missing, stall and memory well below their limits"),
        ("bolts", "paint marks unbroken, cables unchafed, plugs dry"),
    ):
        y += 32
        d.box(62, y - 14, 16, 16)
        d.text(92, y, title, bold=True)
        d.text(226, y, words, size=13)
    d.text(60, 1140, "Signed ____________________", size=15)
    return d


DRAWN = {"channel.svg": channel, "mount.svg": mount, "checklist.svg": checklist}


def main() -> None:
    """Write all drawings."""
    DRAWINGS.mkdir(exist_ok=True)
    for name, draw in DRAWN.items():
        (DRAWINGS / name).write_text(draw().svg(), encoding="utf-8")


if __name__ == "__main__":
    main()

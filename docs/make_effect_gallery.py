"""Bring docs/effects.md up to date with the effects' classes, and draw their pictures.

Run it from anywhere: python docs/make_effect_gallery.py

What stands between the markers in docs/effects.md is written by this script; what an effect's
signature looks like and what it can be confused with is written by hand, after the markers. A new
effect gets a section without these.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path

from effect_angles import angles_picture
from effect_on_rig import COMPONENT, forms_picture, picture_on_rig
from effect_pictures import picture
from effect_stage import Stage, set_stage
from PIL import Image

from wheelhop.effects import Effect, Parameter, Shape, Switch, load_effects

DOCS = Path(__file__).parent
EXAMPLE = DOCS.parent / "examples/clean"
PAGE = DOCS / "effects.md"
END = "<!-- end -->"
ACROSS = 4
"""Thumbnails in a row."""


def main() -> None:
    """Text first, then one picture per effect, then their angles."""
    effects, stage = load_effects(), set_stage(EXAMPLE)
    text = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    PAGE.write_text(updated(text, effects, stage), encoding="utf-8")
    (DOCS / "effects").mkdir(exist_ok=True)
    for effect in effects.values():
        form = first_form(effect, stage)
        figure = picture(form, stage) if effect.on_vehicle else picture_on_rig(form)
        figure.savefig(DOCS / "effects" / f"{effect.id}.png", dpi=110)
        print(effect.id, flush=True)
        thumbnail(effect.id)
    friction = effects["dry-friction"]
    forms = [(c, friction.with_choice(c)) for c in friction.choices(())]
    forms_picture(forms).savefig(DOCS / "dry-friction-forms.png", dpi=110)
    angles_picture(effects, stage, EXAMPLE).savefig(DOCS / "effects/angles.png", dpi=110)


def first_form(effect: Effect, stage: Stage) -> Effect:
    """The effect in the first of its forms."""
    choice = effect.choices(stage.campaign.channels)[0]
    return effect.with_choice(choice) if choice else effect


def updated(text: str, effects: Mapping[str, Effect], stage: Stage) -> str:
    """The page with every block between markers written anew; missing ones are added."""
    text = _with_block(text, "index", index(effects), heading="")
    text = _with_block(text, "thumbnails", thumbnails(effects), heading="\n## At a glance\n\n")
    for effect in effects.values():
        text = _with_block(text, effect.id, section(effect, stage), f"\n## `{effect.id}`\n\n")
    return text


def _with_block(text: str, name: str, block: str, heading: str) -> str:
    begin = f"<!-- from the classes: {name} -->"
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(END)}", re.DOTALL)
    block = f"{begin}\n{block}\n{END}"
    if not pattern.search(text):
        return f"{text}{heading}{block}\n"
    return pattern.sub(lambda _: block, text, count=1)


def index(effects: Mapping[str, Effect]) -> str:
    """One line per effect."""
    rows = [f"| [`{e.id}`](#{e.id}) | {e.place} | {e.title} |" for e in effects.values()]
    return "\n".join(["| id | place | what it is |", "| --- | --- | --- |", *rows])


def thumbnail(effect_id: str) -> None:
    """The first panel of an effect's picture, small, for the page's head."""
    with Image.open(DOCS / "effects" / f"{effect_id}.png") as whole:
        width, height = whole.size
        panel = whole.crop((0, 0, round(0.272 * width), round(0.9 * height)))
    panel.thumbnail((220, 220))
    (DOCS / "effects/small").mkdir(exist_ok=True)
    panel.convert("RGB").convert("P", palette=Image.Palette.ADAPTIVE, colors=32).save(
        DOCS / "effects/small" / f"{effect_id}.png", optimize=True
    )


def thumbnails(effects: Mapping[str, Effect]) -> str:
    """Four in a row, each leading to its section."""
    cells = [
        f"[![{e.id}](effects/small/{e.id}.png)](#{e.id})<br>`{e.id}`" for e in effects.values()
    ]
    cells += [""] * (-len(cells) % ACROSS)
    rows = [cells[i : i + ACROSS] for i in range(0, len(cells), ACROSS)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([f"|{' |' * ACROSS}", f"|{' --- |' * ACROSS}", *lines])


def section(effect: Effect, stage: Stage) -> str:
    """What the class says of itself."""
    what = (type(effect).__doc__ or "").strip().split("\n\n")[0].replace("\n    ", " ")
    step = ""
    if effect.longest_step_s < Effect.longest_step_s:
        step = f" Integrated in steps of {1e3 * effect.longest_step_s:g} ms or less."
    where = "" if effect.on_vehicle else ", looked for on rigs alone"
    road = " Not where the track is unknown." if effect.needs_road else ""
    return "\n".join(
        [
            f"{sentence(effect.title)} {what} Place: **{effect.place}**{where}.{road}{step}\n",
            f"```math\n{effect.equation}\n```\n",
            f"Source: {sentence(effect.source)}\n",
            *parameter_table(effect, stage),
            f"![Signature of {effect.id}](effects/{effect.id}.png)",
        ]
    )


def parameter_table(effect: Effect, stage: Stage) -> Iterator[str]:
    """Every parameter of every form; a numbered series of what is free in each run once."""
    channels = stage.campaign.channels
    values = stage.vehicle.values if effect.on_vehicle else COMPONENT
    settings = [stage.setting(run) for run in stage.campaign.runs]
    rows = []
    for choice in effect.choices(channels):
        form = effect.with_choice(choice) if choice else effect
        rows += [
            row(p.name, p.unit, p.meaning, believed(p))
            for p in form.parameters_for(values, channels)
        ]
        series: dict[tuple[str, str, str], list[float]] = {}
        for p in (p for setting in settings for p in form.per_run(setting)):
            series.setdefault((re.sub(r"_\d+_", "_j_", p.name), p.unit, p.meaning), []).append(
                p.scale
            )
        rows += [row(*key, f"free in each run, {spread(scales)}") for key, scales in series.items()]
    example = "vehicle" if effect.on_vehicle else "rig"
    yield f"| parameter | unit | meaning | on the example {example} |"
    yield "| --- | --- | --- | --- |"
    yield from dict.fromkeys(rows)
    forms = [choice for choice in effect.choices(channels) if choice]
    if forms:
        usual = [c for c in forms if effect.with_choice(c).applies_to(stage.vehicle.values)]
        on_rig = [choice for choice in forms if choice not in usual]
        more = f" On a rig also {shortened(on_rig)}." if on_rig and usual else ""
        yield f"\nForms: {shortened(usual or forms)}.{more} Screening tries each."
    yield ""


def row(name: str, *cells: str) -> str:
    """A line of the table."""
    return f"| `{name}` | {' | '.join(cells)} |"


def believed(p: Parameter) -> str:
    """At which values a parameter is tried, and its bounds."""
    if isinstance(p, Switch):
        return "on or off"
    words = [f"clearly visible at {number(p.typical)}"]
    if isinstance(p, Shape):
        words = [f"tried at {', '.join(number(x) for x in p.starts)}"]
        if p.believed is not None:
            words += [f"believed to be {number(p.believed)} ± {number(p.scale)}"]
    words += [f"{sign} {number(x)}" for sign, x in (("≥", p.lower), ("≤", p.upper)) if isfinite(x)]
    return "; ".join(words)


def spread(scales: Sequence[float]) -> str:
    """How large it is expected to be."""
    low, high = number(min(scales)), number(max(scales))
    return f"±{low}" if low == high else f"±{low} to ±{high}"


def number(value: float) -> str:
    """Three significant digits, without exponent."""
    return f"{float(f'{value:.3g}'):.10g}"


def shortened(forms: Sequence[str]) -> str:
    """The first few of a long list."""
    words = [f"`{form}`" for form in forms]
    return ", ".join(words if len(words) <= 9 else [*words[:3], "…", *words[-2:]])


def sentence(text: str) -> str:
    """With a capital letter and a full stop."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."


if __name__ == "__main__":
    main()

"""The vehicle: its numbers, where each one is, what holds it, and what other ones would make of its
ride."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from nicegui import run, ui
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.files.words import interval, label_of, unit_of
from wheelhop.workbench.charts import AFTER, MEASURED, Line, Panel, chart
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.shown import Number
from wheelhop.workbench.tables import Column, Sortable
from wheelhop.workbench.vehicle_drawing import SYMBOLS, drawing
from wheelhop.workbench.view import Looking, Words, html

SLIDERS = {
    "spring": ("suspension.front.stiffness_N_m", "suspension.rear.stiffness_N_m"),
    "damper": ("suspension.front.damping_N_s_m", "suspension.rear.damping_N_s_m"),
    "tyre": ("wheel.front.tyre_stiffness_N_m", "wheel.rear.tyre_stiffness_N_m"),
    "unsprung mass": ("wheel.front.unsprung_mass_kg", "wheel.rear.unsprung_mass_kg"),
    "sprung mass": ("body.mass_kg", "body.pitch_inertia_kg_m2", "body.roll_inertia_kg_m2"),
}
"""What a slider scales, front and rear alike."""
SPEED_KMPH = (3, 60, 15)  # least, most, first
FREQUENCY_HZ = np.geomspace(0.3, 30.0, 240)
HELD = 0.5  # of what the belief leaves open: a number known so much better is held by the data
WORDS = (
    "<p class='soft'>The sliders scale the numbers as they are fitted, or believed while"
    " nothing is. The linear vehicle, effects left out. Above: height of the body over height of"
    " the ground, all wheels alike. Below: acceleration of the body on waves 1 mm high, met at the"
    " speed chosen: the rear wheels come later.</p>"
)


class VehicleView:
    """A drawing, a table of numbers, and sliders with the ride they would give."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        self._nominal: dict[str, float] = {}
        self._believed: dict[str, float] = {}
        self._sliders: dict[str, Any] = {}
        with ui.element("div").classes("bench-split wide"):
            with ui.element("div"):
                html(drawing())
                self._table = Sortable(COLUMNS, "number")
            with ui.element("div"):
                Words("What if", "h2")
                for name in SLIDERS:
                    self._sliders[name] = self._slider(name, -2, 2, 0, 0.05, _times)
                low, high, first = SPEED_KMPH
                self._speed = self._slider("speed", low, high, first, 0.5, _kmph)
                ui.button("Back to × 1", on_click=self._reset).props("flat dense no-caps")
                self._chart = ui.echart({}).classes("bench-ride")
                html(WORDS)

    def show(self) -> None:
        """Bring it up to date."""
        rung = self._desk.rungs[-1] if self._desk.rungs else None
        if self._seen is None or rung is not self._seen:
            first, self._seen = self._seen is None, rung or self
            ui.timer(0.01, self._begin if first else self._renew, once=True)

    def _slider(
        self, name: str, low: float, high: float, value: float, step: float, words: Any
    ) -> Any:
        with ui.row().classes("bench-slider"):
            ui.label(name)
            slider = ui.slider(min=low, max=high, step=step, value=value)
            slider.props(f'aria-label="{name}"')
            shown = ui.label(words(value))
        slider.on_value_change(lambda event: shown.set_text(words(event.value)))
        slider.on_value_change(self._draw)
        return slider

    async def _begin(self) -> None:
        try:
            found = await run.io_bound(read, self._desk.campaign)
        except CampaignError as error:
            self._desk.say(str(error))
            return
        if found is None:  # the server is going down
            return
        await run.io_bound(ride, found[0], None)  # what computes is loaded outside the page's loop
        self._nominal, self._believed = found
        await self._renew()

    async def _renew(self) -> None:
        """Show the numbers as they are fitted by now, and their ride."""
        self._table.show(table(self._nominal, self._believed, self._numbers))
        await self._draw()

    @property
    def _numbers(self) -> Mapping[str, Number]:
        return self._desk.rungs[-1].numbers if self._desk.rungs else {}

    def _reset(self) -> None:
        for slider in self._sliders.values():
            slider.set_value(0)

    async def _draw(self) -> None:
        if not self._nominal:
            return
        before = fitted(self._nominal, self._numbers)
        changed = dict(before)
        for name, slider in self._sliders.items():
            for key in changed.keys() & set(SLIDERS[name]):
                changed[key] *= 2.0**slider.value
        speed = self._speed.value / 3.6
        start = "fitted" if self._numbers else "nominal"
        both = ((start, before, MEASURED, 2.2), ("with these", changed, AFTER, 1.2))
        felt = 1e-3 * (2 * np.pi * FREQUENCY_HZ) ** 2
        upper = [Line(n, FREQUENCY_HZ, ride(v, None), c, w) for n, v, c, w in both]
        lower = [Line(n, FREQUENCY_HZ, felt * ride(v, speed), c, w) for n, v, c, w in both]
        panels = [
            Panel("", "transmissibility, heave", upper, log=True),
            Panel("frequency, Hz", "body, m/s² per mm", lower, log=True),
        ]
        self._chart.options.update(chart(panels, (50, 50), (0, 1)))
        self._chart.update()


def read(campaign: Campaign) -> tuple[dict[str, float], dict[str, float]]:
    """The nominal numbers and their standard deviations; raises CampaignError."""
    from wheelhop.vehicle import read_vehicle

    vehicle = read_vehicle(campaign.vehicle_file)
    return dict(vehicle.values), dict(vehicle.uncertainty)


def fitted(nominal: Mapping[str, float], numbers: Mapping[str, Number]) -> dict[str, float]:
    """The vehicle's numbers: as fitted where they were, else nominal."""
    return {k: numbers[k].fitted if k in numbers else value for k, value in nominal.items()}


def table(
    nominal: Mapping[str, float], believed: Mapping[str, float], numbers: Mapping[str, Number]
) -> list[dict[str, str | bool]]:
    """Every number: its sign in the drawing, nominal, as fitted, and what holds it."""
    return [
        {
            "number": label_of(key),
            "sign": re.sub("<[^>]+>", "", SYMBOLS.get(key, "")),
            "nominal": interval(value, believed.get(key, 0.0)),
            **_fitted(numbers.get(key)),
            "unit": unit_of(key),
        }
        for key, value in nominal.items()
    ]


def _fitted(number: Number | None) -> dict[str, str]:
    if number is None:
        return {"fitted": "", "held": ""}
    held = "data" if number.known < HELD * number.believed else "belief"
    return {"fitted": interval(number.fitted, number.known), "held": held}


COLUMNS = (
    Column("number", "number"),
    Column("sign", "sign", tip="in the drawing above"),
    Column("nominal", "nominal ± 2 sd", True),
    Column("fitted", "fitted ± 2 sd", True),
    Column("held", "held by", tip="data: known better than half its nominal uncertainty"),
    Column("unit", "unit"),
)


def ride(values: Mapping[str, float], speed_m_s: float | None) -> NDArray[np.float64]:
    """Heave of the body over heave of the ground at `FREQUENCY_HZ`."""
    from wheelhop.simulate.heave import heave_transmissibility

    return heave_transmissibility(values, FREQUENCY_HZ, speed_m_s)


def _times(value: float) -> str:
    return f"× {2**value:.2f}"


def _kmph(value: float) -> str:
    return f"{value:g} km/h"

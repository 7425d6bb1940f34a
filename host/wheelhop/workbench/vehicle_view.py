"""The vehicle: its nominal numbers, and what other ones would make of its ride."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
from nicegui import run, ui
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, CampaignError, ComponentCampaign
from wheelhop.files.words import interval, label_of, unit_of
from wheelhop.workbench.charts import AFTER, MEASURED, Line, Panel, chart
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.view import Looking

SLIDERS = {
    "spring": ("suspension.front.stiffness_N_m", "suspension.rear.stiffness_N_m"),
    "damper": ("suspension.front.damping_N_s_m", "suspension.rear.damping_N_s_m"),
    "tyre": ("wheel.front.tyre_stiffness_N_m", "wheel.rear.tyre_stiffness_N_m"),
    "unsprung mass": ("wheel.front.unsprung_mass_kg", "wheel.rear.unsprung_mass_kg"),
    "sprung mass": ("body.mass_kg", "body.pitch_inertia_kg_m2", "body.roll_inertia_kg_m2"),
}
"""What a slider scales, front and rear alike."""
ENDS = (0.25, 4.0)
FREQUENCY_HZ = np.geomspace(0.3, 30.0, 240)


class VehicleView:
    """A table of numbers, and sliders with the ride they would give."""

    def __init__(self, desk: Desk, looking: Looking) -> None:
        self._desk = desk
        self._seen: object = None
        self._nominal: dict[str, float] = {}
        self._sliders: dict[str, Any] = {}
        if isinstance(desk.campaign, ComponentCampaign):
            ui.label("A component on a rig has no ride; its numbers stand under “The model”.")
            return
        with ui.element("div").classes("bench-split wide"):
            self._table = ui.html("", sanitize=False)
            with ui.element("div"):
                ui.html("<h2>What if</h2>", sanitize=False)
                for name in SLIDERS:
                    with ui.row().classes("bench-slider"):
                        ui.label(name)
                        slider = ui.slider(min=-2, max=2, step=0.05, value=0)
                        slider.props(f'aria-label="{name}, powers of two"')
                        value = ui.label("× 1.00")
                        slider.on_value_change(
                            lambda event, value=value: value.set_text(f"× {2**event.value:.2f}")
                        )
                        slider.on_value_change(self._draw)
                        self._sliders[name] = slider
                ui.button("Back to nominal", on_click=self._reset).props("flat dense no-caps")
                self._chart = ui.echart({}).classes("bench-chart")
                ui.html(
                    "<p class='soft'>Heave of the body over heave of the ground, all wheels alike:"
                    " the linear vehicle, effects left out.</p>",
                    sanitize=False,
                )

    def show(self) -> None:
        """Bring it up to date."""
        if self._sliders and self._seen is None:
            self._seen = True
            ui.timer(0.01, self._begin, once=True)

    async def _begin(self) -> None:
        try:
            found = await run.io_bound(read, self._desk.campaign)
        except CampaignError as error:
            self._desk.say(str(error))
            return
        if found is None:  # the server is going down
            return
        await run.io_bound(ride, found[0])  # what computes is loaded outside the page's loop
        self._nominal, table = found
        self._table.set_content(table)
        await self._draw()

    def _reset(self) -> None:
        for slider in self._sliders.values():
            slider.set_value(0)

    async def _draw(self) -> None:
        if not self._nominal:
            return
        changed = dict(self._nominal)
        for name, slider in self._sliders.items():
            for key in changed.keys() & set(SLIDERS[name]):
                changed[key] *= 2.0**slider.value
        nominal, now = ride(self._nominal), ride(changed)
        lines = [
            Line("nominal", FREQUENCY_HZ, nominal, MEASURED, 2.2),
            Line("with these numbers", FREQUENCY_HZ, now, AFTER),
        ]
        panel = Panel("frequency, Hz", "transmissibility, heave", lines, log=True)
        self._chart.options.update(chart([panel], (100,), (0,)))
        self._chart.update()


def read(campaign: Campaign) -> tuple[dict[str, float], str]:
    """The nominal numbers, and a table of them; raises CampaignError."""
    from wheelhop.vehicle import read_vehicle

    vehicle = read_vehicle(campaign.vehicle_file)
    rows = "".join(
        f"<tr><td>{escape(label_of(key))}</td>"
        f'<td class="r">{escape(interval(value, vehicle.uncertainty[key]))}</td>'
        f"<td>{escape(unit_of(key))}</td></tr>"
        for key, value in vehicle.values.items()
    )
    head = '<tr><th></th><th class="r">nominal ± 2 sd</th><th>unit</th></tr>'
    return dict(vehicle.values), (
        f"<h2>{escape(vehicle.name)}</h2><table><thead>{head}</thead><tbody>{rows}</tbody></table>"
    )


def ride(values: dict[str, float]) -> NDArray[np.float64]:
    """Transmissibility of heave: body over ground, every wheel lifted alike."""
    from wheelhop.simulate import frequency_response
    from wheelhop.vehicle import Body, baseline, body_inertia

    parts = baseline(values, (), "road")
    parts.add_output(((1.0, Body(0.0, 0.0)),))
    response = frequency_response(parts.system(body_inertia(values)), FREQUENCY_HZ)
    heave = response[:, 0, :].sum(axis=1) / -((2 * np.pi * FREQUENCY_HZ) ** 2)
    return np.asarray(np.abs(heave))

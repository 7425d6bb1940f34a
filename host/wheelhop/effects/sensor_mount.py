"""A channel's sensor moves against the point it should measure: its mount resonates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.campaign import Channel
from wheelhop.effects.base import (
    Array,
    Becomes,
    OwnValues,
    Probe,
    RunSetting,
    Values,
)
from wheelhop.effects.parameters import Amplitude, Parameter, Shape, Switch
from wheelhop.effects.special import Ringing
from wheelhop.effects.transfer import on_a_mount, ringing, transferred

FREQUENCIES_HZ = np.geomspace(8.0, 120.0, 80)
DAMPING_RATIOS = (0.02, 0.05, 0.1, 0.2, 0.4)

USUAL_DAMPING = 0.1
"""Start for a mount whose resonance lies beyond what the record can show."""

UNSEEN_HZ = (10.0, 17.0, 30.0, 55.0)
"""Starts for a channel that drives the model, and is compared with nothing. What its mount does to
the body grows with 1/f² and has no resonance, 1/H = 1 - (ω/ω_r)²/(1 + 2ζiω/ω_r): from the nearest
of these the fit finds its way."""

STRUCK = 3.0
"""A mount may still ring with so many m/s², one standard deviation, from what came before."""


BEYOND = 30.0
"""Just before and after its record, a channel that drives the model may read so many m/s² more or
less than its point reflection: as much as a shaken mount reads."""


class SensorMount(Ringing):
    """The sensor's mass on the mount's spring and damper: the sensor reads its own motion. Of what
    shook it before the record only the run-up is known, so how it rings then is free in each run;
    and so is, where the channel drives the model, what it read just before the record and after.
    """

    id = "sensor-mount"
    place = "sensor"
    becomes = (Becomes("freq_hz", "upper", "a sensor that sits tight", "it rings beyond the band"),)
    title = "a channel's mount resonates"
    equation = (
        r"y = H a,\quad H = \frac{1 + 2\zeta i\omega/\omega_r}"
        r"{1 + 2\zeta i\omega/\omega_r - \omega^2/\omega_r^2},\quad \omega_r = 2\pi f;\quad"
        r"\text{and } e^{-\zeta\omega_r t}\,(r_c \cos\omega_d t + r_s \sin\omega_d t),"
        r"\quad \omega_d = \omega_r\sqrt{1 - \zeta^2}"
    )
    source = (
        "mechanical mounting of accelerometers, ISO 5348:2021; transmissibility of a one-mass"
        " system, e.g. S. Rao, Mechanical Vibrations, eq. 3.68"
    )

    def __init__(self, channel: str = "") -> None:
        self.channel = channel

    def choices(self, channels: Sequence[Channel]) -> Sequence[str]:
        """Any accelerometer: a mount that gives way resonates with its mass."""
        return [c.name for c in channels if c.is_acceleration]

    def with_choice(self, choice: str) -> SensorMount:
        """This fault in the channel `choice`."""
        return SensorMount(choice)

    def parameters_for(self, vehicle: Values, channels: Sequence[Channel]) -> Sequence[Parameter]:
        """On or off, and the mount's resonance; it begins where `shape_starts` finds it."""
        return (
            Switch("loose", "1", "1: the mount gives way"),
            Shape(
                "freq_hz",
                "Hz",
                "resonance of the sensor on its mount",
                20.0,
                lower=5.0,
                upper=300.0,
                starts=(35.0,),
            ),
            Shape("zeta", "1", "its damping ratio", 0.1, lower=0.005, upper=0.98, starts=(0.1,)),
        )

    def per_run(self, run: RunSetting) -> Sequence[Parameter]:
        """How the mount rings when the record begins, beyond what the run-up makes it do; and the
        jumps at the ends of a record that is set right. These are no amplitudes: of a mount that
        sits tight nothing beyond the record matters."""
        ringing = (
            Amplitude("ring_cos_m_s2", "m/s²", "ringing when the record begins", STRUCK),
            Amplitude("ring_sin_m_s2", "m/s²", "and a quarter of a turn later", STRUCK),
        )
        if run.on_road:
            return ringing
        return (
            *ringing,
            Shape("before_m_s2", "m/s²", "reading before the record", BEYOND, starts=(0.0,)),
            Shape("after_m_s2", "m/s²", "and after it", BEYOND, starts=(0.0,)),
        )

    def shape_starts(self, probe: Probe) -> Sequence[Values]:
        """The resonance that turns what the model says of the channel into what was measured; where
        it says nothing, as of measured axles, several."""
        column = [c.name for c in probe.channels].index(self.channel)
        frequency, zeta = (
            a.ravel() for a in np.meshgrid(FREQUENCIES_HZ, DAMPING_RATIOS, indexing="ij")
        )
        misfit, nyquist_hz = np.zeros(len(frequency)), np.inf
        for setting in probe.settings:
            time = probe.time_s(setting.run_id)
            step = (time[-1] - time[0]) / (len(time) - 1)
            nyquist_hz = min(nyquist_hz, 0.5 / step)
            measured = fft.rfft(probe.measured(setting.run_id)[:, column])
            modelled = fft.rfft(probe.modelled(setting.run_id, {})[:, column])
            factor = _transmissibility(fft.rfftfreq(len(time), step), frequency, zeta)
            misfit += np.sum(np.abs(measured[:, None] - factor * modelled[:, None]) ** 2, axis=0)
        if not misfit.any():
            return [{"freq_hz": f, "zeta": USUAL_DAMPING} for f in UNSEEN_HZ]
        best = int(np.argmin(misfit))
        damping = zeta[best] if frequency[best] < nyquist_hz else USUAL_DAMPING
        return [{"freq_hz": float(frequency[best]), "zeta": float(damping)}]

    def summary(self, runs: Sequence[OwnValues]) -> dict[str, float]:
        """How much the mount still rings when records begin, root mean square over the runs."""
        power = [_parts(theta)[0] ** 2 + _parts(theta)[1] ** 2 for _, theta, _ in runs]
        return {"ring_m_s2": float(np.sqrt(np.mean(power)))} if runs else {}

    def sense(
        self, theta: Values, acceleration: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """The motion of the sensor, by the share `loose`."""
        i = self._column(channels)
        foot, changed = acceleration[:, i], np.array(acceleration)
        sensor = on_a_mount(foot, rate_hz, theta["freq_hz"], theta["zeta"])
        changed[:, i] += theta["loose"] * (sensor - foot)
        return changed

    def lingering(self, theta: Values, since_s: Array, channels: Sequence[Channel]) -> Array | None:
        """The free decay of what shook the mount before."""
        cosine, sine = _parts(theta)
        if cosine == sine == 0.0:
            return None
        ring = np.zeros((len(since_s), len(channels)))
        amplitude = complex(cosine, -sine)
        ring[:, self._column(channels)] = ringing(
            amplitude, since_s, theta["freq_hz"], theta["zeta"]
        )
        return ring

    def restore(
        self, theta: Values, measured: Array, channels: Sequence[Channel], rate_hz: float
    ) -> Array:
        """The motion of the point it sits on. A mount that rings by itself leaves no trace there:
        its free motion is where the inverse of H is zero."""
        i = self._column(channels)
        shape = np.array([theta["freq_hz"]]), np.array([theta["zeta"]])

        def factor(frequency_hz: Array) -> NDArray[np.complex128]:
            return 1.0 / (1.0 + theta["loose"] * (_transmissibility(frequency_hz, *shape) - 1.0))

        changed = np.array(measured)
        jumps = theta.get("before_m_s2", 0.0), theta.get("after_m_s2", 0.0)
        changed[:, i : i + 1] = transferred(measured[:, i : i + 1], rate_hz, factor, jumps)
        return changed

    def _column(self, channels: Sequence[Channel]) -> int:
        return [c.name for c in channels].index(self.channel)


def _parts(theta: Values) -> tuple[float, float]:
    """Cosine and sine part of what rings by itself, m/s²."""
    return theta.get("ring_cos_m_s2", 0.0), theta.get("ring_sin_m_s2", 0.0)


def _transmissibility(
    frequency_hz: Array, resonance_hz: Array, zeta: Array
) -> NDArray[np.complex128]:
    """H at each frequency (f,) for each mount (m,): (f, m)."""
    ratio = frequency_hz[:, None] / resonance_hz
    damper = 1.0 + 2j * zeta * ratio
    return np.asarray(damper / (damper - ratio**2))

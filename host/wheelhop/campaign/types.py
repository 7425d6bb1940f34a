"""What a campaign is once it has left the disk: one vehicle, one instrument set-up, many runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.averaging import Averaging
from wheelhop.campaign.course import Course
from wheelhop.campaign.driven import Driven
from wheelhop.campaign.low_pass import LowPass
from wheelhop.files import InputError, dotted, shown
from wheelhop.files.words import ending_of
from wheelhop.logger.recording import Channel as Recorded
from wheelhop.logger.recording import Recording

if TYPE_CHECKING:
    from pandas import DataFrame

AXLE_POINTS = ("A1", "A2", "A3", "A4")
BODY_POINTS = ("B1", "B2", "B3", "B4")
STRUT_POINTS = ("S1", "S2", "S3", "S4")
ACCELERATION = "acceleration"
Role = Literal["fit", "validate"]
RigDrive = Literal["displacement", "force"]
"""What a rig imposes."""


class CampaignError(InputError):
    """The campaign's files, or what was asked of them."""


@dataclass(frozen=True)
class Channel:
    """One measured signal: what of a vehicle (`wheelhop.campaign.channels`), or of a rig.

    `point` is "A1".."A4" (wheel axles), "B1".."B4" (suspension-to-body points), "body-xy" (on the
    sprung body at `x_m` ahead and `y_m` to the left of its centre of mass) or "body" (on the
    sprung body, position unknown) for a vertical acceleration, "S1".."S4" (struts) for travel or
    force, "pitch" or "roll" for a rate, or "rig". 1 front left, 2 front right, 3 rear left, 4 rear
    right. A channel of a strut shows `per_wheel` times what the strut does at the wheel. An
    acceleration along another `axis` than z, up, is known alone: x forward, y to the left.

    `noise_rms` is the noise in band that is stated of this channel or its quantity, in `unit`,
    None where the campaign's holds, or none is stated. `noise_scale` is its noise over the
    campaign's: records are compared per that, so that every channel counts in units of its noise
    (`wheelhop.compare.weights`).

    `scale_uncertainty` is the standard uncertainty of what the channel shows, relative, as its
    calibration states it, `gain_uncertainty` the gain's share in it; `corner_hz` that of the
    sensor's low-pass, which was undone, `corner_uncertainty` how well it is known, relative. 0 if
    nothing is stated.
    """

    name: str
    point: str
    x_m: float | None = None
    y_m: float | None = None
    quantity: str = "acceleration"
    unit: str = "m/s²"
    per_wheel: float = 1.0
    noise_rms: float | None = None
    noise_scale: float = 1.0
    scale_uncertainty: float = 0.0
    gain_uncertainty: float = 0.0
    corner_hz: float = 0.0
    corner_uncertainty: float = 0.0
    axis: str = "z"

    @property
    def corner(self) -> int | None:
        """0..3 for the points 1..4 of axle, body or strut, None for any other place."""
        named = self.point in (*AXLE_POINTS, *BODY_POINTS, *STRUT_POINTS)
        return int(self.point[1]) - 1 if named else None

    @property
    def key(self) -> str:
        """What the names of its numbers in a model begin with, before another dot:
        "channel.imu"."""
        return f"channel.{dotted(self.name)}"

    @property
    def is_axle(self) -> bool:
        """Whether it is an acceleration of a wheel axle."""
        return self.point in AXLE_POINTS

    @property
    def is_body_point(self) -> bool:
        """Whether it is an acceleration of a suspension-to-body point."""
        return self.point in BODY_POINTS

    @property
    def is_on_body(self) -> bool:
        """Whether it shows how the sprung body moves, whatever its struts do."""
        return self.quantity == "rate" or (self.is_acceleration and not self.is_axle)

    @property
    def is_acceleration(self) -> bool:
        """Whether it is a vertical acceleration, wherever it is measured."""
        return self.quantity == ACCELERATION


@dataclass(frozen=True)
class TrackSpec:
    """The road of one run as the user describes it, in SI, every default filled in.

    `values` holds, as far as `kind` has them: amplitude_m, pitch_m, angle_rad, width_m,
    lateral_offset_m, pitch_start_m, pitch_end_m, length_m, height_m, unevenness_m3, waviness,
    seed, side ("both", "left" or "right") and file (an absolute path).
    """

    kind: str
    values: Mapping[str, float | str]


@dataclass(frozen=True, eq=False)
class Run:
    """One recording and how it was driven.

    `time_s` is (n,), uniform at the campaign's sample rate; `record` is (n, n_channels), columns
    in the order of the campaign's channels and in their units. Both arrays are read-only.
    `speed_m_s` is nominal: the driver held it by hand, or drove a `course`, whose speeds it stands
    for: all of them are faster or slower with it; where a channel recorded the speed on a known
    track, it is the mean of what was `driven`. `start_m` is where the front axle was at time 0, and
    its standard uncertainty, None: nothing is said. `role` is "fit" or "validate". `known` holds
    what was recorded and is not compared (n,), by the names of the campaign's `known` channels.
    `setting` names what of the vehicle was set for it, "" if nothing is said.
    """

    id: str
    file: Path
    role: str
    speed_m_s: float
    track: TrackSpec
    time_s: NDArray[np.float64]
    record: NDArray[np.float64]

    course: Course | None = field(default=None, kw_only=True)
    driven: Driven | None = field(default=None, kw_only=True)
    start_m: tuple[float, float] | None = field(default=None, kw_only=True)
    known: Mapping[str, NDArray[np.float64]] = field(default_factory=dict, kw_only=True)
    setting: str = field(default="", kw_only=True)

    def __repr__(self) -> str:
        how = f"{self.track.kind}, {self.speed_m_s * 3.6:.3g} km/h"
        return f"<Run {self.id}: {self.role}, {how}, {len(self.time_s)} samples>"


@dataclass(frozen=True, eq=False, repr=False)
class RigRun(Run):
    """One recording of a component on a rig; it stands still, on no track.

    `displacement`, `force` and, if recorded, `velocity` are (n,), m, N and m/s, read-only; the rig
    imposes `drive`, and `record` holds the other one. `inputs` are other columns (n,) that laws may
    depend on, by name ("input_coil_V").
    """

    drive: RigDrive
    displacement: NDArray[np.float64]
    force: NDArray[np.float64]
    velocity: NDArray[np.float64] | None
    inputs: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __repr__(self) -> str:
        how = f"{self.drive} imposed"
        return f"<RigRun {self.id}: {self.role}, {how}, {len(self.time_s)} samples>"


@dataclass(frozen=True, eq=False)
class Campaign:
    """One vehicle, one instrument set-up and the runs recorded with them.

    `averaging_s` is the window over which each recorded sample is a mean (0: ideal sampling), and
    so many recorded samples in a row were made one of by their mean (`thinned`): `means`;
    `low_pass` is what the recorder filtered every channel with before, None: nothing is stated;
    `noise_rms` the noise floor of one channel of the `leading` quantity inside `band_hz`, None when
    it is not known; `noise_key` is its name in campaign.toml.
    `channels` stand in the column order of the first run's recording, without those that are
    `known`: read and kept, but neither compared nor used. `factors` are those that columns of the
    recordings were multiplied by.
    """

    folder: Path
    title: str
    vehicle_file: Path
    sample_rate_hz: float
    band_hz: tuple[float, float]
    averaging_s: float
    noise_rms: float | None
    channels: tuple[Channel, ...]
    runs: tuple[Run, ...]
    means: int = field(default=1, kw_only=True)
    low_pass: LowPass | None = field(default=None, kw_only=True)
    known: tuple[Channel, ...] = field(default=(), kw_only=True)
    factors: Mapping[str, float] = field(default_factory=dict, kw_only=True)

    @property
    def leading(self) -> Channel:
        """The first acceleration, or the first channel where there is none: every channel counts in
        units of its noise over that of this one's quantity."""
        return next((c for c in self.channels if c.is_acceleration), self.channels[0])

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is measured, each quantity once, the leading one first."""
        every = (self.leading.quantity, *(c.quantity for c in self.channels))
        return tuple(dict.fromkeys(every))

    @property
    def unstated(self) -> tuple[Channel, ...]:
        """The channels whose noise is stated neither of them nor of their quantity."""
        leading = self.leading.quantity
        return tuple(
            c
            for c in self.channels
            if c.noise_rms is None and not (c.quantity == leading and self.noise_rms is not None)
        )

    @property
    def noise_scale(self) -> NDArray[np.float64]:
        """Noise of every channel (c,) over the leading quantity's, in their units."""
        return np.array([channel.noise_scale for channel in self.channels])

    @property
    def averaging(self) -> Averaging:
        """What each sample is the mean of."""
        return Averaging(self.averaging_s, self.means, 1.0 / (self.means * self.sample_rate_hz))

    @property
    def sampling(self) -> str:
        """The sample rate and what each sample is, in words."""
        said = f"{self.sample_rate_hz:g} Hz"
        if self.averaging_s:
            said += f", each the mean over {self.averaging_s * 1e3:g} ms"
        return said if self.low_pass is None else f"{said}, after a {self.low_pass}"

    def recorded(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
        """What the recorder, its filter and averaging, makes of sines.

        Parameters
        ----------
        frequency_hz
            (f,) their frequencies, Hz.

        Returns
        -------
        array
            (f,) complex gains, with exp(+iωt).
        """
        kept = self.averaging.kept(frequency_hz).astype(np.complex128)
        return kept if self.low_pass is None else kept * self.low_pass.response(frequency_hz)

    @property
    def fit_runs(self) -> tuple[Run, ...]:
        """The runs a model may be fitted to."""
        return tuple(run for run in self.runs if run.role == "fit")

    @property
    def validate_runs(self) -> tuple[Run, ...]:
        """The runs no fit ever sees."""
        return tuple(run for run in self.runs if run.role == "validate")

    @property
    def unit(self) -> str:
        """The unit of the leading quantity, in which all channels count."""
        return self.leading.unit

    @property
    def noise_key(self) -> str:
        """Under which key campaign.toml states the noise."""
        return f"noise_rms{ending_of(self.unit)}"

    def __len__(self) -> int:
        return len(self.runs)

    def __iter__(self) -> Iterator[Run]:
        return iter(self.runs)

    def __contains__(self, run: object) -> bool:
        return any(run is each or run == each.id for each in self.runs)

    def __getitem__(self, run_id: str) -> Run:
        """The run of this id.

        Raises
        ------
        CampaignError
            There is no run of this id.
        """
        from wheelhop.campaign.selection import run_of

        return run_of(self, run_id)

    def select(
        self,
        *ids: str,
        role: Role | None = None,
        track: str | None = None,
        channels: Sequence[str] | None = None,
    ) -> Self:
        """The campaign with some of its runs and channels, in the campaign's order.

        Parameters
        ----------
        ids
            The runs' ids; without any, all runs.
        role, track
            Only those of this role, "fit" or "validate", and on this kind of track ("washboard").
        channels
            The channels by name; by default all. Others are neither fitted nor compared.

        Returns
        -------
        Campaign
            Another one.

        Raises
        ------
        CampaignError
            There is no run of such an id, role or kind of track, or no channel of such a name.
        """
        from wheelhop.campaign.selection import of_channels, of_runs

        found = replace(self, runs=of_runs(self, ids, role, track))
        return found if channels is None else replace(found, **of_channels(found, channels))

    def recording(self, run_id: str) -> Recording:
        """The samples of one run as they were recorded.

        Parameters
        ----------
        run_id
            Its id.

        Returns
        -------
        Recording
            (n, n_channels), in the channels' units.

        Raises
        ------
        CampaignError
            There is no run of this id.
        """
        run = self[run_id]
        channels = tuple(Recorded(c.name, c.unit, c.point) for c in self.channels)
        return Recording(
            run.record, self.sample_rate_hz, channels, float(run.time_s[0]), self.averaging_s
        )

    def to_dataframe(self) -> DataFrame:
        """The runs, one a row.

        Returns
        -------
        DataFrame
            By run: role, track, `speed_m_s`, `duration_s`, samples, rms of the leading quantity.
        """
        import pandas

        from wheelhop.campaign.selection import listed_runs

        return pandas.DataFrame(listed_runs(self)).set_index("run")

    def __repr__(self) -> str:
        low, high = self.band_hz
        runs = f"{len(self.fit_runs)} runs to fit and {len(self.validate_runs)} to judge"
        return (
            f"<{type(self).__name__} {shown(self.title)}: {runs}, {len(self.channels)} channels"
            f" at {self.sample_rate_hz:g} Hz, compared from {low:g} to {high:g} Hz>"
        )

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{self.to_dataframe().to_html(float_format='%.4g')}"


@dataclass(frozen=True, eq=False, repr=False)
class ComponentCampaign(Campaign):
    """One component on a rig: there is one channel, what the rig does not impose; `nominal` holds
    the numbers of [component] and `uncertainty` one standard deviation of each (0 for a nominal
    0: nothing is believed of it). `without` names those that are 0 because the component has no
    such part: "stiffness_N_m" without a spring; `preloaded` says that a spring carries a force that
    nothing shows. `mount_file` is the specimen the component may stand on."""

    drive: RigDrive
    nominal: Mapping[str, float]
    uncertainty: Mapping[str, float]
    mount_file: Path | None = None
    without: frozenset[str] = frozenset()
    preloaded: bool = False

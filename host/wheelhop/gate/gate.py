"""The gate: before anything is fitted, is the campaign what its files say it is?"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.campaign.thin import thinned
from wheelhop.compare import weighed
from wheelhop.gate.drive import Nominal, drive_of
from wheelhop.gate.finding import Finding
from wheelhop.gate.identities import identity_findings
from wheelhop.gate.numbers import number_findings
from wheelhop.gate.places import likeliest
from wheelhop.gate.records import (
    copy_findings,
    find_copies,
    noise_findings,
    rigid_findings,
    same_signal_findings,
)
from wheelhop.gate.runs import run_findings
from wheelhop.gate.sensors import Seen, examined, sensor_findings
from wheelhop.gate.signs import sign_findings
from wheelhop.gate.spectra import Spectra, spectra_of
from wheelhop.gate.units import gravity_findings, speed_findings, unit_findings
from wheelhop.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class Gated:
    """What was found, and the campaign without what gives no signal, and no faster than its band
    needs. `symptoms` is all that the sensors' examination found, what is left unsaid here, too;
    None for a component on a rig, where nothing is examined."""

    findings: tuple[Finding, ...]
    campaign: Campaign
    symptoms: tuple[Seen, ...] | None = None


def gate(campaign: Campaign, vehicle: Vehicle) -> Gated:
    """Look for the mistakes people make, in the order in which one hides the next.

    Sensors first; then the vehicle's numbers and what recordings say by themselves; then, as far as
    these are in order, whether tracks, speeds and places explain the runs. Of a component on a rig
    the recordings alone are judged.
    """
    if isinstance(campaign, ComponentCampaign):
        found = (*copy_findings(find_copies(campaign)), *sign_findings(campaign))
        return Gated(found, campaign)
    symptoms = tuple(examined(campaign))
    findings, sound = sensor_findings(campaign, symptoms)
    findings += gravity_findings(sound)
    findings += speed_findings(sound)
    copies = list(find_copies(campaign))
    findings += copy_findings(copies)
    findings += same_signal_findings(sound)
    numbers = list(number_findings(vehicle))
    findings += numbers
    counted = weighed(sound)
    findings += identity_findings(counted, vehicle.values)
    evened = _evened(counted)
    spectra = [
        spectra_of(run, sound.sample_rate_hz, sound.band_hz, evened.noise_scale)
        for run in sound.runs
    ]
    if not numbers and not _of(findings, "units"):
        nominal = Nominal(evened, vehicle, counted.noise_scale)
        findings += _driven(nominal, vehicle, spectra, {run.id for c in copies for run in c.runs})
    if not _of(findings, "units"):
        findings += noise_findings(evened, spectra)
    if not _of(findings, "polarity", "swapped", "exchanged", "misplaced"):
        findings += rigid_findings(evened, spectra)
    light = thinned(sound)
    if light is not sound:
        findings.append(_thinned(sound, light))
    return Gated(tuple(_once(findings)), light, symptoms)


def _thinned(full: Campaign, light: Campaign) -> Finding:
    many = round(full.sample_rate_hz / light.sample_rate_hz)
    return Finding(
        "before",
        "thinned",
        "sample_rate_hz",
        f"{full.sample_rate_hz:g} Hz is more than {full.band_hz[0]:g} to {full.band_hz[1]:g} Hz"
        f" need: what is fitted are means of {many} samples, at {light.sample_rate_hz:g} Hz.",
        "Widen band_hz if there is more to see.",
        "certain",
    )


def _evened(campaign: Campaign) -> Campaign:
    """The campaign with every quantity counting alike: what is wrong of the one that moves least,
    per its noise, would not show beside the others."""
    if len(campaign.quantities) == 1:
        return campaign
    power = np.mean([run.record.var(axis=0) for run in campaign.runs], axis=0)
    quantity = np.array([c.quantity for c in campaign.channels])
    # The median: one channel may be in another unit.
    size = {q: float(np.median(power[quantity == q])) for q in campaign.quantities}
    channels = tuple(
        replace(c, noise_scale=float(np.sqrt(size[c.quantity])) or 1.0) for c in campaign.channels
    )
    return replace(campaign, channels=channels)


def _driven(
    nominal: Nominal, vehicle: Vehicle, spectra: list[Spectra], copied: set[str]
) -> list[Finding]:
    """What tracks, speeds and places say; of runs that are copies it is known already."""
    campaign = nominal.campaign
    drives = [drive for s in spectra if (drive := drive_of(campaign, s, nominal)) is not None]
    if not drives:
        return []
    runs, mistake = likeliest(campaign, drives)
    findings = [] if mistake is None else [mistake]
    if runs.description.kind in ("", "speed"):
        findings += unit_findings(campaign, vehicle, runs)
    if not _of(findings, "units"):
        findings += run_findings(runs, campaign.folder, copied)
    return findings


def _of(findings: list[Finding], *kinds: str) -> bool:
    return any(finding.kind in kinds for finding in findings)


def _once(findings: list[Finding]) -> list[Finding]:
    """Each kind of mistake about the same things once, the surer first."""
    order = ("certain", "likely", "possible")
    kept: dict[tuple[str, str], Finding] = {}
    for finding in sorted(findings, key=lambda f: order.index(f.severity)):
        kept.setdefault((finding.kind, _named(finding.about)), finding)
    return list(kept.values())


def _named(about: str) -> str:
    words = about.replace(",", " ").replace(" and ", " ").split()
    return " ".join(sorted(w for w in words if w not in ("channel", "channels")))

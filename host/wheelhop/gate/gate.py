"""The gate: before anything is fitted, is the campaign what its files say it is?"""

from __future__ import annotations

from dataclasses import dataclass

from wheelhop.campaign import Campaign, ComponentCampaign
from wheelhop.gate.drive import Nominal, OnWaves, drive_of
from wheelhop.gate.finding import Finding
from wheelhop.gate.numbers import number_findings
from wheelhop.gate.places import likeliest
from wheelhop.gate.records import (
    copy_findings,
    noise_findings,
    rigid_findings,
    same_signal_findings,
)
from wheelhop.gate.runs import run_findings
from wheelhop.gate.sensors import sensor_findings
from wheelhop.gate.spectra import Spectra, spectra_of
from wheelhop.gate.units import gravity_findings, unit_findings
from wheelhop.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class Gated:
    """What was found, and the campaign without what gives no signal."""

    findings: tuple[Finding, ...]
    campaign: Campaign


def gate(campaign: Campaign, vehicle: Vehicle) -> Gated:
    """Look for the mistakes people make, in the order in which one hides the next.

    Sensors first; then the vehicle's numbers and what recordings say by themselves; then, as far as
    these are in order, whether tracks, speeds and places explain the runs. Of a component on a rig
    the recordings alone are judged.
    """
    if isinstance(campaign, ComponentCampaign):
        return Gated(tuple(copy_findings(campaign)), campaign)
    findings, sound = sensor_findings(campaign)
    findings += gravity_findings(sound)
    findings += copy_findings(campaign)
    findings += same_signal_findings(sound)
    numbers = list(number_findings(vehicle))
    spectra = [spectra_of(run, sound.sample_rate_hz, sound.band_hz) for run in sound.runs]
    in_m_s2 = not any(finding.kind == "units" for finding in findings)
    if in_m_s2 and not any(finding.kind == "no-vehicle" for finding in numbers):
        findings += _driven(sound, vehicle, spectra)
    if in_m_s2:
        findings += noise_findings(sound, spectra)
    findings += numbers
    if not any(finding.kind in ("polarity", "swapped", "exchanged") for finding in findings):
        findings += rigid_findings(sound, spectra)
    return Gated(tuple(_once(findings)), sound)


def _driven(campaign: Campaign, vehicle: Vehicle, spectra: list[Spectra]) -> list[Finding]:
    """What tracks, speeds and places say."""
    nominal = Nominal(campaign, vehicle.values)
    drives = [drive for s in spectra if (drive := drive_of(campaign, s, nominal)) is not None]
    if not drives:
        return []
    runs, mistake = likeliest(campaign, drives)
    findings = [] if mistake is None else [mistake]
    waves = [
        (drive, found)
        for drive, found in zip(runs.drives, runs.found, strict=True)
        if isinstance(drive, OnWaves)
    ]
    if runs.description.kind in ("", "speed"):
        findings += unit_findings(campaign, vehicle, [d for d, _ in waves], [m for _, m in waves])
    findings += run_findings(runs)
    return findings


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

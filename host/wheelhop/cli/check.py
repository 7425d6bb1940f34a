"""`wheelhop check`: read a campaign and show on one screen what is in it."""

from argparse import Namespace
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.api.planning import detectable
from wheelhop.campaign import (
    Campaign,
    Channel,
    ComponentCampaign,
    RigRun,
    Run,
    TrackSpec,
    find_duplicates,
    read_campaign,
)
from wheelhop.campaign.channel import ABOARD
from wheelhop.campaign.known import asked_by
from wheelhop.campaign.sample import SAMPLE, marked_numbers
from wheelhop.cli.campaign_json import campaign_to_json
from wheelhop.cli.detectable import print_detectable
from wheelhop.cli.output import open_console, write_json
from wheelhop.cli.progress import stages
from wheelhop.cli.sensors import print_sensors
from wheelhop.cli.show import print_findings
from wheelhop.files.words import listed, significant
from wheelhop.gate import gate
from wheelhop.predict.detectable import to_json as detectable_to_json
from wheelhop.vehicle import Vehicle, read_nominal
from wheelhop.vehicle.estimate import ESTIMATED


def run(arguments: Namespace) -> int:
    """Read campaign, recordings and vehicle, and print them; raises CampaignError."""
    campaign = read_campaign(arguments.campaign)
    nominal = read_nominal(campaign)
    console = open_console()
    console.print(Text(campaign.title, style="bold"))
    console.print(Text(_tested(nominal)))
    console.print(Text(f"channels  {', '.join(map(_place, campaign.channels))}"))
    _print_known(campaign, console)
    console.print(Text(f"samples   {_samples(campaign)}"))
    console.print(Text(f"noise     {_noise(campaign)}"))
    gated = gate(campaign, nominal)
    findings = gated.findings
    print_sensors(gated.symptoms, console)
    print_findings(findings, console)
    _print_marked(campaign, console, any(finding.kind == "template" for finding in findings))
    if isinstance(campaign, ComponentCampaign):
        console.print(_rig_runs(campaign))
    else:
        console.print(_runs(campaign))
        rest = "".join(f"; {q}: {unit}" for q, unit in _others(campaign).items())
        console.print(Text(f"axle, body: m/s²{rest} rms without the mean"))
    for duplicate in find_duplicates(campaign):
        console.print(Text(f"! {duplicate}", style="yellow"))
    if not campaign.validate_runs:
        console.print(Text('no run has role = "validate": no model can be put to the test'))
    said = campaign_to_json(campaign, findings)
    if not isinstance(campaign, ComponentCampaign):
        with stages() as progress:
            found = detectable(
                gated.campaign, vehicle=nominal, effects=arguments.effects, progress=progress
            )
        print_detectable(found, console)
        said["detectable"] = detectable_to_json(found)
    if arguments.json:
        write_json(arguments.json, said)
    return 0


def _print_known(campaign: Campaign, console: Console) -> None:
    """What is recorded and not compared, used or not."""
    driven = [run.driven.channel for run in campaign if run.driven is not None]
    if driven:
        runs = f"{len(driven)} of {len(campaign.runs)} runs"
        console.print(Text(f"speed     as {driven[0]} shows it, in {runs}"))
    kept = ", ".join(f"{c.name} ({_known(c)})" for c in campaign.known if c.name not in driven)
    if kept:
        console.print(Text(f"kept      {kept}: not compared"))


def _print_marked(campaign: Campaign, console: Console, said: bool) -> None:
    """Which numbers of the vehicle nobody has replaced or measured yet, or whose mark was left;
    `said`: that they are the sample's stands there already."""
    if isinstance(campaign, ComponentCampaign):
        return
    file = campaign.vehicle_file
    for mark, words in ((SAMPLE, "still marked as the sample's"), (ESTIMATED, "only estimated")):
        marked = marked_numbers(file, mark)
        if marked and not (said and mark == SAMPLE):
            console.print(Text(f"! {file.name}: {words}: {', '.join(marked)}", style="yellow"))


def _place(channel: Channel) -> str:
    if channel.point == "body-xy":
        return f"{channel.name} (body, x {channel.x_m:g} m, y {channel.y_m:g} m)"
    if channel.point == "body":
        return f"{channel.name} (body, place unknown)"
    if channel.point in ABOARD:
        return f"{channel.name} (on the {channel.point})"
    if channel.quantity == "rate":
        return f"{channel.name} (rate of {channel.point})"
    if channel.corner is not None and not channel.is_acceleration:
        ratio = f", {channel.per_wheel:g} per wheel" if channel.per_wheel != 1.0 else ""
        return f"{channel.name} ({channel.quantity} of strut {channel.corner + 1}{ratio})"
    return channel.name if channel.name == channel.point else f"{channel.name} ({channel.point})"


def _samples(campaign: Campaign) -> str:
    low, high = campaign.band_hz
    return f"{campaign.sampling}; compared from {low:g} to {high:g} Hz"


def _noise(campaign: Campaign) -> str:
    stated, untold = [], []
    for quantity in campaign.quantities:
        first = next(c for c in campaign.channels if c.quantity == quantity)
        is_leading = quantity == campaign.leading.quantity
        noise = campaign.noise_rms if is_leading else first.noise_rms
        if noise is None:
            untold.append(quantity)
        else:
            stated.append(f"{noise:g} {first.unit}")
    if not stated:
        return "not stated, will be estimated"
    rest = f"; of {listed(untold)} not stated, will be estimated" if untold else ""
    return f"{', '.join(stated)} rms in band{rest}"


def _known(channel: Channel) -> str:
    """What is measured of a channel that is only kept, and which effect asks for it."""
    effect = asked_by(channel)
    used = f", for {effect}" if effect else ""
    return f"{channel.quantity}, {channel.unit}{used}"


def _tested(nominal: Vehicle) -> str:
    """What was tested, in a line."""
    if "body.mass_kg" in nominal.values:
        return f"vehicle   {nominal.name}, sprung mass {nominal['body.mass_kg']:g} kg"
    mass, stiffness, damping = (
        significant(nominal[f"component.{key}"])
        for key in ("mass_kg", "stiffness_N_m", "damping_N_s_m")
    )
    return f"component {mass} kg, {stiffness} N/m, {damping} N s/m"


def _runs(campaign: Campaign) -> Table:
    """One line a run."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    others = _others(campaign)
    for heading in ("run", "role", "km/h", "track", "rows", "s", "axle", "body", *others):
        right = heading not in ("run", "role", "track")
        table.add_column(heading, justify="right" if right else "left", overflow="fold")
    for item in campaign.runs:
        table.add_row(
            Text(item.id),
            item.role,
            f"{item.speed_m_s * 3.6:.1f}",
            Text(_track(item.track)),
            str(len(item.time_s)),
            f"{len(item.time_s) / campaign.sample_rate_hz:.1f}",
            _rms(item, [c.is_axle for c in campaign.channels]),
            _rms(item, [c.is_acceleration and not c.is_axle for c in campaign.channels]),
            *(_rms(item, [c.quantity == other for c in campaign.channels]) for other in others),
        )
    return table


def _rig_runs(campaign: ComponentCampaign) -> Table:
    """One line a run on a rig."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("run", "role", "rows", "s", "displacement, m", "force, N"):
        right = heading not in ("run", "role")
        table.add_column(heading, justify="right" if right else "left", overflow="fold")
    for item in campaign.runs:
        if isinstance(item, RigRun):
            table.add_row(
                Text(item.id),
                item.role,
                str(len(item.time_s)),
                f"{len(item.time_s) / campaign.sample_rate_hz:.1f}",
                *(f"{y.min():.3g} … {y.max():.3g}" for y in (item.displacement, item.force)),
            )
    return table


def _track(track: TrackSpec) -> str:
    """The kind, then amplitude × pitch (height × length of a bump) or the name of the file."""
    lengths = [float(value) * 1e3 for key, value in track.values.items() if key.endswith("_m")]
    size = f" {lengths[0]:g} × {lengths[1]:g} mm" if lengths else ""
    file = track.values.get("file")
    return f"{track.kind}{size}" + (f" {Path(str(file)).name}" if file else "")


def _others(campaign: Campaign) -> dict[str, str]:
    """What is compared besides accelerations, and its unit."""
    return {c.quantity: c.unit for c in campaign.channels if not c.is_acceleration}


def _rms(item: Run, columns: list[bool]) -> str:
    if not any(columns):
        return "-"
    return f"{float((item.record[:, columns].var(axis=0)).mean()) ** 0.5:.3g}"

"""`wheelhop add`: make effects part of the model and keep it in the campaign's folder."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.campaign import read_campaign
from wheelhop.cli.console import open_console
from wheelhop.cli.exchange import pick
from wheelhop.cli.progress import stages
from wheelhop.cli.show import print_ladder, print_parameters
from wheelhop.diagnose.added import steps_with
from wheelhop.effects import beliefs, load_effects
from wheelhop.report.model_file import write_model
from wheelhop.vehicle import read_nominal

MODEL_FILE = "model.toml"


def run(arguments: Namespace) -> int:
    """Refit, print the ladder, store CAMPAIGN/model.toml; raises CampaignError."""
    campaign = read_campaign(arguments.campaign)
    vehicle = read_nominal(campaign)
    library = {**load_effects(arguments.effects_file), **beliefs(campaign, vehicle)}
    effects = pick(arguments.effects, library)
    with stages() as progress:
        steps = steps_with(campaign, vehicle, effects, progress)
    console = open_console()
    print_ladder(steps, console)
    print_parameters(steps[-1], console)
    file = arguments.campaign / MODEL_FILE
    write_model(file, campaign, vehicle, steps)
    console.print(f"stored in {file}", markup=False)
    return 0

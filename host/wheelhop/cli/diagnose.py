"""`wheelhop diagnose`."""

from argparse import Namespace

from wheelhop.campaign import CampaignError


def run(arguments: Namespace) -> int:
    """Not part of this version yet; raises CampaignError to say so."""
    raise CampaignError("'diagnose' is not part of this version yet; 'wheelhop check' is")

"""What can be written but says nothing is told when it is read, not by a fault of arithmetic."""

import pytest

from tests.campaign.build import acceleration, csv_text, edit, write_campaign
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.files import InputError


@pytest.mark.parametrize("run", ["slow", "fast"])
def test_a_run_in_which_nothing_moves(run, tmp_path):
    folder = write_campaign(tmp_path / "c")
    (folder / f"runs/{run}.csv").write_text(csv_text(0 * acceleration(1) + 9.81))
    with pytest.raises(CampaignError, match=f"{run}.csv: no channel ever changes"):
        read_campaign(folder)


@pytest.mark.parametrize("band", ["[30.1, 30.2]", "[0.01, 0.02]"])
def test_a_band_between_two_frequencies(band, tmp_path):
    folder = write_campaign(tmp_path / "c")
    edit(folder / "campaign.toml", "[0.5, 30.0]", band)
    with pytest.raises(CampaignError, match=r"slow.csv: 256 rows at 100 Hz tell nothing between"):
        read_campaign(folder)


def test_a_key_of_two_million_letters_is_not_echoed_whole(tmp_path):
    folder = write_campaign(tmp_path / "c")
    file = folder / "campaign.toml"
    file.write_text(file.read_text().replace("averaging_ms", "k" * 2_000_000))
    with pytest.raises(InputError) as caught:
        read_campaign(folder)
    assert len(str(caught.value)) < 2100
    assert str(folder) in str(caught.value)

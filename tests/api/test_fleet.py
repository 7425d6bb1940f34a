"""Many campaigns: a row for each, whatever happens on the way."""

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pandas
import pytest

from tests.report.small import write_small_campaign
from wheelhop.api import fleet as fleet_module
from wheelhop.api.fleet import Fleet, diagnose_fleet
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.main import main


def found(folder, **options):
    """A diagnosis as the table sees it, the verdict told by the campaign's title."""
    campaign = read_campaign(folder)
    step = SimpleNamespace(
        rung=SimpleNamespace(error=0.5), parameters={"body.mass_kg": (228.0, 5.0)}
    )
    return SimpleNamespace(
        campaign=campaign,
        verdict=tuple(campaign.title.split(" and ")),
        confidence=0.9,
        steps=(step, step),
        last=step,
        error=0.1,
        floor=0.02,
        findings=(),
    )


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Three campaigns; the second cannot be read."""
    monkeypatch.setattr(fleet_module, "diagnose", found)
    titles = ("dry-friction", "bad", "dry-friction and driver-seat")
    made = [tmp_path / f"c{i}" for i in range(len(titles))]
    for folder, title in zip(made, titles, strict=True):
        write_small_campaign(folder)
        toml = folder / "campaign.toml"
        lines = toml.read_text().splitlines()
        toml.write_text(
            "\n".join(f'title = "{title}"' if x.startswith("title") else x for x in lines)
        )
    (made[1] / "campaign.toml").write_text("format = 1\n")
    return made


def test_a_row_for_each_and_a_reason_where_there_is_no_verdict(folders, tmp_path):
    with ThreadPoolExecutor(2) as pool:
        rows = diagnose_fleet(folders, tmp_path / "t.parquet", executor=pool)
    table = pandas.read_parquet(tmp_path / "t.parquet")
    assert table["campaign"].tolist() == [str(folder) for folder in folders]
    assert table["verdict"].tolist() == ["dry-friction", "", "dry-friction + driver-seat"]
    assert "keys are missing" in table["problem"][1] and "c1" in table["problem"][1]
    assert table["body.mass_kg"].isna().tolist() == [False, True, False]
    assert table["body.mass_kg_uncertainty"][2] == 5.0 and len(rows) == 3


def test_it_goes_on_where_it_was_and_not_with_files_that_changed(folders, tmp_path, monkeypatch):
    table, done = tmp_path / "t.parquet", []

    def interrupted(folder, **options):
        if len(done) == 1:
            raise KeyboardInterrupt
        done.append(folder)
        return found(folder)

    monkeypatch.setattr(fleet_module, "diagnose", interrupted)
    chosen = [folders[0], folders[2]]
    with pytest.raises(KeyboardInterrupt), ThreadPoolExecutor(1) as pool:
        diagnose_fleet(chosen, table, executor=pool)
    assert not table.exists() and done == [folders[0]]
    vehicle = folders[2] / "vehicle.toml"
    before = vehicle.read_text()
    vehicle.write_text(before + "# another\n")
    with pytest.raises(CampaignError, match="delete it"), ThreadPoolExecutor(1) as pool:
        diagnose_fleet(chosen, table, executor=pool)
    vehicle.write_text(before)
    (folders[0] / "model.toml").write_text("what wheelhop writes is no change")
    monkeypatch.setattr(fleet_module, "diagnose", lambda f, **o: done.append(f) or found(f))
    with ThreadPoolExecutor(1) as pool:
        assert len(diagnose_fleet(chosen, table, executor=pool)) == 2
    assert done == chosen


@pytest.mark.parametrize("changed", ["car.toml", "parts/frame.toml", "parts/frame.bdf", "slow.csv"])
def test_whatever_a_campaign_is_made_of_counts_under_any_name(changed, tmp_path):
    files = {
        "campaign.toml": 'vehicle = "car.toml"\nfile = "slow.csv"\n',
        "car.toml": "name = 'the driver's'\n[frame]\nfile = \"parts/frame.toml\"\n",
        "parts/frame.toml": "bdf = 'frame.bdf'\n",
        "parts/frame.bdf": "GRID\n",
        "slow.csv": "time_s,B1\n",
        "model.toml": "what was found\n",
        "report.html": "car.toml\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    before = Fleet((tmp_path,)).fingerprint
    for name in ("model.toml", "report.html"):
        (tmp_path / name).write_text("another")
    assert Fleet((tmp_path,)).fingerprint == before
    (tmp_path / changed).write_text(files[changed] + "more\n")
    assert Fleet((tmp_path,)).fingerprint != before


def test_a_campaign_is_one_however_its_folder_is_spelt(folders, tmp_path, monkeypatch):
    (tmp_path / "link").symlink_to(folders[0])
    monkeypatch.chdir(tmp_path)
    spelt = ["c0", "./c0/", str(folders[0]), f"{folders[0]}/", "c1/../c0", "link"]
    assert len({Fleet((Path(one),)).fingerprint for one in spelt}) == 1
    with pytest.raises(CampaignError, match="each once"):
        diagnose_fleet(["c0", "link"], tmp_path / "t.parquet")
    with ThreadPoolExecutor(1) as pool:
        first, *others = [diagnose_fleet([one], "t.parquet", executor=pool) for one in spelt]
    assert all(rows == first for rows in others)


def test_a_computer_that_does_not_see_the_campaign_says_so_and_finishes_nothing(folders, tmp_path):
    class Elsewhere(ThreadPoolExecutor):
        """Where the second folder has not been mounted."""

        def submit(self, function, number):
            def work():
                hidden = folders[2].rename(tmp_path / "hidden") if number == 1 else None
                try:
                    return function(number)
                finally:
                    if hidden:
                        hidden.rename(folders[2])

            return super().submit(work)

    chosen, table = [folders[0], folders[2]], tmp_path / "t.parquet"
    with pytest.raises(CampaignError, match=r"1 of 2 campaigns.*c2.*goes on"), Elsewhere(1) as pool:
        diagnose_fleet(chosen, table, executor=pool)
    assert not table.exists()
    with ThreadPoolExecutor(1) as pool:
        rows = diagnose_fleet(chosen, table, executor=pool)
    assert [row["problem"] for row in rows] == ["", ""]


def test_a_crash_of_one_does_not_stop_the_others(folders, tmp_path, monkeypatch):
    def crashes(folder, **options):
        if folder == folders[0]:
            raise ZeroDivisionError("float division by zero")
        return found(folder)

    monkeypatch.setattr(fleet_module, "diagnose", crashes)
    with ThreadPoolExecutor(1) as pool:
        rows = diagnose_fleet([folders[0], folders[2]], tmp_path / "t.parquet", executor=pool)
    assert "ZeroDivisionError" in rows[0]["problem"] and rows[1]["verdict"]


def test_the_command_writes_the_overview(folders, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(fleet_module, "workers", lambda jobs: ThreadPoolExecutor(jobs))
    page, table = tmp_path / "fleet.html", tmp_path / "t.parquet"
    words = [*map(str, folders), "--out", str(table), "--report", str(page)]
    for _ in range(2):  # the second time from the table
        assert main(["diagnose", *words]) == 1
        said = capsys.readouterr().out
        assert "    1  dry-friction\n" in said and "no verdict: " in said
    html = page.read_text()
    assert "dry-friction + driver-seat" in html and "keys are missing" in html
    for wrong, why in (
        ([*map(str, folders)], "--out TABLE.parquet"),
        ([str(folders[0])] * 2 + ["--out", str(table)], "each once"),
        ([*words, "--json", str(tmp_path / "x.json")], "--json"),
    ):
        assert main(["diagnose", *wrong]) == 2
        assert why in capsys.readouterr().err


def test_a_cluster_does_the_work(folders, tmp_path, capsys):
    distributed = pytest.importorskip("distributed")
    table = tmp_path / "t.parquet"
    words = ["diagnose", *map(str, folders), "--out", str(table)]
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as made:
        words += ["--cluster", made.scheduler_address]
        assert main([*words, "--jobs", "2"]) == 2
        assert "its own workers" in capsys.readouterr().err and not table.exists()
        assert main(words) == 1  # one of them cannot be read
    verdicts = pandas.read_parquet(table)["verdict"].tolist()
    assert verdicts == ["dry-friction", "", "dry-friction + driver-seat"]
    assert main(["diagnose", str(folders[0]), "--cluster", "tcp://127.0.0.1:9"]) == 2
    assert "several campaigns" in capsys.readouterr().err


@pytest.mark.slow
def test_processes_give_what_one_diagnosis_gives(tmp_path):
    clean = Path(__file__).parents[2] / "examples/open-dry-friction"
    both = [tmp_path / "a", tmp_path / "b"]
    for folder in both:
        shutil.copytree(clean, folder)
    first, second = diagnose_fleet(both, tmp_path / "t.parquet", max_effects=1, jobs=2)
    assert first["verdict"].startswith("dry-friction") and first["verdict"] == second["verdict"]
    assert first["error"] == second["error"] < first["error_baseline"]

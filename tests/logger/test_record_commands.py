"""`wheelhop record`, `download` and `logger` as a user meets them."""

import re
from argparse import Namespace

import pytest

from wheelhop.cli import download, logger, record
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble
from wheelhop.logger import LoggerError

BAUD = 500_000


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def recording(double, out, **options):
    values = {"start": True, "seconds": 10.0, "plot": False, "plot_port": 0}
    return Namespace(port=double.url, baud=BAUD, out=out, **{**values, **options})


def test_record_says_where_the_file_is_and_that_nothing_is_missing(tmp_path, out, capsys):
    with SerialDouble(card=tmp_path / "card", factor=20) as double:
        assert record.run(recording(double, out, plot=True)) == 0
    told = capsys.readouterr().out
    assert "plot: http://127.0.0.1:" in told
    scans = re.search(rf"{re.escape(str(out / 'HOP00001.HOP'))}: (\d+) scans, none missing", told)
    assert scans and int(scans[1]) >= 1000


def test_record_says_who_has_what_is_missing(tmp_path, out, capsys):
    faults = DoubleFaults(noise=1e-3)
    with SerialDouble(card=tmp_path / "card", faults=faults, factor=20) as double:
        assert record.run(recording(double, out)) == 1
        told = capsys.readouterr().out
        assert "missing" in told and "the card has all of them: wheelhop download HOP0" in told


def test_download_says_what_is_here(tmp_path, out, capsys):
    with SerialDouble(card=tmp_path / "card", factor=20) as double:
        arguments = Namespace(port=double.url, baud=BAUD, out=out, names=[], all=True)
        with pytest.raises(LoggerError, match="there are no log files on the card"):
            download.run(arguments)
        for _ in range(2):
            record.run(recording(double, tmp_path, seconds=2.0))
        capsys.readouterr()
        assert download.run(arguments) == download.run(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4 and lines[0].startswith(f"{out / 'HOP00001.HOP'}: ")
    assert "was here already" in lines[3]


def test_download_makes_no_second_copy_of_what_was_recorded(tmp_path, out, capsys):
    card = tmp_path / "card"
    with SerialDouble(card=card, factor=20) as double:
        fetching = Namespace(port=double.url, baud=BAUD, out=out, names=[], all=True)
        record.run(recording(double, out, seconds=2.0))
        assert download.run(fetching) == 0
        assert [file.name for file in out.iterdir()] == ["HOP00001.HOP"]
        assert "HOP00001.HOP was here already" in capsys.readouterr().out
        # Who names the file wants the card's; and a recording cut short will not do.
        assert download.run(Namespace(**{**vars(fetching), "names": ["HOP00001.HOP"]})) == 0
        assert (out / "HOP00001-2.HOP").read_bytes() == (card / "HOP00001.HOP").read_bytes()
        (out / "HOP00001-2.HOP").unlink()
        here = out / "HOP00001.HOP"
        here.write_bytes(here.read_bytes()[: 512 * 4])
        assert download.run(fetching) == 0
    assert sorted(file.name for file in out.iterdir()) == ["HOP00001-2.HOP", "HOP00001.HOP"]


def test_download_fetches_what_the_last_file_goes_on_with(tmp_path, out, capsys, monkeypatch):
    """A recording in several files is fetched whole, the one before it is not."""
    monkeypatch.setattr("wheelhop.hil_sim.double.session.MEBIBYTE", 40 * 512 // 128)
    with SerialDouble(card=tmp_path / "card", factor=20) as double:
        record.run(recording(double, tmp_path, seconds=2.0))
        record.run(recording(double, tmp_path, seconds=30.0))
        arguments = Namespace(port=double.url, baud=BAUD, out=out, names=[], all=False)
        capsys.readouterr()
        assert download.run(arguments) == 0
    # How long the double records beyond 30 s, and so into how many files, is the machine's.
    on_card = sorted(path.name for path in (tmp_path / "card").glob("*.HOP"))
    assert on_card[:4] == [f"HOP0000{number}.HOP" for number in (1, 2, 3, 4)]
    assert sorted(path.name for path in out.iterdir()) == on_card[1:]
    told = capsys.readouterr().out
    assert f"{out / 'HOP00004.HOP'} goes on with HOP00003.HOP" in told


def test_logger_asks_and_sets(tmp_path, capsys):
    with SerialDouble(card=tmp_path / "card", factor=20) as double:

        def run(action, *settings):
            assert (
                logger.run(Namespace(action=action, port=double.url, baud=BAUD, set=settings)) == 0
            )
            return capsys.readouterr().out

        assert "B1 B2 B3" in run("info")
        assert "rate_hz        200\n" in run("info", "rate=200", "name=first drive")
        run("time")
        assert run("start") == "recording HOP00001.HOP\n"
        assert "state        recording\n" in run("status")
        assert "end          command\n" in run("stop")
        assert "HOP00001.HOP  " in run("list")
        with pytest.raises(LoggerError, match="rate must be 100, 200 or 400"):
            run("info", "rate=7")
        with pytest.raises(
            LoggerError, match=r"--set colour=red: write KEY=VALUE, KEY one of rate"
        ):
            run("info", "colour=red")

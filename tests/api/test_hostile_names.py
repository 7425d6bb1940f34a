"""Channels, runs and titles may be called anything that prints: a name is a label, and another name
changes no number, breaks no file and ends in no traceback."""

import io
import json
import tomllib
import zipfile

import pandas
import pytest

import wheelhop as wh
from tests.report.small import write_small_campaign
from wheelhop.cli.main import main
from wheelhop.files.toml import to_toml
from wheelhop.formats import read
from wheelhop.workbench.export import write_figures, write_mdf, write_tables, write_workbook
from wheelhop.workbench.session import Choice, Session, read_session, write_session
from wheelhop.workbench.takeaway import packed

CHANNELS = {
    **{"B1": "a/b", "B2": "a", "B3": "b", "B4": "a.b"},
    **{"A1": "C:\\x \"y\" 'z', ;", "A2": "#1 = [/red] {0} %s $x^2$ <b>&", "A3": "Größe 車 🚗 é"},
    **{"A4": "long " * 60 + "."},
}
"""By their points; B3 is inverted, and nobody knows where on the body "a" and "a.b" sit."""
RUNS = {
    "washboard-low-slow": "a/b",
    "washboard-high-fast": "../../a",
    "herringbone-low-fast": "a",
    "washboard-low-fast": '"quoted" \\ #1 [/bold] $\\frac{1}$ <script>',
    "washboard-high-slow": "..",
}
TITLE = 'car "7" [/red] $\\alpha$ <b>\\'
FEW = ("sensor-polarity", "sensor-gain", "dry-friction")


def renamed(folder, channels, runs):
    """The small campaign in Parquet with B3 inverted, under these names."""
    write_small_campaign(folder, "clean")
    document = tomllib.loads((folder / "campaign.toml").read_text())
    places = {name: "body" if point in ("B2", "B4") else point for point, name in channels.items()}
    document |= {"title": TITLE, "channels": places}
    for run in document["run"]:
        file = folder / run["file"]
        table = pandas.read_csv(file)
        table["B3"] *= -1.0
        run["file"] = run["file"].removesuffix(".csv") + ".parquet"
        table.rename(columns=channels).to_parquet(folder / run["file"])
        run["id"] = runs[run["id"]]
    text = to_toml({k: v for k, v in document.items() if k not in ("run", "band_hz")})
    text = text.replace("\n[channels]", f"band_hz = {document['band_hz']}\n\n[channels]")
    (folder / "campaign.toml").write_text(text + to_toml({"run": document["run"]}))
    return folder


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    same = {name: name for name in (*CHANNELS, *RUNS)}
    folder = tmp_path_factory.mktemp("plain") / "c"
    return renamed(folder, {point: point for point in CHANNELS}, same)


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    return renamed(tmp_path_factory.mktemp("hostile") / "a/b.. #1 'ü'", CHANNELS, RUNS)


def diagnosed(folder):
    library = wh.load_effects()
    return wh.diagnose(folder, effects={name: library[name] for name in FEW}, max_effects=1)


@pytest.fixture(scope="module")
def both(plain, hostile):
    return diagnosed(plain), diagnosed(hostile)


def plain_again(value, names):
    """The same with every one of these names put back to the plain one."""
    back = {hostile: plain for plain, hostile in names.items()}
    if isinstance(value, dict):
        return {back.get(key, key): plain_again(item, names) for key, item in value.items()}
    if isinstance(value, list):
        return [plain_again(item, names) for item in value]
    return back.get(value, value) if isinstance(value, str) else value


def test_other_names_change_no_number(both):
    expected, found = both
    assert found.verdict == expected.verdict == ("sensor-polarity",)
    assert found.error == pytest.approx(expected.error, rel=1e-9)
    assert found.confidence == pytest.approx(expected.confidence, rel=1e-9)
    numbers = found.parameters()
    assert list(numbers["value"]) == pytest.approx(list(expected.parameters()["value"]), rel=1e-6)


def test_the_model_file_is_that_of_plain_names(both, tmp_path):
    """What is estimated of "a" is not of "a/b" too, nor of "a.b"."""
    models = []
    for found in both:
        found.write_model(tmp_path / "model.toml")
        models.append(tomllib.loads((tmp_path / "model.toml").read_text()))
    expected, model = models
    assert model["effect"][0]["id"] == "sensor-polarity" and model["effect"][0]["form"] == "b"
    for key, names in (("run", RUNS), ("channel", CHANNELS), ("vehicle", {}), ("ladder", {})):
        assert_alike(plain_again(model[key], names), expected[key])


def assert_alike(found, expected):
    """Equal, but for the last digits of numbers."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys()
        found, expected = list(found.values()), [*expected.values()]
    if isinstance(expected, list):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_alike(one, other)
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9)
    else:
        assert found == expected


def test_reports_figures_and_tables_show_them_as_they_are(both, hostile, tmp_path):
    found = both[1]
    found.write_report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "<script>" not in page and "[/bold]" in page and "a/b" in page
    json.dumps(found.to_json(), allow_nan=False)
    result = wh.compare(hostile, "dry-friction", by_axles=True)
    write_figures(tmp_path / "figures", result)
    write_tables(tmp_path / "tables", result)
    signals = pandas.read_parquet(tmp_path / "tables/signals.parquet")
    assert {f"{name}_measured_m_s2" for name in CHANNELS.values()} <= set(signals.columns)
    assert set(signals["run"]) == set(RUNS.values())
    write_workbook(tmp_path / "tables.xlsx", result)
    sheets = pandas.read_excel(tmp_path / "tables.xlsx", sheet_name=None)
    csv = pandas.read_csv(tmp_path / "tables/parameters.csv")
    assert sheets["parameters"]["value"].tolist() == pytest.approx(csv["value"].tolist())
    write_mdf(tmp_path / "mdf", result)
    files = sorted((tmp_path / "mdf").glob("*.mf4"))
    assert len(files) == len(RUNS)
    first = signals[signals["run"] == signals["run"].iloc[0]]
    own = read(files[0]).values[:, 0]
    assert own == pytest.approx(first.iloc[:, 2].to_numpy(), abs=1e-9)
    with zipfile.ZipFile(io.BytesIO(packed(tmp_path / "mdf"))) as archive:
        assert sorted(archive.namelist()) == [f"mdf/{file.name}" for file in files]


def test_the_commands_take_them(hostile, tmp_path, capsys):
    out, model = tmp_path / "c.json", hostile / "model.toml"
    commands = [
        ["check", hostile],
        ["compare", hostile, "--add", "sensor-polarity", "--json", out, "--report", tmp_path / "r"],
        ["add", hostile, "sensor-polarity"],
        ["convert", hostile / "runs/washboard-low-slow.parquet", tmp_path / "run.uff"],
    ]
    for command in commands:
        status = main([str(word) for word in command])
        printed = capsys.readouterr()
        assert status in (0, 1), printed.err
        assert "Traceback" not in printed.err
    assert json.loads(out.read_text())["ladder"]
    assert tomllib.loads(model.read_text())["effect"][0]["id"] == "sensor-polarity"


def test_a_session_comes_back(hostile):
    campaign = wh.read(hostile)
    channels, runs = list(CHANNELS.values()), list(RUNS.values())
    choice = Choice(
        added=("sensor-polarity", "belief: position of a/b"),
        without_runs=(runs[1], runs[3]),
        without_channels=(channels[0], channels[4], channels[5]),
        roles={runs[0]: "validate", runs[4]: "fit", runs[2]: "fit"},
    )
    write_session(campaign, Session(choice), "wheelhop")
    assert read_session(campaign).choice == choice
    assert len(choice.applied(campaign).channels) == 5

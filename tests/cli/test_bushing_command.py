"""`wheelhop bushing fit` on the shipped examples, and on what is wrong."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.material.table import POWER, ROWS
from wheelhop.cli.main import main
from wheelhop.material import read_specimen

EXAMPLES = Path(__file__).parents[2] / "examples/bushings"
MODEL = ["--model", "modified-power-law"]


def test_the_shipped_specimens_are_those_of_table_3_2():
    for (bushing, number, highest, *_), parameters in zip(ROWS, POWER, strict=True):
        specimen = read_specimen(EXAMPLES / f"bushing-{bushing}-specimen-{number}.toml")
        assert specimen.parameters == pytest.approx(parameters)
        assert specimen.band_hz == (1.0, highest)


def test_a_report_a_result_and_specimens_that_read_back(tmp_path, capsys):
    files = [EXAMPLES / "bushing-1-specimen-1.csv", EXAMPLES / "signals-1-1.csv"]
    report, result = tmp_path / "b.html", tmp_path / "b.json"
    outputs = ["--report", report, "--json", result, "--out", tmp_path]
    status = main(["bushing", "fit", *map(str, [*files, *outputs]), *MODEL])
    assert status == 0
    page = report.read_text(encoding="utf-8")
    assert page.count("<svg") >= 5  # angles, moduli twice, loops, equations
    assert "http" not in re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL)
    found = json.loads(result.read_text(encoding="utf-8"))["bushing-1-specimen-1"]
    assert found["causal"] and found["violation"] < 1e-3
    fitted = found["models"][0]
    specimen = read_specimen(tmp_path / "bushing-1-specimen-1.toml")
    assert specimen.model.name_values(specimen.parameters) == pytest.approx(fitted["parameters"])
    # The file was made from Table 3.2 with 1 % noise.
    for name, true in zip(("A0", "beta", "M0"), POWER[0], strict=True):
        assert abs(fitted["parameters"][name] - true) < 1.5 * fitted["half_widths_95"][name]
    assert "Maxwell elements" in capsys.readouterr().out


def test_data_no_causal_specimen_has_are_called_that(tmp_path, capsys):
    rows = (EXAMPLES / "bushing-2-specimen-1.csv").read_text().strip().split("\n")
    values = np.array([[float(v) for v in row.split(",")] for row in rows[1:]])
    values[:, 1] = values[::-1, 1]
    text = "\n".join([rows[0], *(",".join(map(str, row)) for row in values)])
    (tmp_path / "odd.csv").write_text(text)
    assert main(["bushing", "fit", str(tmp_path / "odd.csv"), *MODEL]) == 0
    assert "cannot both be right" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["nowhere.csv"], "no such file"),
        (["."], "no .csv file"),
        ([str(EXAMPLES / "bushing-1-specimen-1.csv"), "--model", "power-low"], "there is no model"),
        ([str(EXAMPLES / "bushing-1-specimen-1.csv"), "--out", "nowhere"], "no such folder"),
    ],
)
def test_mistakes_are_one_line(tmp_path, monkeypatch, capsys, arguments, says):
    monkeypatch.chdir(tmp_path)
    assert main(["bushing", "fit", *arguments]) == 2
    line = capsys.readouterr().err
    assert says in line and line.count("\n") == 1


@pytest.mark.parametrize(
    "old, new, says",
    [
        ("modified-power-law", "modified-power", "did you mean 'modified-power-law'"),
        ("beta = 0.056", "beta = 5.6", "beta = 5.6 lies outside"),
        ("beta = 0.056", "", "'beta' is missing"),
        ("[1.0, 30.0]", "[30.0, 1.0]", "the lower one first"),
        ("M0 =", "M1 =", "unknown key 'M1'"),
    ],
)
def test_a_specimen_that_is_wrong_is_one_line(tmp_path, old, new, says):
    from wheelhop.material import MaterialError

    file = tmp_path / "specimen.toml"
    shutil.copy(EXAMPLES / "bushing-1-specimen-1.toml", file)
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(MaterialError) as caught:
        read_specimen(file)
    assert says in str(caught.value) and str(caught.value).startswith(str(file))


def rubber(folder, temperatures):
    """Files of one specimen at several temperatures, a decade apart each 20 °C."""
    names = []
    for temperature in temperatures:
        lines = ["frequency_hz,dynamic_N_m,loss_N_m"]
        for f in np.geomspace(1.0, 50.0, 12):
            z = (2j * np.pi * f * 10 ** (-temperature / 20) * 2e-3) ** 0.35
            modulus = 8e5 * (1 + 4.0 * z / (1 + z))
            lines.append(f"{f},{modulus.real},{modulus.imag}")
        file = folder / f"t{temperature}.csv"
        file.write_text("\n".join(lines) + "\n")
        names.append(f"{file}={temperature}")
    return names


def test_shift_writes_the_specimen_at_the_reference(tmp_path, capsys):
    names = rubber(tmp_path, (0, 10, 23))
    target, answer = tmp_path / "m.toml", tmp_path / "m.json"
    arguments = ["--reference", "10", "--out", str(target), "--json", str(answer)]
    assert main(["bushing", "shift", *names, *arguments]) == 0
    assert "master curve leaves" in capsys.readouterr().out
    found = json.loads(answer.read_text())
    assert found["log10_shift"] == pytest.approx([0.5, 0.0, -0.65], abs=0.01)
    assert read_specimen(target).name == "m"


def test_shift_says_how_a_file_is_given(tmp_path, capsys):
    assert main(["bushing", "shift", "cold.csv"]) == 2
    assert "FILE=TEMPERATURE" in capsys.readouterr().err

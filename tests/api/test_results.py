"""Results: short in print, tables in a notebook, the same numbers as files and commands have."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import wheelhop as wh
from wheelhop.cli.main import main

SHORT = 300  # characters


def test_everything_prints_in_a_line_or_few(campaign, fitted, found):
    things = [campaign, campaign.runs[0], wh.read_vehicle(campaign), fitted, found, fitted.last]
    things += [fitted.comparison, found.diagnosis, fitted.model]
    things += [campaign.recording(campaign.runs[0].id), *wh.load_effects().values()]
    for thing in things:
        assert len(repr(thing)) < SHORT and "\n" not in repr(thing)
        assert "array(" not in repr(thing) and "object at 0x" not in repr(thing)


def test_titles_cannot_break_the_page_or_the_line(campaign):
    odd = replace(campaign, title="<script>\n" + "k" * 10_000)
    assert "<script>" not in odd._repr_html_()
    assert len(repr(odd)) < SHORT and "\n" not in repr(odd)


def test_in_a_notebook_things_are_tables(campaign, fitted, found):
    vehicle = wh.read_vehicle(campaign)
    for thing in (campaign, vehicle, fitted, found, fitted.comparison, found.diagnosis):
        page = thing._repr_html_()
        assert page.count("<table") == page.count("</table>") > 0
    assert "data:image/png;base64," in fitted._repr_html_()
    assert "data:image/png;base64," in found._repr_html_()
    assert len(campaign._repr_html_().split("<tr")) - 2 >= len(campaign.runs)


def test_the_ladder_has_the_errors_of_the_json(fitted):
    told = fitted.to_json()["ladder"]
    ladder = fitted.ladder()
    assert list(ladder.index) == ["baseline", "baseline + dry-friction"]
    for column in ("error_fit", "error_validate"):
        assert list(ladder[column]) == [rung[column] for rung in told]
    assert ladder["over_floor"].iloc[-1] == pytest.approx(fitted.error / fitted.floor)
    assert ladder["over_floor"].iloc[0] > 3 * ladder["over_floor"].iloc[-1]


def test_residuals_by_band_and_by_run_share_out_the_same_error(fitted):
    """Σ residual² / Σ measured² is E², whichever way it is cut."""
    totals = []
    samples = {run.id: len(run.time_s) for run in fitted.campaign.runs}
    for by in ("band", "run"):
        table = fitted.residuals(by)
        assert {name for name in table if not name.endswith("_m_s2")} == {"error", "over_floor"}
        n = pd.Series(1.0, table.index) * sum(samples.values())
        if by == "run":
            n = pd.Series(table.index.get_level_values("run").map(samples), table.index)
        power = {key: (table[f"{key}_rms_m_s2"] ** 2 * n).sum() for key in ("residual", "measured")}
        totals.append(power["residual"] / power["measured"])
        ratio = table["residual_rms_m_s2"] / table["noise_rms_m_s2"]
        np.testing.assert_allclose(table["over_floor"], ratio)
    assert totals[0] == pytest.approx(totals[1])
    assert np.sqrt(totals[0]) == pytest.approx(fitted.comparison.breakdown.total.error)


def test_agreement_has_a_row_for_every_run_and_channel(fitted):
    table = fitted.agreement()
    assert len(table) == len(fitted.campaign.runs) * len(fitted.campaign.channels)
    assert table["coherence"].between(0, 1).all() and table["iso18571"].between(0, 1).all()


def test_parameters_carry_unit_and_uncertainty(fitted):
    table = fitted.parameters()
    friction = table.loc["dry-friction.front_N"]
    assert friction["unit"] == "N" and 0 < friction["uncertainty"] < friction["value"]
    assert dict(table["value"]) == {k: v for k, (v, _) in fitted.last.parameters.items()}


def test_the_ranking_is_that_of_the_diagnosis(found):
    table = found.ranking()
    assert list(table.index) == [item["effect"] for item in found.to_json()["ranking"]]
    assert found.verdict == ("dry-friction",) and table.index[0] == "dry-friction"
    assert table["screened_error"].dtype == float and table["reason"].str.len().min() > 0


def test_changed_numbers_move_the_error_and_unchanged_ones_do_not(fitted):
    same = fitted.with_values({})
    assert same.error_fit == pytest.approx(fitted.comparison.error_fit, rel=1e-9)
    name = "suspension.front.stiffness_N_m"
    softer = fitted.with_values({name: 0.9 * fitted.model.values[name]})
    assert softer.error_fit > 2 * same.error_fit
    with pytest.raises(KeyError, match="stiffnes_N_m"):
        fitted.with_values({"suspension.front.stiffnes_N_m": 1.0})


def test_the_command_says_what_the_function_says(folder, fitted, tmp_path):
    file = tmp_path / "c.json"
    assert main(["compare", str(folder), "--add", "dry-friction", "--json", str(file)]) == 0
    told = json.loads(file.read_text())
    assert told["axle_driven"] is not None
    ours = json.loads(json.dumps(fitted.to_json()))
    for key in ("ladder", "error_fit", "floor", "findings", "where"):
        assert told[key] == ours[key]


def test_adding_stores_the_model_and_comparing_does_not(folder, tmp_path):
    from tests.report.small import write_small_campaign

    own = write_small_campaign(tmp_path / "c")
    result = wh.add(own, "dry-friction")
    stored = tomllib.loads((own / "model.toml").read_text())
    assert stored["effect"][0]["id"] == "dry-friction"
    assert stored["ladder"][-1]["error_fit"] == result.last.rung.error_fit
    assert not (folder / "model.toml").exists()


def test_an_effect_that_is_not_there_is_one_line(folder):
    with pytest.raises(wh.CampaignError, match='did you mean "dry-friction"'):
        wh.compare(folder, "dry-frictoin")


@pytest.mark.parametrize("kind", ["ladder", "where", "worst", "typical", "histograms", "loops"])
def test_results_are_drawn(fitted, found, kind):
    for result in (fitted, found):
        figure = wh.plot(result, kind)
        assert isinstance(figure, Figure) and figure.axes
        assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="choose ladder"):
        wh.plot(fitted, "pie")


def test_a_recording_is_drawn_channel_by_channel(campaign):
    recording = campaign.recording(campaign.runs[0].id)
    figure = wh.plot(recording)
    assert len(figure.axes) == len(recording.channels)
    assert figure.axes[0].get_ylabel() == "B1, m/s²"


def test_reports_are_written(fitted, found, tmp_path):
    for result in (fitted, found):
        result.write_report(tmp_path / "r.html")
        assert "<svg" in (tmp_path / "r.html").read_text()


@pytest.mark.parametrize("title", ['"a" \\ b', "two\nlines\tand\a\x7f", "\u202e\u2028'''"])
def test_an_odd_title_survives_in_the_model_s_file(fitted, title, tmp_path):
    odd = replace(fitted, campaign=replace(fitted.campaign, title=title))
    odd.write_model(tmp_path / "model.toml")
    assert tomllib.loads((tmp_path / "model.toml").read_text())["campaign"] == title


def test_selected_runs_keep_order_and_misspelt_ones_are_told(campaign):
    ids = [run.id for run in campaign.runs]
    assert [run.id for run in campaign.select(ids[2], ids[0]).runs] == [ids[0], ids[2]]
    with pytest.raises(wh.CampaignError, match=f"did you mean '{ids[0]}'"):
        campaign.select(ids[0][:-1])


def test_the_table_of_runs_has_its_units_in_its_names(campaign):
    runs = campaign.to_dataframe()
    assert {"speed_m_s", "duration_s", "rms_m_s2"} <= set(runs)
    record = campaign.runs[0].record
    expected = np.sqrt(record.var(axis=0).mean())
    assert runs["rms_m_s2"].iloc[0] == pytest.approx(expected)


def test_as_many_threads_work_as_are_given(campaign, monkeypatch):
    """Where the axles drive the body, too: nobody asks how many processors there are."""
    monkeypatch.setattr("wheelhop.fit.bench.processors", lambda: pytest.fail("asked"))
    assert wh.compare(campaign, by_axles=True, jobs=1).axles is not None


@pytest.mark.parametrize("kind", ["case", "signal", "residual", "psd"])
def test_a_figure_says_which_run_and_channel_it_shows(fitted, kind):
    figure = wh.plot(fitted, kind, run="washboard-low-slow", channel="B3")
    titles = [axes.get_title(loc="left") for axes in figure.axes] + [figure.get_suptitle()]
    assert "B3 in washboard-low-slow" in titles
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    labels = {text.get_text() for legend in legends for text in legend.get_texts()}
    assert {"baseline", "with dry-friction"} <= labels


def test_what_is_not_named_is_where_the_baseline_fails_worst(fitted):
    table = fitted.steps[0].comparison.residuals("run")["over_floor"]
    worst = table.xs("B3", level="channel").idxmax()
    figure = wh.plot(fitted, channel="B3")
    assert figure.get_suptitle() == f"B3 in {worst}"
    with pytest.raises(wh.InputError, match="no run"):
        wh.plot(fitted, run="washboard")
    with pytest.raises(wh.InputError, match="no channel"):
        wh.plot(fitted, channel="B7")


def test_figures_of_one_panel_go_into_axes_that_are_there(campaign, fitted):
    from matplotlib.figure import Figure as Plain

    figure = Plain()
    upper, lower = figure.subplots(2)
    assert wh.plot(fitted, ax=upper) is figure and upper.lines
    assert wh.plot(fitted, "psd", run="washboard-low-slow", ax=lower) is figure and lower.lines
    with pytest.raises(ValueError, match="several panels"):
        wh.plot(fitted, "where", ax=upper)
    wh.plot(campaign.recording("washboard-low-slow"), channel="A2", ax=upper)
    with pytest.raises(ValueError, match="panel for every channel"):
        wh.plot(campaign.recording("washboard-low-slow"), ax=upper)


def test_figures_a_result_does_not_have_are_told(fitted):
    for kind, why in (("axles", "nothing was identified"),):
        with pytest.raises(wh.InputError, match=why):
            wh.plot(fitted, kind)


def test_progress_is_shown_when_asked_for_and_not_else(campaign, capsys):
    part, said = campaign.select("washboard-low-slow"), []
    wh.compare(part, progress=said.append)
    assert any("fitting the baseline" in text for text in said)
    wh.compare(part, progress=False)
    wh.compare(part)  # neither a terminal nor a notebook
    assert capsys.readouterr().err == ""


def test_models_are_read_back_with_forms_and_what_runs_left_free(fitted, tmp_path):
    gain = wh.load_effects()["sensor-gain"].with_choice("B2")
    named = fitted.last.parameters | {"sensor-gain.error": (0.1, 0.01)}
    rung = fitted.last.rung
    model = rung.fit.model.with_values({"sensor-gain.error": 0.1})
    model = replace(model, effects=(*model.effects, gain))
    step = replace(
        fitted.last, parameters=named, rung=replace(rung, fit=replace(rung.fit, model=model))
    )
    replace(fitted, steps=(*fitted.steps, step)).write_model(tmp_path / "model.toml")
    again = wh.read_model(tmp_path / "model.toml")
    assert [vars(effect) for effect in again.effects] == [vars(effect) for effect in model.effects]
    assert dict(again.values) == pytest.approx(dict(model.values))
    runs = {run.id: dict(fitted.model.runs[run.id]) for run in fitted.campaign}
    assert {run: dict(values) for run, values in again.runs.items()} == runs
    text = (tmp_path / "model.toml").read_text()
    (tmp_path / "model.toml").write_text(text.replace('"dry-friction"', '"dry-fiction"'))
    with pytest.raises(wh.CampaignError, match='did you mean "dry-friction"'):
        wh.read_model(tmp_path / "model.toml")


@pytest.mark.parametrize("name", ["compare", "diagnose"])
def test_what_is_written_for_programs_fits_its_schema(fitted, found, name):
    import jsonschema

    from wheelhop.files.schemas import schema

    document = {"compare": fitted, "diagnose": found}[name].to_json()
    plain = json.loads(json.dumps(document))
    jsonschema.validate(plain, json.loads(schema(f"{name}-output")))

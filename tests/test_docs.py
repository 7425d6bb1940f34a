"""The documents say what is so: links lead somewhere, commands exist, examples run."""

import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.component import rig
from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.cli.parser import make_parser
from wheelhop.diagnose import diagnose, fit_baseline
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.simulate import Model, RunSimulator
from wheelhop.vehicle import read_nominal, read_vehicle

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(
    path
    for path in ROOT.rglob("*.md")
    if not any(part.startswith((".", "wheelhop-demo")) for part in path.relative_to(ROOT).parts)
)
EFFECTS = load_effects()

pages = pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
effects = pytest.mark.parametrize("effect", EFFECTS)


def text_of(page):
    return page.read_text(encoding="utf-8")


def without_code(text):
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)


def anchors(page):
    """Ids that GitHub gives to the headings of a page."""
    headings = re.findall(
        r"^#+ (.*)$", re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL), re.M
    )
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pages
def test_every_link_leads_somewhere(page):
    links = re.findall(
        r"\]\(([^)\s]+)\)", without_code(text_of(page).replace("[`", "[").replace("`]", "]"))
    )
    for link in links:
        if link.startswith(("http://", "https://")):
            continue
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), f"{link}: there is no such file"
        assert not anchor or anchor in anchors(target), f"{link}: there is no such heading"


@pages
def test_commands_on_a_page_are_commands_of_wheelhop(page):
    lines = re.findall(r"^ {4}(?:\S*[/\\])?(wheelhop .*)$", text_of(page), re.M)
    lines += re.findall(r"`(wheelhop [^`]*)`", text_of(page))
    for line in lines:
        words = shlex.split(line, comments=True)[1:]
        if len(words) == 1:  # the command is mentioned, not called
            words.append("--help")
        try:
            arguments = make_parser().parse_args(words)
        except SystemExit as stop:
            assert stop.code == 0, line
        else:
            assert arguments.command, line


def test_what_make_is_asked_for_in_the_readme_is_in_the_makefile():
    asked = re.findall(r"^ {4}make (\S+)", text_of(ROOT / "README.md"), re.M)
    offered = re.findall(r"^([a-z-]+):", text_of(ROOT / "Makefile"), re.M)
    assert asked == ["demo", "test"]
    assert set(asked) <= set(offered)


@pages
def test_modules_and_scripts_a_page_points_to_exist(page):
    for name in re.findall(r"`([\w*]+/[\w/*]+\.py)`", text_of(page)):
        found = [*ROOT.glob(name), *(ROOT / "host/wheelhop").glob(name)]
        assert found, f"{name}: there is no such file"


@pytest.fixture
def gallery(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    import make_effect_gallery

    return make_effect_gallery


def test_the_page_of_effects_says_what_the_classes_say(gallery):
    text = text_of(DOCS / "effects.md")
    stage = gallery.set_stage(gallery.EXAMPLE)
    assert gallery.updated(text, EFFECTS, stage) == text, "run docs/make_effect_gallery.py"


@effects
def test_every_effect_has_its_section_by_hand_and_its_picture(effect):
    _, _, section = text_of(DOCS / "effects.md").partition(f"\n## `{effect}`\n")
    by_hand = section.partition("<!-- end -->")[2].partition("\n## ")[0]
    assert "*Looks like*" in by_hand, "say what its signature looks like"
    assert "*Mistaken for*" in by_hand, "say what it is mistaken for"
    picture = (DOCS / f"effects/{effect}.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and len(picture) > 10_000


def test_nothing_is_documented_that_is_no_effect_any_more():
    assert set(re.findall(r"^## `([\w-]+)`$", text_of(DOCS / "effects.md"), re.M)) == set(EFFECTS)
    assert {path.stem for path in (DOCS / "effects").glob("*.png")} == {*EFFECTS, "angles"}


@pytest.fixture(scope="module")
def own_effects(tmp_path_factory):
    """The example of docs/writing-an-effect.md in a file of its own."""
    code = re.search(r"```python\n(.*?)```", text_of(DOCS / "writing-an-effect.md"), re.DOTALL)[1]
    assert len(code.splitlines()) <= 60
    file = tmp_path_factory.mktemp("own") / "my_effects.py"
    file.write_text(code)
    return load_effects(file)


def test_the_example_of_an_own_effect_has_the_law_it_states(own_effects):
    campaign = read_campaign(ROOT / "examples/clean")
    values = read_vehicle(campaign.vehicle_file).values
    effect = own_effects["quadratic-damper"]
    assert set(own_effects) == {*EFFECTS, effect.id}
    c2 = {f"{effect.id}.front_N_s2_m2": 300.0, f"{effect.id}.rear_N_s2_m2": 200.0}
    system = Model({**values, **c2}, (effect,)).system(campaign.channels, "road")
    law = system.laws[system.port_law[0]]
    assert law(0.0, 0.5, 0.0, 0.0, 0.0, system.law_parameters[0]) == (75.0, 0.0)
    assert law(0.0, -0.5, 0.0, 0.0, 0.0, system.law_parameters[3]) == (-50.0, 0.0)
    # Body up and axle down both extend the strut.
    assert np.allclose(system.port[0, [0, 3]], [1.0, -1.0])


def test_the_example_of_an_own_effect_is_found_on_a_rig(own_effects, tmp_path):
    """Along an imposed displacement, in the records of a rig that shares no code."""
    numbers = {"quadratic_N_s2_m2": 3000.0}
    component = rig.Component(hidden="quadratic-damper", numbers=numbers)
    folder = rig.make_campaign(tmp_path / "c", "displacement", component, seed=1, noise=0.01)
    campaign = read_campaign(folder)
    diagnosis = diagnose(campaign, read_nominal(campaign), own_effects, jobs=1)
    assert diagnosis.verdict == ("quadratic-damper",)
    value, _ = diagnosis.ladder[-1].parameters["quadratic-damper.strut_N_s2_m2"]
    assert value == pytest.approx(3000.0, rel=0.02)


def test_the_example_of_an_own_effect_is_found_where_it_is_missing(own_effects, tmp_path):
    campaign = read_campaign(write_small_campaign(tmp_path / "c", "clean"))
    vehicle = read_vehicle(campaign.vehicle_file)
    effect = own_effects["quadratic-damper"]
    parameters = effect.parameters_for(vehicle.values, campaign.channels)
    strong = {f"{effect.id}.{p.name}": p.scale for p in parameters}
    noise = np.random.default_rng(7)

    def recorded(run):
        free = {run.id: {"speed_m_s": run.speed_m_s, "start_m": 0.1}}
        model = Model({**vehicle.values, **strong}, (effect,), free)
        simulator = RunSimulator(campaign, run, run_up_s=4.0)
        moved = simulator.record(model, model.system(campaign.channels, "road"))
        return replace(run, record=moved + noise.normal(0.0, 0.1, moved.shape))

    campaign = replace(campaign, runs=tuple(recorded(run) for run in campaign.runs))
    base = fit_baseline(campaign, vehicle, progress=lambda text: None)
    first, *others = screen(base.workshop, base.rung.fit, list(own_effects.values()))
    assert first.variant.effect.id == effect.id
    assert first.score > 1.2 * max(other.score for other in others)


def test_every_figure_and_table_of_the_thesis_is_on_its_page():
    """They are numbered through in each chapter; none is missing, none is twice."""
    last = {
        "Figure": {
            "1": 9,
            "2": 21,
            "3": 15,
            "4": 75,
            "5": 25,
            "6": 1,
            "A": 2,
            "B": 5,
            "C": 4,
            "D": 3,
        },
        "Table": {"2": 5, "3": 3, "4": 8, "5": 4, "A": 2, "D": 1},
    }
    found = []
    line = re.compile(r"^\| (Figure|Table)s? (\w)\.(\d+)(?: to \w\.(\d+))? \|", re.M)
    for kind, chapter, first, end in line.findall(text_of(DOCS / "thesis.md")):
        found += [(kind, chapter, n) for n in range(int(first), int(end or first) + 1)]
    wanted = [
        (kind, chapter, n)
        for kind, chapters in last.items()
        for chapter, count in chapters.items()
        for n in range(1, count + 1)
    ]
    assert sorted(found) == sorted(wanted)

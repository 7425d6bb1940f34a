"""model.toml holds the model whole: read back, it is the one that was fitted."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.files import InputError, to_toml
from wheelhop.report.model_file import write_model

TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
PLAIN = st.one_of(st.floats(allow_nan=False), TEXT, st.lists(TEXT, max_size=3))
TABLE = st.dictionaries(TEXT.filter(bool), PLAIN, max_size=4)


def test_the_file_holds_the_fitted_model(friction, tmp_path):
    file, steps = tmp_path / "model.toml", friction.diagnosis.ladder
    file.write_text("an older one")
    write_model(file, friction.campaign, friction.vehicle, steps)
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]
    found = tomllib.loads(file.read_text(encoding="utf-8"))
    model = steps[-1].rung.model
    assert found["format"] == 1
    assert found["vehicle_name"] == friction.vehicle.name
    assert [rung["added"] for rung in found["ladder"]] == [[], ["dry-friction"]]
    assert found["ladder"][1]["error_validate"] == steps[1].rung.error_validate
    assert [effect["id"] for effect in found["effect"]] == ["dry-friction"]
    parameters = found["effect"][0]["parameters"]
    for name, value in model.theta(model.effects[0]).items():
        assert parameters[name] == value
        assert parameters[f"{name}_uncertainty"] == steps[-1].parameters[f"dry-friction.{name}"][1]
    for name in friction.vehicle.values:
        table = found["vehicle"]
        *groups, last = name.split(".")
        for group in groups:
            table = table[group]
        assert table[last] == model.values[name]
        assert table[f"{last}_uncertainty"] > 0
    for run in found["run"]:
        own = model.runs[run["id"]]
        assert (run["speed_m_s"], run["start_m"]) == (own["speed_m_s"], own["start_m"])


def test_a_file_that_cannot_be_written_leaves_the_old_one(friction, tmp_path, monkeypatch):
    file = tmp_path / "model.toml"
    file.write_text("an older one")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match="No space"):
        write_model(file, friction.campaign, friction.vehicle, friction.diagnosis.ladder)
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]
    assert file.read_text() == "an older one"


@given(
    st.fixed_dictionaries(
        {"plain": PLAIN, "table": TABLE, "nested": st.dictionaries(TEXT, TABLE, max_size=3)},
        optional={"array": st.lists(TABLE.map(lambda t: t | {"x": 1.0}), min_size=1, max_size=3)},
    )
)
def test_any_table_is_read_back_by_a_toml_reader(document):
    found = tomllib.loads(to_toml(document))
    tables = {k: v for k, v in document["nested"].items() if v}
    expected = {**document, "nested": tables}
    assert found == {k: v for k, v in expected.items() if v != {}}  # empty tables are left out

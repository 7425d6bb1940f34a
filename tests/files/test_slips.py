"""Slips of the pen in a file are recognised: decimal commas, keys of another unit."""

import pytest

from wheelhop.cli.main import main
from wheelhop.files import InputError, parse_toml, read_toml


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 7,5\n", "line 1: 7,5 has a decimal comma: TOML takes a point, 7.5"),
        ("a = 1\nx=-0,25 # m\n", "line 2: -0,25 has a decimal comma"),
        ("t = { x = 7,5 }\n", "line 1: 7,5 has a decimal comma"),
    ],
)
def test_a_decimal_comma_is_told(tmp_path, text, said):
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(InputError, match=r"x\.toml") as caught:
        read_toml(tmp_path / "x.toml")
    assert said in str(caught.value)


@pytest.mark.parametrize("text", ["x = \n", "x = [1, 2\n", 'x = "7,5\n', "x = 7;5\n"])
def test_other_mistakes_are_not_called_a_comma(tmp_path, text):
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(InputError, match="not valid TOML"):
        read_toml(tmp_path / "x.toml")


def test_what_is_missing_is_told_with_how_it_was_written(tmp_path):
    table = parse_toml("speed_kmh = 7.5\nrolle = 'fit'\nid = 'a'\n", tmp_path / "x.toml")
    missing = table.needs(("speed_kmph", "role", "id", "track"))
    assert missing == ["speed_kmph (not speed_kmh)", "role (not rolle)", "track"]


def test_a_misspelt_option_is_told(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["diagnose", "c", "--max-effect", "2", "--buget", "3"])
    assert stopped.value.code == 2
    assert "--buget 3, did you mean '--budget'" in capsys.readouterr().err

"""Bash completes commands, options and files, as the parser has them."""

import subprocess

import pytest

from wheelhop.cli.main import main

pytest.importorskip("shtab")


def completed(script, line, folder):
    """What bash would offer at the end of a line."""
    words = " ".join(f"'{word}'" for word in line)
    asked = f"""
source '{script}'
COMP_WORDS=({words}); COMP_CWORD={len(line) - 1}; COMP_LINE="${{COMP_WORDS[*]}}"
COMP_POINT=${{#COMP_LINE}}
$(complete -p wheelhop | sed 's/.*-F \\([^ ]*\\).*/\\1/') wheelhop '{line[-1]}' '{line[-2]}'
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
    done = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        (["di"], {"diagnose"}),
        (["compare", "--re"], {"--report"}),
        (["campaign", "st"], {"stretches"}),
        (["import", "--to", ".p"], {".parquet"}),
        (["check", "my-c"], {"my-campaign"}),
    ],
)
def test_bash_offers_what_fits(line, offered, tmp_path, capsys):
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "script.sh"
    script.write_text(capsys.readouterr().out)
    (tmp_path / "my-campaign").mkdir()
    assert set(completed(script, ["wheelhop", *line], tmp_path)) == offered

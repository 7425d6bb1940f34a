"""A command that is started in a campaign's folder runs nothing that lies there."""

import subprocess
import sys
from pathlib import Path

from wheelhop.cli.main import main

ROOT = Path(__file__).parents[2]
SCRIPT = """
import sys
from wheelhop.cli.main import main
if __name__ == "__main__":
    sys.exit(main())
"""


def test_processes_take_no_module_from_the_folder_they_are_started_in(tmp_path):
    """multiprocessing starts `python -c`, which looks in the working folder first. The command that
    pip installs, a script elsewhere, does not."""
    folder, marker, command = tmp_path / "campaign", tmp_path / "was-run", tmp_path / "wheelhop"
    folder.mkdir()
    command.write_text(SCRIPT)
    (folder / "pickle.py").write_text(f"open({str(marker)!r}, 'w').close()\n")
    words = ["simulate", str(ROOT / "examples/clean/vehicle.toml"), "--tracks", "washboard/low"]
    words += ["--seconds", "2", "--jobs", "1", "--sweep", "speed=5:10:2", "--out", "made.parquet"]
    run = [sys.executable, str(command), *words]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    assert not marker.exists(), done.stderr
    assert done.returncode == 0, done.stderr
    assert (folder / "made.parquet").exists()


def test_settings_of_numba_in_the_folder_are_refused_in_a_line(tmp_path, monkeypatch, capsys):
    (tmp_path / ".numba_config.yaml").write_text("cache_dir: theirs\n")
    monkeypatch.chdir(tmp_path)
    assert main(["version"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and str(tmp_path / ".numba_config.yaml") in error

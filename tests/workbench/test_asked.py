"""What a recording does not say: asked on the page as import asks it, and kept with the draft."""

from pathlib import Path

import pytest

from tests.workbench.test_draft import write_foreign
from wheelhop.files import InputError
from wheelhop.workbench.draft import Draft
from wheelhop.workbench.kept import keep, resume


def without_time(folder: Path, name="drive.csv") -> Path:
    """One of the drives, of which nothing says when its rows were taken."""
    lines = write_foreign(folder, 1)[0].read_text().splitlines()
    file = folder / name
    file.write_text("\n".join(line.partition(";")[2] for line in lines) + "\n")
    return file


def test_what_a_file_does_not_say_is_asked_as_import_asks_it(tmp_path):
    draft, file = Draft(tmp_path / "draft"), without_time(tmp_path)
    draft.add(file)
    assert draft.waiting == file and not draft.files and not draft.columns
    assert [question.key for question in draft.asked] == ["rate_hz"]
    for wrong in ("often", "0"):
        with pytest.raises(InputError, match="is no number of samples a second"):
            draft.answer({"rate_hz": wrong})
        assert draft.waiting == file and not draft.said
    draft.answer({"rate_hz": "100"})
    assert draft.waiting is None and draft.files == [file] and len(draft.columns) == 8
    draft.read()
    assert draft.recordings[file].rate_hz == 100.0
    keep(draft)
    again = resume(draft.folder, None)
    assert again.files == [file] and not again.asked
    draft.clear()
    assert not draft.said and not draft.asked


def test_files_that_arrive_while_one_is_asked_about_wait_for_the_answer(tmp_path):
    draft = Draft(tmp_path / "draft")
    files = [without_time(tmp_path, name) for name in ("a.csv", "b.csv", "c.csv")]
    for file in files:
        draft.add(file)
    assert draft.waiting == files[0] and not draft.files
    draft.answer({"rate_hz": "100"})
    draft.read()
    assert draft.files == files and len(draft.recordings) == 3

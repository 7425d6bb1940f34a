"""Cards with a life of their own: edited on a PC, or changed for another, while a session runs."""

import dataclasses

import pytest

from tests.firmware.promises.logger import configure, faults_of
from tests.firmware.promises.reader import acknowledgement, read_log
from wheelhop.hil_sim import CardImage, ramp

CONFIG = b"size_mb = 1\nstream = on\nrate = 200\n"
PHOTO = bytes(range(256)) * 6000  # longer than the log was: it lies where that lay


def formatted(card, _):
    """Quick-formatted, and a photo copied onto it."""
    again = CardImage.fat32(card.path)
    again.write("HOP.CFG", CONFIG)
    again.write("PHOTO.JPG", PHOTO)
    return card


def moved_off(card, _):
    """The log was moved to the PC, and a photo copied."""
    card.delete("HOP00001.HOP")
    card.write("PHOTO.JPG", PHOTO)
    return card


def twin(_, folder):
    """Another card with the same identification."""
    other = CardImage.fat32(folder / "twin.img")
    other.write("HOP.CFG", CONFIG)
    other.write("PHOTO.JPG", PHOTO)
    return other


def twin_with_a_log(card, folder):
    """One that was imaged from this one before the session."""
    other = twin(card, folder)
    other.write("HOP00001.HOP", PHOTO)
    return other


@pytest.mark.parametrize("edit", [formatted, moved_off, twin, twin_with_a_log])
def test_what_is_not_ours_is_never_written_and_the_session_goes_on(logger, card, tmp_path, edit):
    card.write("HOP.CFG", CONFIG)
    one = logger(card, signals=ramp(100, 10))
    assert one.command("start").ok
    one.run(2.0)
    one.board.insert(None)
    out_s = one.board.time
    one.run(1.0)
    first = read_log(card.read("HOP00001.HOP"))
    edited = edit(card, tmp_path)
    begin = len(one.frames)
    one.board.insert(edited)
    one.until(lambda: any(f.kind == "B" for f in one.frames[begin:]), 10.0)
    one.run(1.0)
    assert one.command("status").values["state"] == "recording"
    assert one.command("stop").ok

    assert edited.read("PHOTO.JPG") == PHOTO
    if edit is twin_with_a_log:
        assert edited.read("HOP00001.HOP") == PHOTO
    assert faults_of(edited) == []
    told = {}
    for frame in one.frames:
        if frame.kind == "B":
            ack = acknowledgement(frame)
            assert ack.session != first.session or frame.time_s < out_s
            told[ack.session] = ack
    second = read_log(edited.read("HOP00002.HOP"))
    assert second.header["continues"] == f"{first.session:08X}"
    assert second.summary is not None and second.summary["end"] == "command"
    for log in (first, second):
        numbers = {block.number for block in log.blocks}
        assert set(range(told[log.session].blocks)) <= numbers
        assert len(log.scans) >= told[log.session].written > 0
    ends = [text for text in one.texts("S") if text.startswith("end=")]
    assert ends == ["end=gone", "end=command"]


def test_a_photo_copied_beside_the_log_harms_neither(logger, card):
    """The log's own place was not touched; the session goes on in it, or in the next file."""
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    one.board.insert(None)
    card.write("PHOTO.JPG", PHOTO)
    one.board.insert(card)
    one.run(3.0)
    assert one.command("stop").ok
    assert card.read("PHOTO.JPG") == PHOTO and faults_of(card) == []
    logs = [one.log(name) for name in sorted(card.files()) if name.startswith("HOP0")]
    assert sum(len(log.scans) for log in logs) > 200
    assert all(log.summary is not None for log in logs)


def test_a_card_edited_before_stop_is_told_and_not_written(logger, card):
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    one.board.insert(None)
    card.delete("HOP00001.HOP")
    card.write("PHOTO.JPG", PHOTO)
    before = card.path.read_bytes()
    one.board.insert(card)
    reply = one.command("stop", 30.0)
    assert not reply.ok and reply.text.startswith("no such file")
    assert card.path.read_bytes() == before
    summary = one.summary()
    assert summary["end"] == "gone"
    assert int(summary["due"]) == int(summary["written"]) + int(summary["lost"])
    one.run(10.0)
    assert one.command("status").values["state"] == "ready"


def test_a_file_left_open_on_a_card_that_was_changed_for_another_is_closed(logger, card, tmp_path):
    """The card is changed across a reset; later it comes back."""
    other = configure(CardImage.fat32(tmp_path / "other.img"), "size_mb = 1\n")
    other = dataclasses.replace(other, serial=2)
    one = logger(card)
    assert one.command("start").ok
    one.run(1.5)
    one.board.insert(other)
    one.board.reset("external")
    one.run(4.0)
    assert one.command("stop").ok
    assert sorted(other.files()) == ["HOP.CFG", "HOP00002.HOP"]
    one.board.insert(card)
    one.run(1.0)
    assert one.command("list", 30.0).ok
    assert one.log("HOP00001.HOP").summary["end"] == "recovered"

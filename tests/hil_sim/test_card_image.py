"""Images of cards: what mkfs.vfat, fsck.vfat and mtools make and say, and our reader agrees."""

import random

import pytest

from wheelhop.hil_sim import CardImage, SimulationError
from wheelhop.hil_sim.fat import Fat

MAKERS = {
    "FAT32": lambda path: CardImage.fat32(path),
    "FAT32, partition": lambda path: CardImage.fat32(path, partitioned=True),
    "FAT32, large": lambda path: CardImage.fat32(path, 4096),
    "FAT16": lambda path: CardImage.fat16(path),
    "FAT16, partition": lambda path: CardImage.fat16(path, partitioned=True),
}


@pytest.fixture(params=MAKERS)
def card(request, tmp_path):
    try:
        return MAKERS[request.param](tmp_path / "card.img")
    except SimulationError as error:
        pytest.skip(str(error))


def test_a_new_card_is_sound_and_empty(card):
    assert card.check() == ""
    assert card.files() == {} and card.listing() == ""


def test_files_written_by_mtools_are_read_back(card):
    random.seed(1)
    files = {f"F{i}.BIN": random.randbytes(size) for i, size in enumerate((0, 1, 512, 70_000))}
    for name, data in files.items():
        card.write(name, data)
    assert card.files() == {name: len(data) for name, data in files.items()}
    for name, data in files.items():
        assert card.read(name) == data
        assert card.read(name, 100) == data[:100]
    assert card.check() == ""
    with pytest.raises(SimulationError, match=r"no file NONE\.TXT"):
        card.read("NONE.TXT")


def test_what_is_broken_is_found(card):
    card.write("A.BIN", bytes(5000))
    sound = Fat(card.path, card.start)
    with card.path.open("r+b") as file:  # chain of the file cut off after its first cluster
        file.seek(sound._fats[0] + (4 if sound.is_fat32 else 2) * 3)
        file.write(bytes(8))
    assert card.check() != ""


def test_type_follows_from_the_number_of_clusters(tmp_path):
    card = CardImage.fat32(tmp_path / "a.img")
    assert Fat(card.path, 0).is_fat32
    card = CardImage.fat16(tmp_path / "b.img")
    assert not Fat(card.path, 0).is_fat32
    with pytest.raises(SimulationError, match="no FAT file system"):
        CardImage.unformatted(tmp_path / "c.img").files()


def test_a_full_card_has_what_was_left(tmp_path):
    card = CardImage.fat32(tmp_path / "card.img")
    card.fill(leave=10_000)
    assert 9_000 < Fat(card.path, 0).free_bytes() <= 10_000
    assert card.check() == ""


def test_a_reserved_card_is_full_without_data(tmp_path):
    card = CardImage.fat32(tmp_path / "card.img")
    card.reserve(leave=10_000)
    assert 9_000 < Fat(card.path, 0).free_bytes() <= 10_000
    assert card.check() == ""
    assert card.path.stat().st_blocks * 512 < 4 << 20


@pytest.mark.parametrize("free_run", [1, 7, 200])
def test_a_fragmented_card_has_no_long_free_run(tmp_path, free_run):
    card = CardImage.fat32(tmp_path / "card.img")
    card.fragment(free_run)
    table = Fat(card.path, 0)._table()[2:]
    longest = max(map(len, "".join(".#"[int(entry != 0)] for entry in table).split("#")))
    assert longest == free_run
    assert card.check() == ""


def test_exfat_is_recognised_as_such(tmp_path):
    card = CardImage.exfat(tmp_path / "card.img")
    boot = card.read_block(card.start)
    assert boot[3:11] == b"EXFAT   " and boot[510:] == b"\x55\xaa" and boot[11:64] == bytes(53)
    assert card.read_block(0)[446 + 4] == 7


def test_a_copy_is_the_same_card(tmp_path):
    card = CardImage.fat32(tmp_path / "a.img", partitioned=True)
    card.write("A.TXT", b"hello")
    copy = card.copy(tmp_path / "b.img")
    assert (copy.kind, copy.start) == (card.kind, card.start)
    copy.write("A.TXT", b"other")
    assert card.read("A.TXT") == b"hello" and copy.read("A.TXT") == b"other"

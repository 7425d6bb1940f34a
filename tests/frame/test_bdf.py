"""Beams from Nastran's bulk data, beside what pyNastran 1.4.1 says, which wrote the files."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.files import InputError
from wheelhop.frame import (
    Frame,
    assemble,
    dofs_of,
    free_modes,
    mass_properties,
    read_frame,
    solve_static,
)
from wheelhop.frame.bdf import read_bdf

DATA = Path(__file__).parents[1] / "data/nastran"
TRUTH = json.loads((DATA / "truth.json").read_text())
CORNERS = {"FL": "10", "FR": "20", "RL": "30", "RR": "40"}
BEAM = """\
$ a cantilever in free fields
GRID,1,,0.,0.,0.
GRID,2,,1000.,0.,0.
CBAR,1,5,1,2,0.,0.,1.
PBAR,5,3,150.,2.+4,1.1+4,1.9E4
MAT1,3,2.05+5,,.29,7.85-9
CONM2,9,2,,2.D-3
"""


def frame_from(path, units="mm-t-s"):
    found = read_bdf(path, units)
    return Frame(
        "", found.material, found.sections, found.nodes, found.tubes, found.masses, CORNERS
    )


@pytest.mark.parametrize("fields", ["small", "large", "double", "free"])
def test_a_frame_is_what_it_is_in_all_formats(fields, tmp_path):
    file = DATA / f"{fields}.bdf"
    if fields == "free":
        file = tmp_path / "free.bdf"
        lines = (DATA / "small.bdf").read_text().splitlines()
        cut = [[line[i : i + 8].strip() for i in range(0, len(line), 8)] for line in lines]
        free = [",".join(c) if line[0] != "$" else line for c, line in zip(cut, lines, strict=True)]
        file.write_text("SOL 103\nCEND\nBEGIN BULK\n" + "\n".join(free) + "\nENDDATA\nnothing\n")
    frame = frame_from(file)
    for name, section in frame.sections.items():
        if name in TRUTH:
            wanted = [TRUTH[name][key] for key in ("A", "I1", "I2")]
            found = [1e6 * section.area_m2, 1e12 * section.Iz_m4, 1e12 * section.Iy_m4]
            assert found == pytest.approx(wanted, rel=1e-9), name
    assert set(frame.sections) == {str(number) for number in range(1, 8)}
    assert len(frame.nodes) == 7  # what only shows a direction is no part of the frame
    mass = mass_properties(assemble(frame))
    assert mass.mass_kg == pytest.approx(1e3 * TRUTH["mass"], rel=1e-9)
    assert mass.centre_m == pytest.approx(1e-3 * np.array(TRUTH["cg"]), rel=1e-6)
    other = free_modes(assemble(frame_from(DATA / "small.bdf")), 3).frequency_hz
    assert free_modes(assemble(frame), 3).frequency_hz == pytest.approx(other, rel=1e-6)


@pytest.mark.parametrize(("aim", "second_mm4"), [("0.,0.,1.", 2e4), ("0.,1.,0.", 1.1e4)])
def test_plane_1_holds_the_orientation_vector(aim, second_mm4, tmp_path):
    file = tmp_path / "beam.bdf"
    file.write_text(BEAM.replace("0.,0.,1.", aim))
    found = read_bdf(file, "mm-t-s")
    names = dict.fromkeys(("FL", "RL"), "1") | dict.fromkeys(("FR", "RR"), "2")
    frame = Frame("", found.material, found.sections, found.nodes, found.tubes, (), names)
    elements = assemble(replace(frame, element_m=2.0))
    load = np.zeros(12)
    load[6 + 2] = 1.0
    moved = solve_static(elements, load, dofs_of([0])).displacement[6 + 2]
    assert moved == pytest.approx(1.0 / (3 * 2.05e11 * second_mm4 * 1e-12), rel=1e-6)
    assert found.masses[0].mass_kg == pytest.approx(2.0)


MISTAKES = {
    "other element": ("CONM2,9", "CROD,2,5,1,2\nCONM2,9", "line 7: CROD: is not read"),
    "no length": ("2,,1000.,0.,0.", "2,,0.,0.,0.", "CBAR: 1 from 1 to 2 has no length"),
    "no grid": ("5,1,2,0.", "5,1,7,0.", "there is no GRID 7"),
    "no property": ("PBAR,5", "PBAR,6", "there is no property 5"),
    "no material": ("MAT1,3", "MAT1,4", "there is no MAT1 3"),
    "coordinate system": ("GRID,2,,", "GRID,2,4,", "basic coordinate system"),
    "offset": ("0.,0.,1.", "0.,0.,1.,\n,,,,,,10.", "pins and offsets"),
    "pin": ("0.,0.,1.", "0.,0.,1.,\n,456", "pins and offsets"),
    "along": ("0.,0.,1.", "1.,0.,0.", "orientation vector points along it"),
    "negative mass": ("2.D-3", "-2.D-3", "must not be negative"),
    "offset mass": ("2.D-3", "2.D-3,5.", "put a node there"),
    "no number": ("2.05+5", "2.05x5", "field 3 = '2.05x5' is not a number"),
    "no density": (",7.85-9", "", "field 6 = '' is not a number"),
    "product": ("1.9E4", "1.9E4,\n,\n,,,5.", "I12 is not 0"),
    "extra mass": ("1.9E4", "1.9E4,.2", "NSM is not read"),
    "twice": ("MAT1", "GRID,2,,7.,0.,0.\nMAT1", "number 2 is used twice"),
    "include": ("MAT1", "INCLUDE 'x.bdf'\nMAT1", "put all cards into one file"),
    "nothing": ("CBAR", "$CBAR", "holds no CBAR or CBEAM"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_not_understood_is_a_line(mistake, tmp_path):
    old, new, said = MISTAKES[mistake]
    assert old in BEAM
    file = tmp_path / "beam.bdf"
    file.write_text(BEAM.replace(old, new))
    with pytest.raises(InputError) as error:
        read_bdf(file, "mm-t-s")
    assert said in str(error.value)
    assert str(file) in str(error.value) and "\n" not in str(error.value)


FRAME = """format = 1
name = "from Nastran"
bdf = "small.bdf"
bdf_units = "mm-t-s"
[interface]
"""


def test_a_frame_s_file_names_the_bulk_data_and_its_corners(tmp_path):
    (tmp_path / "small.bdf").write_text((DATA / "small.bdf").read_text())
    nodes = read_bdf(DATA / "small.bdf", "mm-t-s").nodes
    by_x = sorted(nodes, key=lambda name: -nodes[name][0])
    front = sorted(by_x[:2], key=lambda name: -nodes[name][1])
    rear = sorted(by_x[-2:], key=lambda name: -nodes[name][1])
    corners = dict(zip(("FL", "FR", "RL", "RR"), front + rear, strict=True))
    lines = "".join(f'{corner} = "{node}"\n' for corner, node in corners.items())
    file = tmp_path / "frame.toml"
    file.write_text(FRAME + lines)
    assert mass_properties(assemble(read_frame(file))).mass_kg == pytest.approx(
        1e3 * TRUTH["mass"], rel=1e-9
    )
    for old, new, said in (
        ('"mm-t-s"', '"mm-kg-s"', "did you mean 'm-kg-s'"),
        ("small.bdf", "other.bdf", "other.bdf"),
        ("[interface]", "[material]\nE_GPa = 1\n[interface]", "unknown key"),
        (f'"{front[0]}"', '"99"', "there is no node"),
    ):
        file.write_text((FRAME + lines).replace(old, new))
        with pytest.raises(InputError, match=r"frame\.toml") as error:
            read_frame(file)
        assert said in str(error.value)

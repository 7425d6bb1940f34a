"""Let pyNastran print modes as Nastran does: python make_f06.py MODES.json OUT.f06

For an environment of its own, as pyNastran 1.4.1 asks for numpy before 2. MODES.json holds points,
cycles (k), generalised masses (k) and shapes (k, points, 6).
"""

import json
import sys

import numpy as np
from pyNastran.op2.tables.lama_eigenvalues.lama_objects import RealEigenvalues
from pyNastran.op2.tables.oug.oug_eigenvectors import RealEigenvectorArray

with open(sys.argv[1], encoding="utf-8") as file:
    modes = json.load(file)
cycles, mass = np.array(modes["cycles"]), np.array(modes["mass"])
number = np.arange(1, len(cycles) + 1)
square = (2 * np.pi * cycles) ** 2
values = RealEigenvalues("", "LAMA", len(cycles))
for i in range(len(cycles)):
    found = square[i], square[i] ** 0.5, cycles[i], mass[i], square[i] * mass[i]
    values.add_f06_line((number[i], number[i], *found), i)
grid = np.array([[point, 1] for point in modes["points"]], dtype="int32")
shapes = np.array(modes["shapes"], dtype="float32")
vectors = RealEigenvectorArray.add_modal_case(
    "OUGV1", grid, shapes, 1, number, square.astype("float32"), cycles.astype("float32")
)
stamp = "1    A FRAME                         NOVEMBER  24, 2026  MSC.NASTRAN  6/17/05   PAGE %5i\n"
with open(sys.argv[2], "w", encoding="ascii") as out:
    page = values.write_f06(out, [" \n"], stamp, 1)
    vectors.write_f06(out, [" \n"], page_stamp=stamp, page_num=page + 1)

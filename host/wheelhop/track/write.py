"""Writing surveys: two wheel paths or a grid as CSV, a grid as OpenCRG (Adams: `rdf`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.files import replacing
from wheelhop.track.track import Array

RECORD = 80  # bytes, to whose multiple OpenCRG pads its data with NaN
EVEN = 1e-6  # of the spacing


def write_paths(file: Path, x_m: Array, left_m: Array, right_m: Array) -> None:
    """Write two wheel paths (n,) at the stations x (n,) as the CSV that campaigns read."""
    table = np.column_stack([x_m, left_m, right_m])
    with replacing(file, CampaignError) as draft:
        np.savetxt(draft, table, "%.9g", ",", header="x_m,left_m,right_m", comments="")


def write_grid(file: Path, x_m: Array, y_m: Array, height_m: Array) -> None:
    """Write a grid (n, k) as CSV: x_m and the y of each column, m, in the header; NaN is empty."""
    with (
        replacing(file, CampaignError) as draft,
        draft.open("w", encoding="ascii", newline="\n") as out,
    ):
        out.write(",".join(["x_m", *(f"{y:.9g}" for y in y_m)]) + "\n")
        for x, row in zip(x_m.tolist(), height_m.tolist(), strict=True):
            cells = ("" if np.isnan(height) else f"{height:.9g}" for height in row)
            out.write(",".join([f"{x:.9g}", *cells]) + "\n")


def write_opencrg(file: Path, u_m: Array, v_m: Array, height_m: Array) -> None:
    """Write a grid (n, k), m, as OpenCRG 1.2, code KDBI: big-endian doubles, NaN where unknown.

    `u_m` (n,) are the stations and `v_m` (k,) the places across, positive to the left, both
    increasing at equal steps. The reference line is straight. Raises CampaignError for other grids.
    """
    steps = [_step(name, values) for name, values in (("u", u_m), ("v", v_m))]
    header = [
        "$CT",
        "written by wheelhop",
        "$ROAD_CRG",
        f"reference_line_start_u = {u_m[0]:.12g}",
        f"reference_line_end_u = {u_m[-1]:.12g}",
        f"reference_line_increment = {steps[0]:.12g}",
        f"long_section_v_right = {v_m[0]:.12g}",
        f"long_section_v_left = {v_m[-1]:.12g}",
        f"long_section_v_increment = {steps[1]:.12g}",
        "$",
        "$KD_DEFINITION",
        "#:KDBI",
        f"U:reference line u,m,{u_m[0]:.12g},{steps[0]:.12g}",
        *(f"D:long section {number},m" for number in range(1, len(v_m) + 1)),
        "$",
        "$" * RECORD,
    ]
    data = np.ascontiguousarray(height_m, ">f8").tobytes()
    data += np.full(-len(data) % RECORD // 8, np.nan, ">f8").tobytes()
    with replacing(file, CampaignError) as draft:
        draft.write_bytes("\n".join(header).encode("ascii") + b"\n" + data)


def _step(name: str, values: Array) -> float:
    spacing = np.diff(values)
    if len(spacing) == 0 or not (spacing > 0).all() or np.ptp(spacing) > EVEN * spacing.max():
        raise CampaignError(f"OpenCRG: {name} must increase at equal steps")
    return float((values[-1] - values[0]) / len(spacing))

"""The tables beside the transfer functions, and the headline: the usual quarter car and ours."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wheelhop.campaign.proving_ground import proving_ground, table_5_1
from wheelhop.identify import published
from wheelhop.identify.row import KINDS, make_row
from wheelhop.identify.thesis_tables import quarter_cars, table_rows, usual_quarter_car


@pytest.fixture(scope="module")
def rows():
    return list(table_rows())


def one(rows, table, what):
    (found,) = [row for row in rows if row.table == table and row.what == what]
    return found


def test_the_usual_quarter_car_obeys_its_equations():
    """(1.1) and (1.2), the damper of the tyre on the unsprung mass, by another integrator."""
    q = published.TABLE_2_5
    m, w = q["sprung_kg"], q["unsprung_kg"]
    k, c, kt, ct = (q[name] for name in ("strut_N_m", "strut_N_s_m", "tyre_N_m", "tyre_N_s_m"))

    def rate(t, z):
        x, dx, y, dy = z
        u, du = np.sin(9 * t) ** 2, 9 * np.sin(18 * t)
        strut = k * (y - x) + c * (dy - dx)
        return [dx, strut / m, dy, (kt * (u - y) + ct * (du - dy) - strut) / w]

    truth = solve_ivp(rate, (0, 2.0), np.zeros(4), rtol=1e-9, atol=1e-12, t_eval=[0.3, 1.1, 2.0])
    system = usual_quarter_car()
    found = solve_ivp(
        lambda t, z: system.a @ z + system.b[:, 0] * np.sin(9 * t) ** 2,
        (0, 2.0), np.zeros(4), rtol=1e-9, atol=1e-12, t_eval=[0.3, 1.1, 2.0],
    )  # fmt: skip
    assert system.c[0] @ found.y == pytest.approx(truth.y[0], rel=1e-6)


def test_other_wheels_hold_the_body_as_the_headline_says(rows):
    """Figure 2.21: 1.68, then 1; and 1.19, then 0.76."""
    for name in ("usual", "generalized"):
        for what in ("peak", "final"):
            found = one(rows, "fig 2.21", f"{name} quarter car, {what}")
            assert found.ours == pytest.approx(found.printed, rel=0.01)
    assert one(rows, "fig 2.21", "generalized quarter car, peak").kind == "prediction"
    cars = quarter_cars()
    assert cars["usual"].static()[0, 0] == pytest.approx(1.0)
    assert cars["generalized"].static()[0, 0] < 0.8


def test_all_tables_without_transfer_functions_are_there(rows):
    wanted = {"2.5", "A.1", "3.2", "3.3", "4.1", "4.3", "4.3.3", "4.4", "4.5", "4.6", "4.7", "4.8"}
    assert {row.table for row in rows} == wanted | {"5.1", "5.4", "fig 2.21", "C.4"}
    assert {row.kind for row in rows} <= set(KINDS)
    off = [row for row in rows if not abs(row.ours - row.printed) <= 0.01 * abs(row.printed)]
    assert all(row.reason for row in off)
    assert {row.table for row in off} <= {"3.2", "3.3", "4.8", "C.4"}


def test_the_driven_ruler_is_away_from_resonance(rows):
    """Appendix C says that damping does not matter at 15 Hz."""
    ratio = one(rows, "C.4", "free end at 15 Hz, loss factor 0.02 over none").ours
    assert ratio == pytest.approx(1.00057, abs=2e-5)
    assert one(rows, "C.4", "100 gf, N").ours == pytest.approx(0.980665)


def test_the_eighteen_tests_are_those_of_table_5_1():
    assert set(published.TABLE_5_1) == set(table_5_1())
    assert sum(map(len, published.TABLE_5_1.values())) == 18
    for name in table_5_1():
        assert proving_ground()[name].speeds_kmph == published.TABLE_5_1[name]


def test_the_two_models_of_a_bushing_are_alike(rows):
    """Both were fitted to one set of points: within 1 % in stiffness, 3 % in loss."""
    for row in (row for row in rows if row.table == "3.2"):
        limit = 0.03 if "loss" in row.what else 0.01 if "stiffness" in row.what else 0.012
        assert row.ours == pytest.approx(row.printed, rel=limit)


def test_a_road_made_of_table_4_8_is_as_rough(rows):
    assert one(rows, "4.8", "C, m³").ours == pytest.approx(6.7e-4, rel=0.05)
    assert one(rows, "4.8", "w").ours == pytest.approx(1.36, abs=0.03)


def test_a_reason_stands_only_where_numbers_differ():
    assert make_row("1.1", "x", 100.0, 100.9, "fit", "why").reason == ""
    assert make_row("1.1", "x", 100.0, 101.1, "fit", "why").reason == "why"

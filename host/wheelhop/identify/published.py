"""Numbers printed in the thesis (H. Kanchwala, Studies in simplified dynamic modeling and
characterization of vehicle suspensions), in SI: what ours are held against."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wheelhop.identify.sections import Sections

TABLE_5_2 = Sections(
    2 * np.pi * np.array([2.37, 4.92, 10.41, 27.46]), np.array([0.31, 0.33, 0.18, 0.73])
)
"""Poles of H(s) fitted to the field tests."""

D2_DENOMINATOR = np.array([1, 305.1, 5e4, 3.3e6, 2.3e8, 6.8e9, 2e11, 2e12, 2.7e13])
"""Appendix D.2.1, highest power first."""

D2_NUMERATORS = np.array(
    [
        [-0.4, 72.1, -3.9e4, 3.9e6, -9.1e8, -3.6e5, 5.5e4, 1.5e13],
        [-0.3, 47.8, -3.1e4, 2.6e6, -6.5e8, 1.7e4, 5.6e4, 6e12],
        [-0.1, -11.1, -7.1e3, -4.3e5, -1.4e8, -1.6e6, 1e4, 5.8e12],
        [0.3, 72.2, 4.5e4, 2.4e6, 5.8e8, -5e6, -6e4, -4.8e12],
        [-0.2, -87.1, 3.6e4, -1e7, 1e9, 4.2e6, -1.6e5, 1.2e13],
        [0.4, 38.7, 3.5e4, 6e6, 16e7, -4.1e3, -6.7e4, 5e12],
    ]
)
"""Appendix D.2.1: H11, H12, H13, H14, H33, H34, highest power (s⁷) first, as printed."""

TABLE_2_1 = {
    1: ((3.546, 13.894),),
    2: ((1.708, 12.425), (4.452, 17.042)),
    3: ((1.559, 12.365), (3.079, 17.257), (5.909, 16.659)),
}
"""σ and ω, 1/s and rad/s, of 1, 2, 3 damped sinusoids fitted to the step responses."""

TABLE_A_2 = {
    1: ((2.11, 14.72),),
    2: ((1.88, 17.88), (1.90, 12.26)),
    3: ((1.52, 12.28), (2.41, 18.29), (4.29, 13.40)),
}
"""Their first guesses from an incremental linear model."""

TABLE_2_2 = {"old": (25e3, 30e3, 500.0, 750.0), "new": (23.6e3, 34.9e3, 620.0, 760.0)}
"""K front, K rear, N/m, C front, C rear, N·s/m, of chapter 2's racing car."""

TABLE_2_3 = {"front": (45.0, 250e3, 50.0), "rear": (50.0, 275e3, 60.0)}
"""Unsprung mass, kg, tyre stiffness, N/m, and damping, N·s/m, of the same car."""

FIGURE_2_19_KG = (60.0, 65.0)
"""Unsprung masses, front and rear, of the same car in the caption of figure 2.19."""

SPRUNG_MASS_KG = 548.0
FRONT_SHARE = 0.5
"""Of its weight: section 2.11 calls the two ends "almost equal"."""

TABLE_2_4 = ((33.75, 14.3, 13.2), (45.0, 12.4, 11.8), (56.25, 11.1, 10.9))
"""Unsprung mass, kg; wheel hop by (2.27) and from the poles of G_red, Hz."""

G_RED = (
    np.array([8.3e-3, 1.1, 2.1e2, 2.6e4, 1.1e6, 8.9e6, 1.9e8]),
    np.array([1.0, 2.9e1, 6.2e3, 7.6e4, 2.8e6, 1.3e7, 2.5e8]),
)
"""Appendix A.4: numerator and denominator of the reduced G11, highest power first."""

PEAKS_HZ = (1.8, 2.6, 10.3)
"""Section 2.8: peaks of |G_red|."""

G_11_STATIC = (4.1e60, 5.4e60)
"""Appendix A.4: last coefficients of numerator and denominator of the full G11."""

ATV = {
    "mass_kg": 228.0,
    "pitch_inertia_kg_m2": 62.0,
    "roll_inertia_kg_m2": 25.0,
    "wheelbase_m": 1.42,
    "track_width_m": 1.18,
    "cg_to_front_axle_m": 0.80,
    "front_N_m": 25e3,
    "rear_N_m": 15e3,
}
"""The vehicle of chapters 4 and 5: body as in the examples' vehicle.toml, stiffness of one strut's
spring and not at the wheel (Table 4.1)."""

ATV_MASS_KG = 220.0
"""Of the same vehicle without its driver, who has 65 kg in section 4.1.2 and 75 in
4.3.1."""

TABLE_5_3 = {"front": (15.0, 40e3, 200.0), "rear": (12.5, 40e3, 200.0)}
TABLE_5_4 = {"old": (10.5e3, 6.5e3, 630.0, 590.0), "new": (12.6e3, 7.8e3, 630.0, 590.0)}
H_RED = (
    np.array([-0.1, 46.7, -4.6e3, 1.9e5, 3.9e7, -3.2e8, 1.1e10, -8.3e11]),
    np.array([1.0, 75.1, 9.6e3, 4e5, 2.4e7, 4.9e8, 1.4e10, 1e11, 1.5e12]),
)
"""Appendix D.2.2: the reduced H_n,11. A wheel that rises lowers the body: the sign is wrong."""
H_RED_ORDER = 10
"""The order that the appendix states for it."""
H_N_11_STATIC = (-4.2e105, 7.9e105)

TABLE_D_1 = {"pitch": 3.03, "bounce": 4.93, "roll": 4.95, "wheel hop": 10.56, "twist": 26.49}
"""Simple estimates of the modes, Hz, under the names that they have there: `thesis.simple_modes`
has others."""

TABLE_2_5 = {
    "sprung_kg": 137.0,
    "unsprung_kg": 45.0,
    "strut_N_m": 23.6e3,
    "tyre_N_m": 250e3,
    "strut_N_s_m": 620.0,
    "tyre_N_s_m": 50.0,
}
"""The usual quarter car of figures 1.4 and 2.21."""

FIGURE_2_21 = {"usual": (1.68, 1.0), "generalized": (1.19, 0.76)}
"""Peak and final value of the body's response to a step of 1; the peaks are read off."""

TABLE_A_1 = (25e3, 30e3, 500.0, 750.0)
"""First estimates of the struts: K front, K rear, N/m, C front, C rear, N·s/m."""

TABLE_3_2 = (
    (529.720, 0.056, 485.635, 1019.674, 26.861, 2.625),
    (649.802, 0.048, 355.167, 1002.370, 28.931, 2.304),
    (855.702, 0.090, 44.132, 904.701, 59.552, 13.658),
    (894.934, 0.089, -54.369, 839.987, 61.474, 14.078),
    (517.930, 0.060, -109.340, 413.357, 26.932, 3.069),
    (365.390, 0.078, 23.210, 389.852, 24.116, 4.086),
    (441.464, 0.060, 132.586, 576.690, 23.094, 2.758),
    (433.754, 0.050, 185.934, 620.944, 20.043, 1.770),
)
"""Two specimens each of four bushings: A₀, β, M₀ of the modified power law, A₀, A₁, A₂ of the
logarithmic polynomial, N/mm."""

TABLE_3_3 = {
    "modified power law": (529.72, 0.06, 485.64),
    "fractional Kelvin-Voigt": (615.72, 392.49, 0.09),
    "four-parameter fractional": (899.72, 1.82, 8.2e-6, 0.19),
}
"""The first specimen: A₀, β, M₀; E₀, E₁, α of (3.42); E₀, k, τ, α of (3.43); N/mm, s."""

TABLE_4_1 = {"front": (25e3, 1500.0, 10.5e3, 630.0), "rear": (15e3, 1360.0, 6.5e3, 590.0)}
"""K, N/m, and C, N·s/m, of the component, then at the wheel."""

TABLE_4_3 = {"front": (15.0, 40e3, 200.0), "rear": (12.5, 40e3, 200.0)}
"""Unsprung mass, kg, tyre stiffness, N/m, and damping, N·s/m: Table 5.3's again."""

OTHER_TRACKS: Mapping[str, Mapping[str, float]] = {
    "sine-sweep/thesis": {
        "amplitude_mm": 15.0,
        "pitch_start_mm": 400.0,
        "pitch_end_mm": 600.0,
        "length_mm": 24e3,
    },
    "half-sine-bump/thesis": {"amplitude_mm": 200.0, "length_mm": 1000.0},
    "step-bump/thesis": {"height_mm": 80.0, "width_mm": 200.0},
}
"""Table 4.4's last line, and the bumps of section 4.3.3."""

TABLE_4_4 = {
    "washboard/low": (15.0, 400.0),
    "washboard/high": (25.0, 600.0),
    "one-sided-washboard/low": (15.0, 400.0),
    "one-sided-washboard/high": (25.0, 600.0),
    "herringbone/low": (10.0, 500.0),
    "herringbone/medium": (15.0, 600.0),
    "herringbone/high": (20.0, 800.0),
    "chassis-twist/low": (150.0, 2000.0),
    "chassis-twist/medium": (175.0, 3000.0),
    "chassis-twist/high": (200.0, 4000.0),
}
"""Amplitude and pitch of tracks, mm."""

TABLES_4_5_TO_4_7: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "4.5": {"washboard/low": (7.5, 9.5), "washboard/high": (11.0, 13.0)},
    "4.6": {
        "herringbone/low": (9.0, 14.0),
        "herringbone/medium": (21.0, 25.0),
        "herringbone/high": (14.0, 19.0),
    },
    "4.7": {
        "chassis-twist/low": (7.5, 15.5),
        "chassis-twist/medium": (6.5, 21.5),
        "chassis-twist/high": (5.5, 14.5),
    },
}
"""Speeds, km/h."""

TABLE_5_1: Mapping[str, tuple[float, ...]] = {
    **TABLES_4_5_TO_4_7["4.5"],
    "herringbone/low": (9.0, 14.0),
    "herringbone/medium": (21.0, 25.0),
    "herringbone/high": (14.0, 19.0),
    "chassis-twist/low": (7.5, 15.5),
    "chassis-twist/medium": (6.5, 21.5),
    "chassis-twist/high": (5.5, 14.5),
    "one-sided-washboard/low": (7.0,),
    "one-sided-washboard/high": (13.0,),
}
"""Speeds of all eighteen tests, km/h, by track."""

TABLE_4_8 = (6.7e-4, 1.36)
"""Degree of unevenness C, m³, and waviness w of the pave."""

BEAM_M = (0.6096, 0.0254, 0.000635)
"""Length, width and thickness of appendix C's ruler: 24, 1 and 1/40 inch."""
BEAM_HZ, BEAM_FORCE_GF = 15.0, 100.0
"""What drives it at its free end; a footnote takes the force for 1 N."""

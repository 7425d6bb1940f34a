"""Transfer matrices from data, and what they say of the vehicle they were measured on."""

from wheelhop.identify.export import (
    poles_and_residues,
    polynomials,
    state_space,
    to_json,
    write_mat,
    write_mat_of_states,
)
from wheelhop.identify.frf import Frf, frf, frf_h1
from wheelhop.identify.identify import identify
from wheelhop.identify.judge import Judged, judge
from wheelhop.identify.linear import Linearity, linearity
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.predicted import Predicted, predict
from wheelhop.identify.quarter_car import (
    Bushings,
    Part,
    Struts,
    Wheels,
    compliance,
    on_wheels,
    other_suspensions,
    rigid_inertia,
    wheel_hop_hz,
)
from wheelhop.identify.row import Row
from wheelhop.identify.sections import Sections
from wheelhop.identify.select import Candidate, best, candidate, of_orders, relaxed
from wheelhop.identify.spectra import Measured, Spectra, measure, not_excited, spectra
from wheelhop.identify.statespace import StateSpace, balanced_reduction, of_fractions
from wheelhop.identify.steps import DampedSinusoids, fit_damped_sinusoids, incremental_model
from wheelhop.identify.steps_file import StepResponses, read_steps
from wheelhop.identify.structure import Structure, Suspensions, suspensions
from wheelhop.identify.study import (
    HALVES,
    Car,
    Variant,
    WheelHop,
    car_of,
    car_of_steps,
    check_stable,
    study,
)
from wheelhop.identify.thesis import thesis_rows

__all__ = [
    "HALVES",
    "Bushings",
    "Candidate",
    "Car",
    "DampedSinusoids",
    "Frf",
    "Judged",
    "Linearity",
    "Measured",
    "Part",
    "Predicted",
    "Row",
    "Sections",
    "Spectra",
    "StateSpace",
    "StepResponses",
    "Structure",
    "Struts",
    "Suspensions",
    "TransferMatrix",
    "Variant",
    "WheelHop",
    "Wheels",
    "balanced_reduction",
    "best",
    "candidate",
    "car_of",
    "car_of_steps",
    "check_stable",
    "compliance",
    "fit_damped_sinusoids",
    "frf",
    "frf_h1",
    "identify",
    "incremental_model",
    "judge",
    "linearity",
    "measure",
    "not_excited",
    "of_fractions",
    "of_orders",
    "on_wheels",
    "other_suspensions",
    "poles_and_residues",
    "polynomials",
    "predict",
    "read_steps",
    "relaxed",
    "rigid_inertia",
    "spectra",
    "state_space",
    "study",
    "suspensions",
    "thesis_rows",
    "to_json",
    "wheel_hop_hz",
    "write_mat",
    "write_mat_of_states",
]

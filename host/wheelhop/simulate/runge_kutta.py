"""The scheme by which motion is integrated in time: the classical Runge–Kutta method.

Four stages, fourth order; W. Kutta, Beitrag zur näherungsweisen Integration totaler
Differentialgleichungen, Zeitschrift für Mathematik und Physik 46 (1901) 435. The names are those of
E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993,
eq. II.1.8 and table II.1.2: stage i takes the rate k_i at t + c_i dt, in the state that k_{i-1}
leads to; the step is dt (k_1 + 2 k_2 + 2 k_3 + k_4) / 6.
"""

STAGES = 4
HALF_STEPS = (0, 1, 1, 2)
"""2 c_i: what moves the mechanism from outside is given at every half step."""
TO_NEXT = (0.5, 0.5, 1.0, 0.0)
"""a_{i+1, i}: how far along its rate a stage sends the next one."""
WEIGHTS = (1.0, 2.0, 2.0, 1.0)
TOTAL = 6.0
"""WEIGHTS[i] / TOTAL = b_i: what a stage's rate is worth in the step."""

STABLE = 2.0
"""No step is longer than this over the fastest pole: from 2.8 on what is left of the start grows
from step to step (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed.,
section IV.2)."""

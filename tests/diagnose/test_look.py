"""What later looks ask of an earlier one, and what it takes to answer."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnose.test_judge import noise, rung
from wheelhop.diagnose.judge import Rung, log_odds
from wheelhop.diagnose.look import Candidate, Look
from wheelhop.diagnose.screen import Screened
from wheelhop.fit import Fit
from wheelhop.fit.result import Derivatives


def with_columns(fit: Fit) -> Fit:
    """The same with a shared number's derivatives in every run."""
    runs = [replace(r, derivatives=Derivatives([np.ones(len(r.residual))], 1)) for r in fit.runs]
    return replace(fit, runs=tuple(runs))


def remembered(rung: Rung) -> Rung:
    screened = Screened(None, {}, 0.0, 0.0, 0.0, 0.0, {"0": np.ones(9)}, np.zeros((0, 0)))
    look = Look(rung, (screened,), (Candidate(screened, rung, 0.0, 1, True),), None)
    after = look.remembered()
    assert not after.screened and not after.candidates[0].screened.contribution
    return after.candidates[0].rung


@pytest.mark.parametrize(("held_out", "kept"), [(1, 1), (2, 0)])
def test_derivatives_are_kept_only_where_few_held_out_runs_judge(held_out, kept):
    """One run of ten seconds does not judge by itself, and the fitted ones need derivatives to be
    foreseen (`judge.left_out`). Two do: to keep them would take tens of megabytes a model."""
    rng = np.random.default_rng(3)
    loud, quiet = (rung(noise(rng, size)[:held_out]) for size in (2.0, 1.0))
    loud, quiet = (replace(r, validation=with_columns(r.validation)) for r in (loud, quiet))
    after = remembered(quiet)
    assert [len(run.derivatives.columns) for run in after.judging.runs] == [kept] * held_out
    assert after.evidence == quiet.evidence
    assert log_odds(loud, after) == log_odds(loud, quiet) > 1.0

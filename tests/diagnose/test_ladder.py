"""Which effects get a full fit where none holds."""

from types import SimpleNamespace

from wheelhop.diagnose import ladder


def test_where_none_holds_the_fitted_runs_say_which_is_fitted_in_full(monkeypatch):
    """Strong friction bends the baseline so far that a quick fit with it goes astray: it leaves
    most of the runs held out of all, and least of those fitted. A full fit straightens it."""
    evidence = {"seat": 1.0, "spring": 2.0, "gain": 3.0, "skew": 4.0, "friction": 5.0}
    candidates = [
        SimpleNamespace(
            id=name,
            holds=False,
            screened=None,
            tried=1,
            rung=SimpleNamespace(id=name, fit=SimpleNamespace(evidence=e), error_judging=e),
        )
        for name, e in evidence.items()
    ]
    fitted = []

    def refit(workshop, rung, ahead):
        fitted.append(rung.id)
        return rung

    monkeypatch.setattr(ladder, "refit", refit)
    monkeypatch.setattr(ladder, "at_noise", lambda rung, noise: True)
    monkeypatch.setattr(ladder, "_judged", lambda incumbent, screened, rung, tried: candidates[4])
    monkeypatch.setattr(ladder, "_best_first", lambda some, noise: list(some))
    incumbent = SimpleNamespace(workshop=SimpleNamespace(noise=0.0), rung=None)
    ladder._refit_leaders(incumbent, candidates, True, lambda text: None)
    assert sorted(fitted) == ["friction", "gain", "skew"]
    fitted.clear()
    ladder._refit_leaders(incumbent, candidates, False, lambda text: None)
    assert fitted == []

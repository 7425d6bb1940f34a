"""How the error depends on one number of the fitted model: a sweep of the front damping."""

from pathlib import Path
from tempfile import mkdtemp

import pandas as pd

import wheelhop as wh

NAME = "suspension.front.damping_N_s_m"

campaign = wh.read(Path(__file__).parents[1] / "clean").select(
    "washboard-low-slow", "washboard-high-fast", "herringbone-low-fast"
)
fitted = wh.compare(campaign)
best = fitted.model.values[NAME]
print(f"fitted: {best:.0f} N s/m")

# Nothing is fitted again: all other numbers stay as they are.
errors = {
    damping: fitted.with_values({NAME: damping}).error_fit
    for damping in (best * factor for factor in (0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5, 2.0))
}
sweep = pd.Series(errors, name="error_fit").rename_axis("damping_N_s_m")
print(sweep)
print(f"least error at {sweep.idxmin():.0f} N s/m")

figure = sweep.plot(logy=True, ylabel="error E on the runs fitted", marker="o").figure
file = Path(mkdtemp()) / "sweep.png"
figure.savefig(file, dpi=150)
print(f"figure: {file}")

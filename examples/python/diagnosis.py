"""Which physics the model of a campaign is missing, and how sure that is.

A part of an example campaign, so that it takes seconds; leave out `select` for all of it.
"""

from pathlib import Path
from tempfile import mkdtemp

import wheelhop as wh

campaign = wh.read(Path(__file__).parents[1] / "open-dry-friction").select(
    "washboard-high-fast", "washboard-high-slow"
)

found = wh.diagnose(campaign, max_effects=1)
print(found.verdict, f"{100 * found.confidence:.0f} %")
print(*found.explanation, sep="\n")

print(found.ranking()[["screened_error", "confirmed_error", "log_evidence"]].head())
print(found.ladder())

out = Path(mkdtemp())
found.write_report(out / "report.html")
wh.plot(found, "worst").savefig(out / "worst.png", dpi=150)
print(f"report and figure are in {out}")

"""Add an effect to the model and watch the error fall, or not."""

from pathlib import Path

import wheelhop as wh

campaign = wh.read(Path(__file__).parents[1] / "open-dry-friction").select(
    "washboard-high-fast", "washboard-high-slow"
)

# The wrong effect first: what is missing is no bump stop, and the error says so.
for effect in ("bump-stop", "dry-friction"):
    fitted = wh.compare(campaign, effect)
    print(fitted.ladder().to_string(), "\n")

print(fitted.parameters().filter(like="dry-friction", axis=0))
# wh.add(campaign, "dry-friction") would also store the model beside campaign.toml.

"""Settings for every test."""

import os

# Tests run beside each other: one thread of linear algebra each, before numpy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings

# On slow machines how long one example takes says nothing.
settings.register_profile("wheelhop", deadline=None)
settings.load_profile("wheelhop")

"""Settings for every test."""

from hypothesis import settings

# Tests run beside each other on slow machines: how long one example takes says nothing.
settings.register_profile("wheelhop", deadline=None)
settings.load_profile("wheelhop")

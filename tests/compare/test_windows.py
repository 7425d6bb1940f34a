"""Our windows beside those of scipy.signal, which takes long to import."""

import numpy as np
import pytest
from scipy import signal

from wheelhop.compare.windows import blackman_harris, hann


@pytest.mark.parametrize("n", [7, 8, 1000])
@pytest.mark.parametrize(("ours", "name"), [(hann, "hann"), (blackman_harris, "blackmanharris")])
def test_windows_are_those_of_scipy(ours, name, n):
    np.testing.assert_allclose(ours(n), signal.get_window(name, n), rtol=0.0, atol=1e-12)

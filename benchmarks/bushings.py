"""How long fits of bushings take, beside pyvisco's Prony fit: python -m benchmarks.bushings

Eight specimens with the curves of Table 3.2 and 1 % noise, 1–30 Hz. Processor seconds, one thread,
median of repeats; J is the logarithmic error (3.41). pyvisco needs `pip install pyvisco`.
"""

from __future__ import annotations

import contextlib
import io
import os
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from wheelhop.material import (
    MODELS,
    GeneralizedMaxwell,
    ModifiedPowerLaw,
    ModulusData,
    candidates,
    fit_modulus,
    log_error,
    read_rig_data,
)

FOLDER = Path(__file__).parents[1] / "examples/bushings"
REPEATS = 5


def main() -> None:
    """Print the table."""
    data = [read_rig_data(file).moduli for file in sorted(FOLDER.glob("bushing-*.csv"))]
    print(f"{len(data)} specimens, {len(data[0].omega)} frequencies in the first")
    print(f"{'':44s} {'processor, ms':>13s} {'rms, %':>7s}")
    for name, make in MODELS.items():
        model = make(data[0].omega)
        seconds, fit = timed(partial(fit_modulus, model, data[0]))
        line(f"one specimen, {name}", seconds, fit.error, len(data[0].omega))
    model = ModifiedPowerLaw()
    seconds, _ = timed(lambda: fit_modulus(model, data[0]).half_widths())
    line("one specimen, modified power law, intervals", seconds)
    seconds, _ = timed(lambda: all_models(data), 3)
    line(f"8 specimens, {len(MODELS)} models, intervals", seconds)
    seconds, _ = timed(lambda: [candidates(each) for each in data], 1)
    line("the same, and five held-out fits of each", seconds)
    peer(data[0])


def all_models(data: Sequence[ModulusData]) -> None:
    """Every model of every specimen, with its intervals."""
    for each in data:
        for make in MODELS.values():
            fit_modulus(make(each.omega), each).half_widths()


def peer(data: ModulusData) -> None:
    """pyvisco's Prony fit of the same data, with its own number of terms and with ours."""
    try:
        import pandas as pd
        from pyvisco import prony
    except ImportError:
        print("pyvisco is not installed: pip install pyvisco")
        return
    frame = pd.DataFrame({"f": data.frequency_hz, "omega": data.omega})
    for name, part in (("stor", data.modulus.real), ("loss", data.modulus.imag)):
        frame[f"E_{name}"] = frame[f"E_{name}_filt"] = part
    frame.domain, frame.modul, frame.RefT = "freq", "E", 20.0
    ours = len(GeneralizedMaxwell.over(data.omega).times_s)
    for terms in (0, ours):

        def run(terms: int = terms) -> dict[str, object]:
            with contextlib.redirect_stdout(io.StringIO()):
                found: dict[str, object] = prony.fit(
                    prony.discretize(frame, "round", terms), frame, opt=True
                )[0]
            return found

        seconds, found = timed(run, 3)
        terms_found = found["df_terms"]
        phase = 1j * data.omega[:, None] * terms_found["tau_i"].to_numpy()
        strength = terms_found["E_i"].to_numpy()
        modulus = found["E_0"] - strength.sum() + (phase / (1 + phase)) @ strength
        error = log_error(modulus, data.modulus)
        line(f"pyvisco, {len(strength)} terms, times free", seconds, error, len(data.omega))


def timed(job: Callable[[], Any], repeats: int = REPEATS) -> tuple[float, Any]:
    """Median processor seconds, and what came out."""
    taken = []
    for _ in range(repeats):
        begin = time.process_time()
        result = job()
        taken.append(time.process_time() - begin)
    return statistics.median(taken), result


def line(label: str, seconds: float, error: float = np.nan, frequencies: int = 1) -> None:
    """Print one line."""
    rms = 100 * np.sqrt(error / (2 * frequencies))
    shown = f"{rms:7.2f}" if np.isfinite(rms) else ""
    print(f"{label:44s} {1e3 * seconds:13.1f} {shown}", flush=True)


if __name__ == "__main__":
    main()

"""A result as one file: saved whole, and loaded without running anything that stands in it.

The file is a zip archive: `about.json` says what it is and which wheelhop wrote it, `result.json`
is what `--json` of the command writes, `model.toml` the fitted model, both for any other program;
`state` is the result itself in Python's pickle format. A pickle may call whatever it names. Here it
may name only what `_Reader` knows: numpy's arrays, and the classes that results are made of, which
hold data. Effects of a user's own are not in the file: their code comes from the user again.
"""

from __future__ import annotations

import io
import json
import pickle
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import is_dataclass
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wheelhop.compare import InBand
from wheelhop.diagnose.score import Exact
from wheelhop.effects import Effect, More, load_effects
from wheelhop.effects.own_file import MODULE
from wheelhop.files import InputError, check_room, quoted, read_bytes, replacing
from wheelhop.fit import Work, Workshop
from wheelhop.report.model_file import model_text
from wheelhop.simulate import HeightSeries, RigSimulator, RunSimulator
from wheelhop.track import Track

if TYPE_CHECKING:
    from wheelhop.api.result import Result
    from wheelhop.api.results import ComparisonResult, DiagnosisResult

FORMAT = 1
PICKLE = 5
UNPACKED = 3.0
"""Bytes of memory for each byte of the state: as it is unpacked, and what it becomes."""
PACKAGES = (
    *("campaign", "compare", "diagnose", "effects", "fit", "gate", "identify", "logger.recording"),
    *("simulate", "track", "vehicle", "api.results"),
)
"""Where the classes are that results are made of. None of them does anything when it is made."""
WORKING = (InBand, Workshop, Work, RunSimulator, RigSimulator, HeightSeries, Exact)
"""Classes with a state of their own."""
OTHERS = {
    ("builtins", "slice"),
    ("builtins", "set"),
    ("builtins", "frozenset"),
    ("builtins", "complex"),
    ("datetime", "date"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
    ("pathlib", "PosixPath"),
    ("pathlib", "WindowsPath"),
}


def save(result: Result, file: Path) -> None:
    """Write a result; what stood there is replaced whole or not at all. Raises InputError."""
    about = {
        "format": FORMAT,
        "kind": type(result).__name__,
        "wheelhop": version("wheelhop"),
        "campaign": result.campaign.title,
        "effects": sorted(_own(result)),
    }
    try:
        state = pickle.dumps(result, PICKLE)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(
            f"{file}: cannot be written: {error}; an effect of your own must be a class of a module"
        ) from None
    with replacing(file) as draft, zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("about.json", json.dumps(about, indent=2, ensure_ascii=False))
        archive.writestr("result.json", json.dumps(result.to_json(), ensure_ascii=False))
        archive.writestr("model.toml", model_text(result.campaign, result.vehicle, result.steps))
        archive.writestr("state", state)


def load(file: str | Path, effects: More = None) -> ComparisonResult | DiagnosisResult:
    """Read a result that `save` has written.

    Nothing that stands in the file is run: a file of somebody else may be loaded.

    Parameters
    ----------
    file
        Such as "result.wheelhop".
    effects
        Where effects of the user's own come from that the result was made with, as for `compare`.

    Returns
    -------
    ComparisonResult or DiagnosisResult
        As it was, in SI, ready to be asked, drawn and changed.

    Raises
    ------
    InputError
        The file is missing, damaged or no result, was written by another version of wheelhop, or
        needs effects that are not given. Its result.json and model.toml can be read in any case: it
        is a zip archive.
    """
    path = Path(file)
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(path))) as archive:
            about = json.loads(archive.read("about.json"))
            _check(path, about)
            check_room(path, UNPACKED * archive.getinfo("state").file_size)
            state = archive.read("state")
    except InputError:
        raise
    except (zipfile.BadZipFile, KeyError, ValueError, OSError) as error:
        raise InputError(
            f"{path}: is no whole result of wheelhop: {error}; save it again"
        ) from None
    reader = _Reader(io.BytesIO(state), path, load_effects(effects).values())
    try:
        result: ComparisonResult | DiagnosisResult = reader.load()
    except InputError:
        raise
    except Exception as error:  # damage may turn a pickle into anything
        raise InputError(f"{path}: is damaged: {error}; save it again") from None
    return result


def _check(path: Path, about: Mapping[str, Any]) -> None:
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise InputError(f"{path}: is no result that this wheelhop reads; save it again")
    ours = version("wheelhop")
    if about.get("wheelhop") != ours:
        raise InputError(
            f"{path}: was written by wheelhop {about.get('wheelhop')}, and this is {ours}: load it"
            " there, or compare again; its model.toml can be read with read_model in any version"
        )


def _own(result: Result) -> set[str]:
    """The effects of the result's models that wheelhop does not bring."""
    models = [step.rung.model for step in result.steps]
    every = [effect for model in models for effect in model.effects]
    return {effect.id for effect in every if not type(effect).__module__.startswith("wheelhop.")}


class _Reader(pickle.Unpickler):
    """Reads the state, and nothing else."""

    def __init__(self, state: io.BytesIO, path: Path, effects: Iterable[Effect]) -> None:
        super().__init__(state)
        self._path = path
        self._effects = {(type(e).__module__, type(e).__qualname__): type(e) for e in effects}

    def find_class(self, module: str, name: str) -> Any:
        """A class that results are made of. Raises InputError for anything else."""
        if (module, name) in self._effects:
            return self._effects[module, name]
        package = module.removeprefix("wheelhop.")
        ours = package != module and any(
            package == each or package.startswith(f"{each}.") for each in PACKAGES
        )
        if (module, name) in OTHERS or (ours and name.isidentifier()):
            found = getattr(import_module(module), name, None)
            if (module, name) in OTHERS or _holds_data(found, module):
                return found
        if module.startswith((MODULE, "__main__")) or not module.startswith("wheelhop"):
            raise InputError(
                f"{self._path}: was made with {quoted(name)} of {module[:60]}, which is not given:"
                " load it with effects=, the effects of your own it was made with, unchanged"
            )
        raise InputError(f"{self._path}: names {module}.{name}, which is no part of a result")


def _holds_data(found: object, module: str) -> bool:
    """Whether it is a class of that module whose objects hold data: a dataclass, an effect, a
    track, or one of `WORKING`."""
    if not isinstance(found, type) or found.__module__ != module:
        return False
    return is_dataclass(found) or issubclass(found, (Effect, Track, *WORKING))

"""`export`: a known car for other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from wheelhop.campaign import CampaignError
from wheelhop.effects import Effect, More, load_effects

if TYPE_CHECKING:
    from wheelhop.export.plant import Plant
    from wheelhop.simulate import Model

FMU, MAT = ".fmu", ".mat"


def export(
    car: str | Path,
    file: str | Path | None = None,
    add: str | Sequence[str] = (),
    *,
    effects: More = None,
) -> Plant:
    """A car between signals: ground and actuators in, accelerations, travel and tyre forces out.

    `Plant.linear` is its state space, with the force laws cut open by name, and
    `Plant.linear.to_control()` that of python-control.

    Parameters
    ----------
    car
        The folder of a campaign in which `add` has stored model.toml, a model.toml, or a
        vehicle.toml.
    file
        Where to write it: a functional mock-up unit for co-simulation, FMI 2.0 (.fmu), or matrices
        and names for MATLAB (.mat); nowhere by default.
    add
        Effects that the car has besides, in words as `wheelhop simulate` takes them.
    effects
        The library, as for `compare`.

    Returns
    -------
    Plant
        What was exported: equations, and signals of the car, in SI.

    Raises
    ------
    CampaignError
        The car or an effect is not known, the model has masses that stand upright, a law is more
        than arithmetic, or the file cannot be written.
    """
    from wheelhop.export.fmu import write_fmu
    from wheelhop.export.plant import longest_step, plant_of

    suffix = None if file is None else Path(file).suffix.lower()
    if suffix not in (None, FMU, MAT):
        raise CampaignError(f"{file}: the name must end in {FMU} or {MAT}")
    words = [add] if isinstance(add, str) else add
    model, name = _model(Path(car), words, load_effects(effects))
    plant = plant_of(model)
    if file is not None and suffix == MAT:
        plant.linear.write_mat(Path(file))
    elif file is not None and not write_fmu(plant, longest_step(model), name, Path(file)):
        raise CampaignError(
            f"{file}: has the sources alone: there is no C compiler (cc) on this machine, or it is"
            " none that is known; the importing tool has to compile them"
        )
    return plant


def _model(car: Path, add: Sequence[str], library: Mapping[str, Effect]) -> tuple[Model, str]:
    """The model of a car with effects added, and the car's name."""
    from wheelhop.predict.case import model_of
    from wheelhop.predict.drives import read_effects
    from wheelhop.predict.known_car import read_car

    known = read_car(car, library)
    there = {one.effect.id for one in known.effects}
    more = read_effects(add, library)
    for one in more:
        if one.effect.id in there:
            raise CampaignError(f"--with {one.effect.id}: the car has it already")
    return model_of(known.vehicle, (*known.effects, *more)), known.vehicle.name

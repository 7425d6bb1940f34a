"""A model for other programs: linear state space with named laws, and a functional mock-up unit."""

from wheelhop.export.fmu import write_fmu
from wheelhop.export.plant import Linear, Plant, plant_of

__all__ = ["Linear", "Plant", "plant_of", "write_fmu"]

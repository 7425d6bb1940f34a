"""Laws: the force a model is missing, in free form and as a formula."""

from wheelhop.law.formula import Formula, source_of
from wheelhop.law.free import Form, FreeForce
from wheelhop.law.look import look
from wheelhop.law.moved import Moved
from wheelhop.law.places import Where, places
from wheelhop.law.rival import Rival
from wheelhop.law.rungs import BeyondNames, LastRungs
from wheelhop.law.search import Found, find_law

__all__ = [
    "BeyondNames",
    "Form",
    "Formula",
    "Found",
    "FreeForce",
    "LastRungs",
    "Moved",
    "Rival",
    "Where",
    "find_law",
    "look",
    "places",
    "source_of",
]

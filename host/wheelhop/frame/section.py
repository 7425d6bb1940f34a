"""What tubes are made of: material and cross-section."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi


@dataclass(frozen=True)
class Material:
    """A linear, isotropic material."""

    young_Pa: float
    shear_Pa: float
    density_kg_m3: float

    @property
    def poisson(self) -> float:
        """ν = E / 2G − 1."""
        return self.young_Pa / (2 * self.shear_Pa) - 1


@dataclass(frozen=True)
class Section:
    """A cross-section about its centroid: y and z are its principal axes, x runs along the tube."""

    area_m2: float
    Iy_m4: float  #: second moment of area about y: bending in the x–z plane
    Iz_m4: float  #: about z: bending in the x–y plane
    J_m4: float  #: torsion constant
    shear_coefficient: float  #: κ: the shear force is κ G A times the mean shear strain


def round_tube(outer_m: float, wall_m: float, poisson: float) -> Section:
    """The section of a round tube; of a bar, if the wall is the radius.

    κ is that of G. R. Cowper, "The shear coefficient in Timoshenko's beam theory", J. Appl. Mech.
    33 (1966) 335, hollow circle: with m the ratio of the inner to the outer radius

        κ = 6(1 + ν)(1 + m²)² / ((7 + 6ν)(1 + m²)² + (20 + 12ν) m²)
    """
    outer, inner = outer_m / 2, outer_m / 2 - wall_m
    second = pi / 4 * (outer**4 - inner**4)
    m2 = (inner / outer) ** 2
    shared = (1 + m2) ** 2
    kappa = 6 * (1 + poisson) * shared / ((7 + 6 * poisson) * shared + (20 + 12 * poisson) * m2)
    return Section(pi * (outer**2 - inner**2), second, second, 2 * second, kappa)


RECTANGLE_SHEAR = 5 / 6


def bar(width_m: float, height_m: float) -> Section:
    """A rectangle, its height along y and its width along z.

    J within 0.5 %: W. C. Young, R. G. Budynas, Roark's Formulas for Stress and Strain, 7th ed.
    (McGraw-Hill 2002), table 10.1, case 4.
    """
    long, short = max(width_m, height_m), min(width_m, height_m)
    ratio = short / long
    torsion = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))
    second_y, second_z = height_m * width_m**3 / 12, width_m * height_m**3 / 12
    return Section(width_m * height_m, second_y, second_z, torsion, RECTANGLE_SHEAR)


def box(width_m: float, height_m: float, flange_m: float, web_m: float) -> Section:
    """A hollow rectangle, its height along y; the flanges lie along z, at top and bottom.

    J after Bredt, of the wall's middle line. κ is the webs' share of the area, which carry a force
    along y; a force along z has the flanges' share, which is near it for a square.
    """
    hole_width, hole_height = width_m - 2 * web_m, height_m - 2 * flange_m
    area = width_m * height_m - hole_width * hole_height
    second_y = (height_m * width_m**3 - hole_height * hole_width**3) / 12
    second_z = (width_m * height_m**3 - hole_width * hole_height**3) / 12
    middle_width, middle_height = width_m - web_m, height_m - flange_m
    around = 2 * (middle_width / flange_m + middle_height / web_m)
    torsion = 4 * (middle_width * middle_height) ** 2 / around
    return Section(area, second_y, second_z, torsion, 2 * web_m * middle_height / area)

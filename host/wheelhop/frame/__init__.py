"""Tubular space frames: beam finite elements, modes, torsional stiffness, reduction."""

from wheelhop.frame.assemble import FiniteElements, assemble, dofs_of
from wheelhop.frame.corners import FIXED_MODES, CornerModes, corner_modes, read_corner_modes
from wheelhop.frame.error import FrameError
from wheelhop.frame.model import CORNERS, Frame, PointMass, Tube
from wheelhop.frame.modes import Modes, free_modes
from wheelhop.frame.read import read_frame
from wheelhop.frame.reduce import Reduced, reduce
from wheelhop.frame.rigid import MassProperties, mass_properties, rigid_modes, rigid_motions
from wheelhop.frame.section import Material, Section, round_tube
from wheelhop.frame.statics import Static, floating, solve_static
from wheelhop.frame.twist import FrameTwist, frame_twist, torsional_stiffness, warp

__all__ = [
    "CORNERS",
    "FIXED_MODES",
    "CornerModes",
    "FiniteElements",
    "Frame",
    "FrameError",
    "FrameTwist",
    "MassProperties",
    "Material",
    "Modes",
    "PointMass",
    "Reduced",
    "Section",
    "Static",
    "Tube",
    "assemble",
    "corner_modes",
    "dofs_of",
    "floating",
    "frame_twist",
    "free_modes",
    "mass_properties",
    "read_corner_modes",
    "read_frame",
    "reduce",
    "rigid_modes",
    "rigid_motions",
    "round_tube",
    "solve_static",
    "torsional_stiffness",
    "warp",
]

"""Tracks: the ground's elevation, and the path of a wheel that rolls over it."""

from wheelhop.track.envelope import CannotClimb, Envelope, wheel_envelope
from wheelhop.track.profiles import make_track
from wheelhop.track.track import Track
from wheelhop.track.wheel import Wheel, WheelPath

__all__ = ["CannotClimb", "Envelope", "Track", "Wheel", "WheelPath", "make_track", "wheel_envelope"]

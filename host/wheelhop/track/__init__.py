"""Tracks: the ground's elevation, and the path of a wheel that rolls over it."""

from wheelhop.track.envelope import Envelope, wheel_envelope
from wheelhop.track.profiles import make_track
from wheelhop.track.track import Track

__all__ = ["Envelope", "Track", "make_track", "wheel_envelope"]

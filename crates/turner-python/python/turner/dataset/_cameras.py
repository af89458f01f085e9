"""Rows of cameras around a scene."""

from __future__ import annotations

import math

from .._cameras import Orbit


def orbit(count, elevation=20.0, *, start=0.0, distance=None, fov=None):
    """`count` cameras once around the scene at one height.

    elevation: degrees above the horizon. start: azimuth of the first, degrees. distance, fov: as for `Camera.orbit`; without
    a distance each camera frames the scene.
    """
    if count < 1:
        raise ValueError(f"count is {count}; expected 1 or more")
    return [Orbit(start + 360.0 * i / count, elevation, distance, fov) for i in range(count)]


def hemisphere(count, *, lowest=5.0, highest=85.0, distance=None, fov=None):
    """`count` cameras spread evenly over the part of a hemisphere between two elevations, degrees (a Fibonacci spiral)."""
    if count < 1:
        raise ValueError(f"count is {count}; expected 1 or more")
    low, high = (math.sin(math.radians(angle)) for angle in (lowest, highest))
    golden = 180.0 * (3.0 - math.sqrt(5.0))
    heights = [low + (high - low) * (i + 0.5) / count for i in range(count)]
    return [Orbit(golden * i % 360.0, math.degrees(math.asin(y)), distance, fov) for i, y in enumerate(heights)]

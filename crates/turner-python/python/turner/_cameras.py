"""Cameras: where they stand, and those of computer vision."""

from __future__ import annotations

from ._classes import Description


class Sized:
    """A camera with the size of its picture in pixels."""

    __slots__ = ("camera", "width", "height")

    def __init__(self, camera, width, height):
        self.camera = camera
        self.width = int(width)
        self.height = int(height)

    def _edits(self):
        return {"camera": self.camera, "film.width": self.width, "film.height": self.height}

    def __repr__(self):
        return f"Sized({self.camera!r}, {self.width}, {self.height})"


class Orbit:
    """A camera that frames the scene from a direction: `Camera.orbit`."""

    __slots__ = ("azimuth", "elevation", "distance", "fov")

    def __init__(self, azimuth, elevation, distance=None, fov=None):
        self.azimuth = float(azimuth)
        self.elevation = float(elevation)
        self.distance = None if distance is None else float(distance)
        self.fov = None if fov is None else float(fov)

    def _edits(self):
        parts = [self.azimuth, self.elevation] + ([] if self.distance is None else [self.distance])
        edits = {"studio.camera": "orbit:" + ",".join(f"{part:.17g}" for part in parts)}
        if self.fov is not None:
            edits["studio.fov"] = self.fov
        return edits

    def __repr__(self):
        return f"Camera.orbit({self.azimuth:g}, {self.elevation:g}, distance={self.distance}, fov={self.fov})"


class Camera(Description):
    """A camera. Its classes are `PinholeCamera`, `ThinLensCamera`, …; these functions make them."""

    _family = "camera"
    __slots__ = ()

    @staticmethod
    def orbit(azimuth, elevation, distance=None, fov=None):
        """A camera that frames the whole scene.

        azimuth: degrees to the right of +z. elevation: degrees above the horizon.
        distance: from the centre, in radii of the scene; by default such that the silhouette fills the picture.
        fov: field of view of the shorter side, degrees.
        """
        return Orbit(azimuth, elevation, distance, fov)

    @staticmethod
    def look_at(position, target, up=(0, 1, 0), fov=40.0):
        """A pinhole camera at `position` that looks at `target`, both (x, y, z) in scene units. fov: vertical, degrees."""
        from ._classes import classes

        position, target, up = ([float(v) for v in p] for p in (position, target, up))
        return classes()["PinholeCamera"](position=position, look_at=target, up=up, fov=float(fov))

    @staticmethod
    def from_opencv(K, world_to_camera, width, height, near=0.0):
        """The camera of OpenCV: x right, y down, z forward.

        K: (3, 3), focal lengths and principal point in pixels; the centre of the first pixel is at (0.5, 0.5).
        world_to_camera: (3, 4) or (4, 4), a rotation and a translation.
        width, height: of the picture in pixels.
        """
        return _vision(K, world_to_camera, width, height, (1, -1, 1), near)

    @staticmethod
    def from_opengl(K, camera_to_world, width, height, near=0.0):
        """The camera of OpenGL, Blender and NeRF: x right, y up, z backward.

        K: (3, 3) as for `from_opencv`. camera_to_world: (3, 4) or (4, 4), a rotation and a translation.
        """
        import numpy as np

        pose = np.eye(4)
        given = np.asarray(camera_to_world, float)
        pose[: given.shape[0]] = given
        return _vision(K, np.linalg.inv(pose), width, height, (1, 1, -1), near)


def _vision(K, world_to_camera, width, height, signs, near):
    import numpy as np

    from ._classes import classes

    K, pose = np.asarray(K, float), np.asarray(world_to_camera, float)
    if K.shape != (3, 3):
        raise ValueError(f"K has the shape {K.shape}; expected (3, 3)")
    if pose.shape not in ((3, 4), (4, 4)):
        raise ValueError(f"the pose has the shape {pose.shape}; expected (3, 4) or (4, 4)")
    if abs(K[0, 1]) > 1e-9 * abs(K[0, 0]) or K[2, 2] != 1 or np.any(K[[1, 2, 2], [0, 0, 1]] != 0):
        raise ValueError("K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]: skewed pixels cannot be rendered")
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        raise ValueError("the focal lengths fx and fy must be greater than 0")
    rotation, translation = pose[:3, :3], pose[:3, 3]
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-5):
        raise ValueError("the rotation of the pose is none: its rows must be orthonormal")
    right, up, forward = (rotation[i] * signs[i] for i in range(3))
    position = -rotation.T @ translation
    mirrored = np.dot(np.cross(right, -up), forward) < 0
    keys = {
        "position": position.tolist(),
        "look_at": (position + forward).tolist(),
        "up": up.tolist(),
        "viewport": [width / K[0, 0], height / K[1, 1]],
        "distance": 1.0,
        "shift": [0.5 - K[0, 2] / width, K[1, 2] / height - 0.5],
    }
    if mirrored:
        keys["handedness"] = "left"
    if near:
        keys["near"] = float(near)
    return Sized(classes()["PinholeCamera"](**keys), width, height)


def edits_of(camera):
    """What sets a camera: edits by key path."""
    if hasattr(camera, "_edits"):
        return camera._edits()
    if isinstance(camera, str):
        return {"studio.camera": camera}
    return {"camera": camera}

"""Cameras: those of computer vision, and what they see."""

import numpy as np
import pytest
import turner as tr


def rotation(seed):
    """A random rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


@pytest.mark.parametrize("seed", range(6))
def test_projected_points_are_where_the_aov_says(seed):
    rng = np.random.default_rng(seed)
    K = np.array([[310.0 + 20 * rng.uniform(), 0, 150 + 20 * rng.uniform()], [0, 290.0, 130 - 20 * rng.uniform()], [0, 0, 1]])
    R = rotation(seed)
    pose = np.column_stack([R, [0.1, -0.2, 6.0]])
    scene = tr.Scene(objects=[tr.Sphere(radius=1.5, name="s")], integrator="path", lights=[tr.AmbientLight()])
    camera = tr.Camera.from_opencv(K, pose, 320, 240)
    out = tr.render(scene, 1, ["position", "depth", "distance"], camera=camera, antialias="none", warn=False)
    assert out.image.shape == (240, 320, 4)
    assert np.allclose(out.camera["K"], K, atol=1e-9)
    hit = out["depth"] < 1e9
    rows, columns = np.nonzero(hit)
    local = out["position"][hit].astype(float) @ R.T + pose[:, 3]
    u, v = local[:, 0] / local[:, 2] * K[0, 0] + K[0, 2], local[:, 1] / local[:, 2] * K[1, 1] + K[1, 2]
    # Positions are floats: a millionth of the size of the scene, some 1e-4 pixels.
    assert hit.sum() > 1000
    assert np.abs(u - columns - 0.5).max() < 4e-4 and np.abs(v - rows - 0.5).max() < 4e-4
    assert np.median(np.abs(u - columns - 0.5)) < 1e-4 and np.median(np.abs(v - rows - 0.5)) < 1e-4
    assert np.allclose(out["depth"][hit], local[:, 2], rtol=1e-6)
    # A sphere's surface, in closed form.
    assert np.allclose(np.linalg.norm(out["position"][hit], axis=-1), 1.5, atol=1e-5)


def test_opengl_and_opencv_are_the_same_camera():
    K = np.array([[200.0, 0, 64], [0, 200, 48], [0, 0, 1]])
    R = rotation(3)
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3], world_to_camera[:3, 3] = R, [0, 0, 5]
    a = tr.Camera.from_opencv(K, world_to_camera, 128, 96)
    flip = np.diag([1.0, -1, -1, 1])
    b = tr.Camera.from_opengl(K, np.linalg.inv(flip @ world_to_camera), 128, 96)
    scene = tr.Scene(objects=[tr.Box(min=(-1, -1, -1), max=(1, 1, 1))])
    one, two = (tr.render(scene, 1, ["depth"], camera=c, warn=False) for c in (a, b))
    assert np.allclose(one["depth"], two["depth"], rtol=1e-6)
    assert np.allclose(one.camera["opencv"]["world_to_camera"], world_to_camera, atol=1e-9)


def test_bad_cameras_are_refused():
    K, pose = np.eye(3) * [[100], [100], [1]], np.eye(4)
    for bad in (K[:2], K + [[0, 5, 0], [0, 0, 0], [0, 0, 0]], -K):
        with pytest.raises(ValueError):
            tr.Camera.from_opencv(bad, pose, 64, 48)
    with pytest.raises(ValueError, match="rotation"):
        tr.Camera.from_opencv(K, pose * 2, 64, 48)
    with pytest.raises(ValueError, match="shape"):
        tr.Camera.from_opencv(K, np.eye(2), 64, 48)


def test_orbits_frame_the_scene(scene):
    seen = []
    for azimuth in (0, 90):
        out = tr.render(scene, 1, ["object_id"], camera=tr.Camera.orbit(azimuth, 20), antialias="none")
        assert (out["object_id"] == 1).any()
        seen.append(np.array(out.camera["opencv"]["camera_to_world"])[:3, 3])
    assert abs(seen[0][0]) < 1e-6 < abs(seen[1][0])
    # A camera that is given replaces the orbit.
    scene.camera = tr.Camera.orbit(10, 10)
    scene.camera = tr.Camera.look_at((0, 1, 9), (0, 1, 0))
    assert np.allclose(np.array(scene.info()["camera"]["opencv"]["camera_to_world"])[:3, 3], [0, 1, 9])

"""Scenes that the tests share."""

import numpy as np
import pytest
import turner as tr


@pytest.fixture
def scene():
    """A red ball on a floor under a light: quick to render."""
    return tr.Scene(
        objects=[
            tr.Sphere(center=(0, 1, 0), name="ball", material=tr.PrincipledMaterial(base_color="red")),
            tr.Plane(name="floor"),
        ],
        lights=[tr.PointLight(position=(3, 5, 4), intensity=40)],
        camera=tr.Camera.look_at((0, 2, 6), (0, 1, 0), fov=35),
        film=tr.Film(width=64, height=48, samples=4),
        integrator="path",
    )


@pytest.fixture
def bumpy():
    """Vertices, faces, normals and uv of a smooth closed mesh."""
    n = 24
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0.05, np.pi - 0.05, n))
    points = np.stack([np.sin(v) * np.cos(u), np.cos(v), np.sin(v) * np.sin(u)], -1).reshape(-1, 3)
    i = np.arange((n - 1) * (n - 1))
    a = i // (n - 1) * n + i % (n - 1)
    faces = np.concatenate([np.stack([a, a + 1, a + n], -1), np.stack([a + 1, a + n + 1, a + n], -1)])
    uv = np.stack([u / (2 * np.pi), v / np.pi], -1).reshape(-1, 2)
    return points, faces, points.copy(), uv

"""Cameras in files: transforms.json, COLMAP, BOP."""

from __future__ import annotations

import math


def frame(camera, file):
    """A frame of transforms.json (instant-ngp, nerfstudio)."""
    K = camera["K"]
    return {
        "file_path": file,
        "transform_matrix": camera["opengl"]["camera_to_world"],
        "fl_x": K[0][0],
        "fl_y": K[1][1],
        "cx": K[0][2],
        "cy": K[1][2],
        "w": camera["width"],
        "h": camera["height"],
    }


def transforms(frames):
    """transforms.json of frames. What all frames share stands at the top as well."""
    first = frames[0] if frames else {}
    shared = ("fl_x", "fl_y", "cx", "cy", "w", "h")
    out = {key: first[key] for key in shared if all(f[key] == first[key] for f in frames)}
    if "fl_x" in out and "w" in out:
        out["camera_angle_x"] = 2 * math.atan(0.5 * out["w"] / out["fl_x"])
    return {"camera_model": "OPENCV", **out, "frames": frames}


def quaternion(rotation):
    """(w, x, y, z) of a rotation matrix, w not negative (Shepperd 1978)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    parts = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    largest = max(range(4), key=lambda k: parts[k])
    root = math.sqrt(parts[largest])
    s = 0.5 / root
    q = [
        (0.5 * root, (h - f) * s, (c - g) * s, (d - b) * s),
        ((h - f) * s, 0.5 * root, (b + d) * s, (c + g) * s),
        ((c - g) * s, (b + d) * s, 0.5 * root, (f + h) * s),
        ((d - b) * s, (c + g) * s, (f + h) * s, 0.5 * root),
    ][largest]
    return tuple(-v for v in q) if q[0] < 0 else q


def colmap(cameras, points=()):
    """The texts of COLMAP's cameras.txt, images.txt and points3D.txt. cameras: pairs of the camera as numbers and the
    file of its picture; points: (x, y, z, r, g, b)."""
    models: dict = {}
    images = []
    for number, (camera, file) in enumerate(cameras, 1):
        K = camera["K"]
        model = (camera["width"], camera["height"], K[0][0], K[1][1], K[0][2], K[1][2])
        kind = models.setdefault(model, len(models) + 1)
        pose = camera["opencv"]["world_to_camera"]
        q = quaternion([row[:3] for row in pose[:3]])
        values = [*q, *(row[3] for row in pose[:3])]
        images.append(f"{number} {' '.join(repr(float(v)) for v in values)} {kind} {file}\n\n")
    head = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    cameras_text = head + "".join(f"{number} PINHOLE {' '.join(repr(v) for v in model)}\n" for model, number in models.items())
    head = (
        "# Image list with two lines of data per image:\n"
        "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
        "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
    )
    images_text = head + "".join(images)
    head = (
        "# 3D point list with one line of data per point:\n"
        "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
    )
    points_text = head + "".join(
        f"{number} {x!r} {y!r} {z!r} {r} {g} {b} 0\n" for number, (x, y, z, r, g, b) in enumerate(points, 1)
    )
    return {"cameras.txt": cameras_text, "images.txt": images_text, "points3D.txt": points_text}


def seen_points(camera, depth, display, step):
    """Points on the surfaces that a picture shows, every `step` pixels: (x, y, z, r, g, b); grey without a picture."""
    import numpy as np

    K, pose = np.array(camera["K"]), np.array(camera["opencv"]["camera_to_world"])
    rows, columns = np.mgrid[step // 2 : depth.shape[0] : step, step // 2 : depth.shape[1] : step]
    z = depth[rows, columns].astype(float)
    hit = z < 1e9
    u, v, z = columns[hit] + 0.5, rows[hit] + 0.5, z[hit]
    local = np.stack([(u - K[0, 2]) / K[0, 0] * z, (v - K[1, 2]) / K[1, 1] * z, z], -1)
    world = local @ pose[:3, :3].T + pose[:3, 3]
    colors = np.full((len(z), 3), 128) if display is None else display[rows[hit], columns[hit], :3]
    return [(*map(float, p), *map(int, c)) for p, c in zip(world, colors)]


def matrix(transform):
    """The 4 x 4 matrix of a transform as a scene gives it: None, or a dict of `scale`, `translate` or `matrix`."""
    import numpy as np

    out = np.eye(4)
    if not transform:
        return out
    if "matrix" in transform:
        out[:3] = np.asarray(transform["matrix"], float).reshape(-1, 4)[:3]
        return out
    scale = transform.get("scale", 1.0)
    out[:3, :3] = np.diag(np.broadcast_to(np.asarray(scale, float), 3))
    out[:3, 3] = transform.get("translate", (0, 0, 0))
    return out

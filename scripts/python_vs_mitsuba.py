#!/usr/bin/env python3
"""Measures the module `turner` beside Mitsuba 3 in the same loops: `scripts/python_vs_mitsuba.py [VARIANT]`.

A bumpy ball of 100,000 triangles on a floor, under a constant environment, 640 x 480 pixels, from cameras around it.
Needs `mitsuba` and both modules in one environment. Each measurement is repeated in turn; medians are printed.

    labels  views per second of depth, normal and shape number, one sample a pixel, in processes of their own
    paths   time x squared error of path-traced views, 16 samples, against each renderer's own picture of 1024 samples
    import  seconds of `import`, in a fresh process
"""

import statistics
import subprocess
import sys
import time
from functools import partial

import mitsuba as mi
import numpy as np

import turner as tr

SIZE = (640, 480)
VIEWS = 12


def bumpy(n=225):
    """Vertices and faces."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(1e-3, np.pi - 1e-3, n))
    r = 1 + 0.1 * np.sin(8 * u) * np.sin(6 * v)
    points = np.stack([r * np.sin(v) * np.cos(u), r * np.cos(v) + 1.2, r * np.sin(v) * np.sin(u)], -1).reshape(-1, 3)
    i = np.arange((n - 1) ** 2)
    a = i // (n - 1) * n + i % (n - 1)
    faces = np.concatenate([np.stack([a, a + 1, a + n], -1), np.stack([a + 1, a + n + 1, a + n], -1)])
    return points.astype(np.float32), faces.astype(np.uint32)


def cameras(count=VIEWS):
    """Positions around the ball."""
    angles = 2 * np.pi * np.arange(count) / count
    return [(6 * np.sin(a), 3.0, 6 * np.cos(a)) for a in angles]


TARGET, FOV = (0, 1, 0), 35.0


def of_turner(points, faces):
    """The scene for Turner."""
    gray = tr.DiffuseMaterial(color=0.5) if hasattr(tr, "DiffuseMaterial") else None
    gray = gray or {"type": "principled", "base_color": [0.5] * 3, "specular_weight": 0}
    return tr.Scene(
        objects=[
            tr.Mesh(name="ball", vertices=points, faces=faces, material=gray),
            tr.Rectangle(
                name="floor",
                material=gray,
                transform={"rotate": [-90, 0, 0], "scale": 20},
            ),
        ],
        background={"color": [0.8, 0.8, 0.8]},
        lights=[tr.EnvironmentLight(file=np.full((4, 8, 3), 0.8, np.float32))],
        integrator=tr.PathIntegrator(max_depth=8),
        film=tr.Film(width=SIZE[0], height=SIZE[1], denoise="off"),
    )


def of_mitsuba(points, faces):
    """The scene for Mitsuba, and its parameters."""
    mesh = mi.Mesh("ball", len(points), len(faces), props=_props())
    params = mi.traverse(mesh)
    params["vertex_positions"] = points.ravel()
    params["faces"] = faces.ravel()
    params.update()
    T = mi.ScalarTransform4f
    gray = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "ball": mesh,
            "floor": {"type": "rectangle", "to_world": T().rotate([1, 0, 0], -90).scale(20), "bsdf": gray},
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.8}},
            "sensor": {
                "type": "perspective",
                "fov": FOV,
                "fov_axis": "y",
                "to_world": T().look_at(origin=list(cameras()[0]), target=list(TARGET), up=[0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": SIZE[0],
                    "height": SIZE[1],
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                },
                "sampler": {"type": "multijitter", "sample_count": 16},
            },
        }
    )
    return scene, mi.traverse(scene)


def _props():
    props = mi.Properties()
    props["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}})
    return props


def timed(work):
    """Seconds of a call."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def labels_of_turner(scene):
    """Renders the views once."""
    from turner.dataset._views import in_order

    views = tr.dataset.Views(
        scene,
        [tr.Camera.look_at(p, TARGET, fov=FOV) for p in cameras()],
        aovs=["depth", "normal", "object_id"],
        image=False,
    )
    for _ in in_order(lambda i, running: views[i], VIEWS, 2):
        pass


def labels_of_mitsuba(loaded):
    """The same."""
    mitsuba, params = loaded
    aov = mi.load_dict({"type": "aov", "aovs": "depth:depth,normal:sh_normal,id:shape_index"})
    key = next(k for k in params.keys() if k.endswith("sensor.to_world"))
    for seed, position in enumerate(cameras()):
        params[key] = mi.ScalarTransform4f().look_at(origin=list(position), target=list(TARGET), up=[0, 1, 0])
        params.update()
        np.array(mi.render(mitsuba, integrator=aov, spp=1, seed=seed))


def labels(module, variant):
    """Views per second of a module, in this process."""
    points, faces = bumpy()
    if module == "turner":
        work = partial(labels_of_turner, of_turner(points, faces))
    else:
        mi.set_variant(variant)
        work = partial(labels_of_mitsuba, of_mitsuba(points, faces))
    work()
    return VIEWS / statistics.median(timed(work) for _ in range(5))


def labels_apart(variant):
    """Views per second of both, in turn, each in processes of its own: threads that wait for work may keep cores busy."""
    command = [sys.executable, __file__, variant, "--labels"]

    def run(module):
        return float(subprocess.run([*command, module], capture_output=True, check=True).stdout)

    pairs = [(run("turner"), run("mitsuba")) for _ in range(5)]
    return [statistics.median(rates) for rates in zip(*pairs, strict=True)]


def paths(scene, loaded):
    """(seconds, relative squared error) of both."""
    mitsuba, _ = loaded
    path = mi.load_dict({"type": "path", "max_depth": 9})
    camera = tr.Camera.look_at(cameras()[0], TARGET, fov=FOV)

    def turner(samples, seed):
        return tr.render(scene, samples, camera=camera, seed=seed, warn=False).rgb

    def other(samples, seed):
        return np.array(mi.render(mitsuba, integrator=path, spp=samples, seed=seed))

    def error(picture, truth):
        return float((((picture - truth) ** 2) / (truth**2 + 1e-2)).mean())

    out = []
    for work in (turner, other):
        truth = work(1024, 99)
        work(16, 0)
        times, errors = [], []
        for seed in range(1, 6):
            begun = time.perf_counter()
            picture = work(16, seed)
            times.append(time.perf_counter() - begun)
            errors.append(error(picture, truth))
        out.append((statistics.median(times), statistics.mean(errors), float(truth.mean())))
    return out


def main():
    """Prints the figures."""
    variant = sys.argv[1] if len(sys.argv) > 1 else "llvm_ad_rgb"
    if "--labels" in sys.argv:
        print(labels(sys.argv[-1], variant))
        return
    ours, theirs = labels_apart(variant)
    print(f"labels: {ours:.1f} views/s, Mitsuba {theirs:.1f}: {ours / theirs:.2f} times as many")
    mi.set_variant(variant)
    points, faces = bumpy()
    scene, loaded = of_turner(points, faces), of_mitsuba(points, faces)
    (t, e, m), (t2, e2, m2) = paths(scene, loaded)
    print(f"paths: {t:.3f} s, error {e:.5f}, mean {m:.4f}; Mitsuba {t2:.3f} s, {e2:.5f}, {m2:.4f}")
    print(f"       equal error in {t * e / (t2 * e2):.2f} of Mitsuba's time")
    for name in ("turner", "mitsuba"):
        code = f"import time; t = time.perf_counter(); import {name}; print(time.perf_counter() - t)"
        times = [float(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout) for _ in range(5)]
        print(f"import {name}: {statistics.median(times):.3f} s")


if __name__ == "__main__":
    main()

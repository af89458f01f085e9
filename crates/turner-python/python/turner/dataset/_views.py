"""Views of a scene, as files or as a sequence."""

from __future__ import annotations

import os

from .._render import AOV_NAMES, Renderer, settings_edits  # noqa: F401
from ._coco import Coco, box, boxes
from ._poses import colmap, frame, matrix, seen_points, transforms
from ._write import write_bytes, write_json, write_npy, write_png

#: What measures the first surface alone: without light, one ray a pixel suffices.
LABELS_ONLY = {"integrator": "depth", "antialias": "none"}


def _rendered(scene, camera, samples, aovs, image, settings, running=None):
    if not image:
        settings = {**LABELS_ONLY, **settings}
    renderer = Renderer(scene, samples if image else None, aovs, camera=camera, **settings)
    if running is not None:
        running.add(renderer)
    renderer.run()
    picture = renderer.picture()
    if running is not None:
        running.discard(renderer)
    return picture


def _in_order(make, count, workers):
    """`make(i, running)` for all i, several at once, in order. `running` holds renderers, which an exception cancels."""
    from collections import deque
    from concurrent.futures import ThreadPoolExecutor

    pool, pending, running = ThreadPoolExecutor(workers), deque(), set()
    try:
        for i in range(count):
            pending.append(pool.submit(make, i, running))
            if len(pending) > workers:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()
        for renderer in list(running):
            renderer.cancel()
        pool.shutdown()


class Views:
    """Views of a scene as a sequence of dicts of arrays: a map-style dataset for PyTorch's `DataLoader`.

    scene: a path (loaded in each worker, so that workers may be spawned or forked) or a `Scene` (threads and forks only).
    cameras: e.g. `orbit(100)`. aovs: further arrays. image: whether light is computed; without it only `aovs` are.
    Other arguments are those of `turner.render`. An item has the keys `image` (height, width, 4) float32, one for each
    AOV, `K` (3, 3) and `camera_to_world` (4, 4), OpenCV's axes.
    """

    def __init__(self, scene, cameras, *, samples=None, aovs=(), image=True, threads=1, **settings):
        self.scene, self.cameras = scene, list(cameras)
        self.samples, self.aovs, self.image = samples, [aovs] if isinstance(aovs, str) else list(aovs), image
        self.settings = {"threads": threads, **settings}
        self._loaded = None

    def __len__(self):
        return len(self.cameras)

    def __getstate__(self):
        return {**self.__dict__, "_loaded": None}

    def _scene(self):
        # A forked worker loads its own, as a lock of the parent's may be held at the fork.
        if isinstance(self.scene, (str, os.PathLike)):
            if self._loaded is None or self._loaded[0] != os.getpid():
                from .._tools import load

                self._loaded = (os.getpid(), load(self.scene, warn=False))
            return self._loaded[1]
        return self.scene

    def picture(self, index):
        """The `Picture` of a view."""
        return _rendered(self._scene(), self.cameras[index], self.samples, self.aovs, self.image, self.settings)

    def __getitem__(self, index):
        import numpy as np

        if not -len(self) <= index < len(self):
            raise IndexError(index)
        picture = self.picture(index)
        out = {"image": picture.image} if self.image else {}
        out.update({AOV_NAMES.get(aov, aov): picture[aov] for aov in self.aovs})
        camera = picture.camera
        if "K" in camera:
            out["K"] = np.array(camera["K"], np.float32)
        out["camera_to_world"] = np.array(camera["opencv"]["camera_to_world"], np.float32)
        return out


def _entries(scene, names):
    """For each number of `instance_id`: the entry of the scene's list of objects."""
    listed = scene.objects.names()
    return {number: number - 1 for number in names if number - 1 < len(listed)}


def _wholes(scene, cameras, entries, settings):
    """For each view and each entry: the mask of the entry as if nothing else were there."""
    wholes = [{} for _ in cameras]
    for label, entry in entries.items():
        alone = scene.copy()
        alone.edit({f"object.{other}.hidden": True for other in entries.values() if other != entry})
        for view, camera in enumerate(cameras):
            found = _rendered(alone, camera, None, ["instance_id"], False, settings)
            wholes[view][label] = found["instance_id"] == label
    return wholes


def views(scene, cameras, out, *, aovs=(), samples=None, image=True, format="png", coco=False, bop=False,
          colmap_points=16, occlusion=None, categories=None, units_to_mm=1000.0, first=0, progress=None, threads=0, **settings):
    """Renders a scene from many cameras into the folder `out`.

    cameras: e.g. `orbit(100)`, `hemisphere(200)`, or any that `render` takes. aovs: further channels.
    image: whether light is computed. format: "png" writes pictures as PNG and AOVs as NPY, "npy" all as NPY, "exr" one
    EXR file a view. Numbers of objects stand for the scene's list of objects (`instance_id`) in `coco` and `bop`.
    coco: writes annotations.json with masks and boxes. bop: writes poses, masks and depth as BOP's test sets have them;
    `units_to_mm` is the size of a scene unit. occlusion: whether each object is also rendered alone, for the fraction of
    it that is seen; by default with `bop`. categories: a function from an object's name to its category, or None for none.
    first: the number of the first view. Other arguments are those of `turner.render`.

    Always written: transforms.json and COLMAP's text files (perspective cameras), names.json (the names of numbers). Each
    file appears whole or not at all, and the same call writes the same bytes. Returns the cameras as numbers.
    """
    from .._progress import reporter

    if format not in ("png", "npy", "exr"):
        raise ValueError(f'there is no format {format!r}; valid: "png", "npy", "exr"')
    cameras = list(cameras)
    asked = [AOV_NAMES.get(aov, aov) for aov in ([aovs] if isinstance(aovs, str) else aovs)]
    labelled = coco or bop
    more = (["instance_id"] if labelled else []) + (["depth"] if labelled or colmap_points else [])
    wanted = [*asked, *(aov for aov in more if aov not in asked)]
    out = os.fspath(out)
    os.makedirs(out, exist_ok=True)
    # Views are rendered side by side, each on one thread: their parts that need one thread overlap.
    workers = threads or os.cpu_count() or 1
    settings = {"threads": 1, **settings}

    def made(view, running):
        picture = _rendered(scene, cameras[view], samples, wanted, image, settings, running)
        labels = picture
        if image and labelled:
            # What a pixel's centre shows: no mix of two surfaces.
            labels = _rendered(scene, cameras[view], None, ["instance_id", "depth"], False, settings, running)
        return picture, labels

    measured, frames, pictures, points, names = [], [], [], [], {}
    annotations = Coco(categories)
    poses = _Bop(scene, out, units_to_mm) if bop else None
    wholes = None
    with reporter(progress) as report:
        for view, (picture, labels) in enumerate(_in_order(made, len(cameras), workers)):
            number = first + view
            file = _write(picture, out, number, asked, image, format)
            numbers = picture.camera
            measured.append(numbers)
            names.update({"object_id": picture.names, "material_id": picture.material_names, "instance_id": picture.instance_names})
            if "K" in numbers and not numbers["mirrored"]:
                frames.append(frame(numbers, file))
                pictures.append((numbers, file))
                if colmap_points:
                    points += seen_points(numbers, picture["depth"], picture.display, max(1, picture.width // colmap_points))
            if labelled:
                entries = _entries(scene, picture.instance_names)
                if wholes is None and (bop if occlusion is None else occlusion):
                    wholes = _wholes(scene, cameras, entries, settings)
                ids, whole = labels["instance_id"], None if wholes is None else wholes[view]
                sizes = whole and {k: {"box": box(m), "pixels": int(m.sum())} for k, m in whole.items() if m.any()}
                annotations.add(number, file, ids, picture.instance_names, sizes)
                if poses is not None:
                    poses.add(number, picture, labels, entries, whole)
            if report:
                report((view + 1) / len(cameras))
    if frames:
        write_json(os.path.join(out, "transforms.json"), transforms(frames))
        folder = os.path.join(out, "colmap")
        os.makedirs(folder, exist_ok=True)
        for name, text in colmap(pictures, points).items():
            write_bytes(os.path.join(folder, name), text.encode())
    write_json(os.path.join(out, "names.json"), {kind: table for kind, table in names.items() if table})
    if coco:
        write_json(os.path.join(out, "annotations.json"), annotations.table())
    if poses is not None:
        poses.finish()
    return measured


def _write(picture, out, number, aovs, image, format):
    """Writes the arrays of a view. Returns the file of its picture, as a path from `out`."""
    def place(folder, extension):
        os.makedirs(os.path.join(out, folder), exist_ok=True)
        return f"{folder}/{number:06}.{extension}"

    if format == "exr":
        file = place("images", "exr")
        kept = {name: array for name, array in picture.aovs.items() if name in aovs}
        picture.aovs, every = kept, picture.aovs
        picture.save(os.path.join(out, file))
        picture.aovs = every
        return file
    for aov in aovs:
        write_npy(os.path.join(out, place(aov, "npy")), picture[aov])
    file = place("images", format)
    if image and format == "png":
        write_png(os.path.join(out, file), picture.display if picture.has_alpha else picture.display[..., :3])
    elif image:
        write_npy(os.path.join(out, file), picture.image)
    return file


class _Bop:
    """The files of a BOP scene: rgb, depth, masks, poses. Lengths are in millimetres."""

    def __init__(self, scene, out, units_to_mm):
        self.scene, self.out, self.mm = scene, out, units_to_mm
        self.cameras, self.poses, self.facts = {}, {}, {}
        for folder in ("rgb", "depth", "mask", "mask_visib"):
            os.makedirs(os.path.join(out, folder), exist_ok=True)
        self.placed = [matrix(part.transform) for part in scene.objects]

    def add(self, number, picture, labels, entries, whole):
        """A view. `whole`: the masks of the entries alone."""
        import numpy as np

        camera = picture.camera
        if "K" not in camera:
            raise ValueError("BOP needs perspective cameras")
        pose = np.array(camera["opencv"]["world_to_camera"])
        depth = labels["depth"]
        # Tenths of a millimetre in 16 bits.
        scale = 0.1
        far = np.where(depth < 1e9, depth * self.mm / scale, 0)
        write_png(os.path.join(self.out, "depth", f"{number:06}.png"), np.clip(np.rint(far), 0, 65535).astype(np.uint16))
        write_png(os.path.join(self.out, "rgb", f"{number:06}.png"), picture.display[..., :3])
        self.cameras[str(number)] = {
            "cam_K": np.array(camera["K"]).ravel().tolist(),
            "depth_scale": scale,
            "cam_R_w2c": pose[:3, :3].ravel().tolist(),
            "cam_t_w2c": (pose[:3, 3] * self.mm).tolist(),
        }
        ids, poses, facts = labels["instance_id"], [], []
        for i, (label, entry) in enumerate(entries.items()):
            model = pose @ self.placed[entry]
            size = np.cbrt(abs(np.linalg.det(model[:3, :3])))
            poses.append({
                "cam_R_m2c": (model[:3, :3] / size).ravel().tolist(),
                "cam_t_m2c": (model[:3, 3] * self.mm).tolist(),
                "obj_id": label,
            })
            seen = ids == label
            full = seen if whole is None else whole[label]
            write_png(os.path.join(self.out, "mask", f"{number:06}_{i:06}.png"), full)
            write_png(os.path.join(self.out, "mask_visib", f"{number:06}_{i:06}.png"), seen)
            count, visible = int(full.sum()), int(seen.sum())
            facts.append({
                "bbox_obj": box(full) or [-1, -1, -1, -1],
                "bbox_visib": box(seen) or [-1, -1, -1, -1],
                "px_count_all": count,
                "px_count_valid": int((full & (depth < 1e9)).sum()),
                "px_count_visib": visible,
                "visib_fract": visible / count if count else 0.0,
            })
        self.poses[str(number)], self.facts[str(number)] = poses, facts

    def finish(self):
        """Writes the tables."""
        for name, table in (("scene_camera", self.cameras), ("scene_gt", self.poses), ("scene_gt_info", self.facts)):
            write_json(os.path.join(self.out, f"{name}.json"), table)


__all__ = ["Views", "boxes", "views"]

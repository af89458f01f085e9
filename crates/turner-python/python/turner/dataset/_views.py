"""Views of a scene, as files or as a sequence.

A view is rendered and written by `record`, which needs the scene alone, so that views can be made anywhere and in any order;
`tables` writes what is about all of them.
"""

from __future__ import annotations

import os

from .._render import AOV_NAMES, OF_SURFACES, Renderer
from .._render import labels as surface_labels
from ._coco import Coco, box, boxes
from ._poses import colmap, frame, matrix, seen_points, transforms
from ._write import write_bytes, write_json, write_npy, write_png

#: What measures the first surface alone: without light, one ray through each pixel's centre suffices.
LABELS_ONLY = {"integrator": "depth", "antialias": "none"}

#: The unit of depth in BOP's files, millimetres.
BOP_DEPTH = 0.1


def rendered(scene, camera, samples, aovs, image, settings, running=None):
    """The `Picture` of a view; without `image`, its `Labels` where these suffice."""
    if not image and all(AOV_NAMES.get(aov, aov) in OF_SURFACES for aov in aovs):
        return surface_labels(scene, aovs, camera=camera, **settings)
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


def in_order(make, count, workers):
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
        return rendered(self._scene(), self.cameras[index], self.samples, self.aovs, self.image, self.settings)

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


class Options:
    """What the views of a dataset have in common. It can be pickled."""

    def __init__(
        self,
        out,
        aovs=(),
        samples=None,
        image=True,
        format="png",
        coco=False,
        bop=False,
        colmap_points=16,
        occlusion=None,
        units_to_mm=1000.0,
        settings=None,
    ):
        if format not in ("png", "npy", "exr"):
            raise ValueError(f'there is no format {format!r}; valid: "png", "npy", "exr"')
        self.out, self.samples, self.image, self.format = os.fspath(out), samples, image, format
        self.aovs = [AOV_NAMES.get(aov, aov) for aov in ([aovs] if isinstance(aovs, str) else aovs)]
        self.coco, self.bop, self.colmap_points, self.units_to_mm = coco, bop, colmap_points, units_to_mm
        self.occlusion = bop if occlusion is None else occlusion
        self.settings = settings or {}

    @property
    def labelled(self):
        """Whether objects are told apart."""
        return self.coco or self.bop


def record(scene, camera, number, options, running=None, alone=None):
    """Renders a view, writes its arrays, and returns what the tables need of it. `alone`: a dict that keeps the scenes of
    single objects between views."""
    more = (["instance_id", "depth"] if options.labelled else []) + (["depth"] if options.colmap_points else [])
    wanted = [*options.aovs, *(aov for aov in dict.fromkeys(more) if aov not in options.aovs)]
    picture = rendered(scene, camera, options.samples, wanted, options.image, options.settings, running)
    labels = picture
    if options.image and options.labelled:
        # What a pixel's centre shows: no mix of two surfaces.
        labels = rendered(scene, camera, None, ["instance_id", "depth"], False, options.settings, running)
    numbers = picture.camera
    found = {
        "number": number,
        "file": write_view(picture, options.out, number, options.aovs, options.image, options.format),
        "camera": numbers,
        "names": {
            "object_id": picture.names,
            "material_id": picture.material_names,
            "instance_id": picture.instance_names,
        },
    }
    if options.colmap_points and "K" in numbers and not numbers["mirrored"]:
        step = max(1, numbers["width"] // options.colmap_points)
        found["points"] = seen_points(numbers, picture["depth"], getattr(picture, "display", None), step)
    if options.labelled:
        ids = found["ids"] = labels["instance_id"]
        entries = _entries(scene, picture.instance_names)
        whole = _wholes(scene, camera, entries, options, running, {} if alone is None else alone)
        if whole is not None:
            found["sizes"] = {k: {"box": box(m), "pixels": int(m.sum())} for k, m in whole.items() if m.any()}
        if options.bop:
            found["bop"] = _bop(picture, labels["depth"], ids, entries, whole, number, options)
        if not options.coco:
            del found["ids"]
    return found


def _entries(scene, names):
    """For each number of `instance_id`: the entry of the scene's list of objects."""
    listed = len(scene.objects)
    return {number: number - 1 for number in names if number - 1 < listed}


def _wholes(scene, camera, entries, options, running, alone):
    """For each entry: its mask as if nothing else were there. None if it is not asked for."""
    if not options.occlusion:
        return None
    masks = {}
    for label, entry in entries.items():
        if label not in alone:
            single = scene.copy()
            single.edit({f"object.{other}.hidden": True for other in entries.values() if other != entry})
            alone[label] = single
        found = rendered(alone[label], camera, None, ["instance_id"], False, options.settings, running)
        masks[label] = found["instance_id"] == label
    return masks


def _bop(picture, depth, ids, entries, whole, number, options):
    """Writes the pictures of BOP and returns the facts of the view's objects."""
    import numpy as np

    if "K" not in picture.camera:
        raise ValueError("BOP needs perspective cameras")

    def place(folder, name):
        os.makedirs(os.path.join(options.out, folder), exist_ok=True)
        return os.path.join(options.out, folder, f"{name}.png")

    far = np.where(depth < 1e9, depth * (options.units_to_mm / BOP_DEPTH), 0)
    write_png(place("depth", f"{number:06}"), np.clip(np.rint(far), 0, 65535).astype(np.uint16))
    if options.image:
        write_png(place("rgb", f"{number:06}"), picture.display[..., :3])
    facts = []
    for i, label in enumerate(entries):
        seen = ids == label
        full = seen if whole is None else whole[label]
        write_png(place("mask", f"{number:06}_{i:06}"), full)
        write_png(place("mask_visib", f"{number:06}_{i:06}"), seen)
        count, visible = int(full.sum()), int(seen.sum())
        facts.append(
            {
                "bbox_obj": box(full) or [-1, -1, -1, -1],
                "bbox_visib": box(seen) or [-1, -1, -1, -1],
                "px_count_all": count,
                "px_count_valid": int((full & (depth < 1e9)).sum()),
                "px_count_visib": visible,
                "visib_fract": visible / count if count else 0.0,
            }
        )
    return {"labels": list(entries.items()), "facts": facts}


def tables(scene, records, options, categories=None):
    """Writes the files about all views: transforms.json, COLMAP's, names.json, annotations.json, BOP's. Returns the
    cameras as numbers."""
    out = options.out
    os.makedirs(out, exist_ok=True)
    records = sorted(records, key=lambda found: found["number"])
    flat = [found for found in records if "K" in found["camera"] and not found["camera"]["mirrored"]]
    if flat:
        frames = [frame(found["camera"], found["file"]) for found in flat]
        write_json(os.path.join(out, "transforms.json"), transforms(frames))
        points = [point for found in flat for point in found.get("points", ())]
        os.makedirs(os.path.join(out, "colmap"), exist_ok=True)
        texts = colmap([(found["camera"], found["file"]) for found in flat], points)
        for name, text in texts.items():
            write_bytes(os.path.join(out, "colmap", name), text.encode())
    names = {kind: table for found in records for kind, table in found["names"].items() if table}
    write_json(os.path.join(out, "names.json"), names)
    if options.coco:
        annotations = Coco(categories)
        for found in records:
            annotations.add(found["number"], found["file"], found["ids"], found["names"]["instance_id"], found.get("sizes"))
        write_json(os.path.join(out, "annotations.json"), annotations.table())
    if options.bop:
        _bop_tables(scene, records, options)
    return [found["camera"] for found in records]


def _bop_tables(scene, records, options):
    import numpy as np

    placed = [matrix(part.transform) for part in scene.objects]
    mm, cameras, truth, facts = options.units_to_mm, {}, {}, {}
    for found in records:
        name, camera = str(found["number"]), found["camera"]
        pose = np.array(camera["opencv"]["world_to_camera"])
        cameras[name] = {
            "cam_K": np.array(camera["K"]).ravel().tolist(),
            "depth_scale": BOP_DEPTH,
            "cam_R_w2c": pose[:3, :3].ravel().tolist(),
            "cam_t_w2c": (pose[:3, 3] * mm).tolist(),
        }
        truth[name], facts[name] = [], found["bop"]["facts"]
        for label, entry in found["bop"]["labels"]:
            model = pose @ placed[entry]
            # BOP knows no scale: that of an object belongs to its model.
            size = np.cbrt(abs(np.linalg.det(model[:3, :3])))
            truth[name].append(
                {
                    "cam_R_m2c": (model[:3, :3] / size).ravel().tolist(),
                    "cam_t_m2c": (model[:3, 3] * mm).tolist(),
                    "obj_id": label,
                }
            )
    for name, table in (("scene_camera", cameras), ("scene_gt", truth), ("scene_gt_info", facts)):
        write_json(os.path.join(options.out, f"{name}.json"), table)


def views(
    scene,
    cameras,
    out,
    *,
    first=0,
    categories=None,
    progress=None,
    threads=0,
    aovs=(),
    samples=None,
    image=True,
    format="png",
    coco=False,
    bop=False,
    colmap_points=16,
    occlusion=None,
    units_to_mm=1000.0,
    **settings,
):
    """Renders a scene from many cameras into the folder `out`.

    cameras: e.g. `orbit(100)`, `hemisphere(200)`, or any that `render` takes. aovs: further channels.
    image: whether light is computed; without it there are AOVs of surfaces alone, as `turner.labels` has them, as NPY.
    format: "png" writes pictures as PNG and AOVs as NPY, "npy" all as NPY, "exr" one
    EXR file a view. In `coco` and `bop`, objects are the entries of the scene's list of objects (`instance_id`).
    coco: writes annotations.json with masks and boxes. bop: writes poses, masks and depth as BOP's test sets have them;
    `units_to_mm` is the size of a scene unit. occlusion: whether each object is also rendered alone, for the fraction of
    it that is seen; by default with `bop`. categories: a function from an object's name to its category, or None for none.
    colmap_points: points of COLMAP's cloud across a view. first: the number of the first view. threads: views at a time;
    0 uses all cores. Other arguments are those of `turner.render`.

    Always written: transforms.json and COLMAP's text files (perspective cameras), names.json (the names of numbers). Each
    file appears whole or not at all, and the same call writes the same bytes. Returns the cameras as numbers.
    """
    from .._progress import reporter

    cameras = list(cameras)
    # Views are rendered side by side, each on one thread: their parts that need one thread overlap.
    options = Options(
        out, aovs, samples, image, format, coco, bop, colmap_points, occlusion, units_to_mm, {"threads": 1, **settings}
    )
    os.makedirs(options.out, exist_ok=True)
    alone: dict = {}
    records = []

    def make(i, running):
        return record(scene, cameras[i], first + i, options, running, alone)

    with reporter(progress) as report:
        for found in in_order(make, len(cameras), threads or os.cpu_count() or 1):
            records.append(found)
            if report:
                report(len(records) / len(cameras))
    return tables(scene, records, options, categories)


def write_view(picture, out, number, aovs, image, format):
    """Writes the arrays of a view. Returns the file of its picture, as a path from `out`."""

    def place(folder, extension):
        os.makedirs(os.path.join(out, folder), exist_ok=True)
        return f"{folder}/{number:06}.{extension}"

    if format == "exr" and image:
        file = place("images", "exr")
        every, picture.aovs = picture.aovs, {name: array for name, array in picture.aovs.items() if name in aovs}
        picture.save(os.path.join(out, file))
        picture.aovs = every
        return file
    for aov in aovs:
        write_npy(os.path.join(out, place(aov, "npy")), picture[aov])
    if not image:
        return f"images/{number:06}.{format}"
    file = place("images", format)
    if format == "png":
        write_png(os.path.join(out, file), picture.display if picture.has_alpha else picture.display[..., :3])
    else:
        write_npy(os.path.join(out, file), picture.image)
    return file


__all__ = ["Views", "boxes", "views"]

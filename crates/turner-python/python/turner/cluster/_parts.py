"""Parts of pictures: how they are split, rendered on any machine, and merged."""

from __future__ import annotations

import hashlib
import io
import os
import shutil
import tempfile
import zipfile

from .._render import Renderer, merge_films, settings_edits
from ..dataset._write import write_bytes

#: The films that one task merges.
FAN_IN = 8


def pack(scene):
    """A scene as bytes, the same for the same scene, and their hash: what travels to workers, once each."""
    folder = tempfile.mkdtemp(prefix="turner-scene-")
    try:
        scene._inner.write_exactly(os.path.join(folder, "scene.toml"))
        data = io.BytesIO()
        with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for base, folders, files in sorted(os.walk(folder)):
                folders.sort()
                for name in sorted(files):
                    path = os.path.join(base, name)
                    info = zipfile.ZipInfo(os.path.relpath(path, folder).replace(os.sep, "/"))
                    info.compress_type = zipfile.ZIP_DEFLATED
                    with open(path, "rb") as file:
                        archive.writestr(info, file.read())
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return data.getvalue(), hashlib.sha256(data.getvalue()).hexdigest()


#: The scene that this process rendered last, by its hash.
_last: dict = {}


def unpack(data, digest):
    """The scene of `pack`, loaded once in a process. `data` may be a path. Other bytes than those of the hash are refused."""
    if digest in _last:
        return _last[digest]
    if isinstance(data, str):
        with open(data, "rb") as file:
            data = file.read()
    if hashlib.sha256(data).hexdigest() != digest:
        raise ValueError("the bytes of the scene are not those of its hash")
    from .._tools import load

    folder = tempfile.mkdtemp(prefix="turner-scene-")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            archive.extractall(folder)
        scene = load(os.path.join(folder, "scene.toml"), warn=False)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    _last.clear()
    _last[digest] = scene
    return scene


class Job:
    """A picture in parts. It can be pickled, and holds neither scene nor arrays."""

    def __init__(self, digest, edits, total, size, parts, tiles, threads, folder):
        if not 1 <= parts <= total:
            raise ValueError(f"{parts} parts of {total} samples; expected 1 to {total}")
        if not 1 <= tiles <= size[1]:
            raise ValueError(f"{tiles} tiles of {size[1]} rows; expected 1 to {size[1]}")
        self.digest, self.edits, self.threads, self.folder = digest, edits, threads, folder
        self.bands = tiles
        rows = [size[1] * i // tiles for i in range(tiles + 1)]
        bands = [[0, a, size[0], b - a] for a, b in zip(rows, rows[1:])]
        samples = [total * i // parts for i in range(parts + 1)]
        #: (crop or None, first sample, sample after the last) of each part.
        self.parts = [(None if tiles == 1 else band, a, b) for band in bands for a, b in zip(samples, samples[1:])]
        text = repr((digest, sorted((k, repr(v)) for k, v in edits.items()), self.parts))
        self.name = hashlib.sha256(text.encode()).hexdigest()[:20]

    def file(self, name):
        """The file of a film; None if films travel as bytes."""
        return None if self.folder is None else os.path.join(self.folder, f"{self.name}-{name}.film")


def kept(path, make):
    """The film in a file, made and written whole if it is not there. Returns the path, or without one the film."""
    if path is None:
        return make()
    if not os.path.exists(path):
        write_bytes(path, make())
    return path


def render_part(data, job, index):
    """Renders a part. Returns its film, or the path of it."""

    def make():
        crop, first, end = job.parts[index]
        edits = dict(job.edits) if crop is None else {**job.edits, "film.crop": crop}
        renderer = Renderer(unpack(data, job.digest), threads=job.threads, settings=edits)
        renderer.run(end, first=first)
        return renderer.film()

    return kept(job.file(f"part-{index:06}"), make)


def read(film):
    """The bytes of a film."""
    if isinstance(film, str):
        with open(film, "rb") as file:
            return file.read()
    return film


def merge_part(films, job, name):
    """Merges films. Returns the film of all, or the path of it."""
    return kept(job.file(name), lambda: merge_films([read(film) for film in films]))


def tree(items, merge, prefix=""):
    """Merges items in a tree: `merge(items, name)` gets up to `FAN_IN` of them."""
    level = 0
    while len(items) > 1:
        groups = [items[i : i + FAN_IN] for i in range(0, len(items), FAN_IN)]
        items = [group[0] if len(group) == 1 else merge(group, f"{prefix}level-{level}-{i:06}") for i, group in enumerate(groups)]
        level += 1
    return items[0]


def merged(films, job, merge):
    """Merges the films of all parts: a tree for each band, then all bands at once. Films of several bands only go together
    when each has all samples and they cover the picture."""
    count = len(films) // job.bands
    if job.bands == 1:
        return tree(films, merge)
    bands = [tree(films[i * count : (i + 1) * count], merge, f"band-{i:06}-") for i in range(job.bands)]
    return merge(bands, "bands")


def plain(value):
    """A value of a scene without turner's classes, so that it can be pickled for another process."""
    if hasattr(value, "_plain_"):
        return {key: plain(part) for key, part in value._plain_().items()}
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return value


def job_of(scene, samples, aovs, *, parts, tiles, threads, folder, workers, settings):
    """The scene as bytes, its job, and the renderer that gets the film."""
    edits = {path: plain(value) for path, value in settings_edits(scene, samples, aovs, **settings).items()}
    renderer = Renderer(scene, threads=0, settings=edits)
    if renderer._inner.is_adaptive():
        raise ValueError("adaptive sampling decides from the whole picture and cannot be split into parts")
    if edits.get("film.crop") is not None and tiles > 1:
        raise ValueError("a picture with a crop cannot have tiles")
    total = int(renderer._inner.state()["total"])
    size = (renderer.camera["full_width"], renderer.camera["full_height"])
    if parts is None:
        parts = min(total, max(1, 4 * workers // tiles))
    data, digest = pack(scene)
    return data, Job(digest, edits, total, size, parts, tiles, threads, folder), renderer


def finished(renderer, film):
    """The picture of a film."""
    renderer.load(read(film))
    return renderer.picture()

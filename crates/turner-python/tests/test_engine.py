"""Parts over an engine, here one of threads in this process: what all engines share."""

import concurrent.futures
import contextlib
import glob
import os
import tempfile

import numpy as np
import pytest
import turner as tr
from turner.cluster import _engine, _parts


class Threads:
    """An engine of threads. Tasks that merge wait for those that they need."""

    def __init__(self, pool, number=2, broken=None):
        self.pool, self.number, self.broken = pool, number, broken
        self.parts, self.merges = [], []

    def workers(self, threads):
        return self.number // threads

    def scene(self, data, job):
        return data

    def part(self, given, job, index):
        self.parts.append(index)

        def work():
            if index == self.broken:
                raise OSError("the disk is full")
            return _parts.render_part(given, job, index)

        return self.pool.submit(work)

    def merge(self, films, job, name):
        self.merges.append((name, len(films)))
        return self.pool.submit(lambda: _parts.merge_part([film.result() for film in films], job, name))

    def result(self, tasks, last, report):
        for i, task in enumerate(tasks):
            task.result()
            if report:
                report((i + 1) / (len(tasks) + 1))
        return last.result()


@pytest.fixture
def render():
    """`_engine.render` over threads. Returns the picture and the engine."""

    def call(scene, samples=None, aovs=(), broken=None, number=2, **options):
        # Enough threads for the merges that wait.
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            engine = Threads(pool, number, broken)
            settings = {"is_here": False, "parts": None, "tiles": 1, "folder": None, "threads": 1, "progress": None}
            own = {key: options.pop(key, value) for key, value in settings.items()}
            out = _engine.render(contextlib.nullcontext(engine), scene, samples, aovs, settings=options, **own)
            return out, engine

    return call


@pytest.mark.parametrize(
    "tiles, parts, folder", [(1, 5, False), (3, 2, True), (1, 1, False), (2, 9, True), (11, 1, False), (3, 20, False)]
)
def test_parts_make_the_whole(scene, render, tmp_path, tiles, parts, folder):
    whole = tr.render(scene, 20, ["depth"], width=48)
    seen = []
    out, engine = render(
        scene, 20, ["depth"], width=48, tiles=tiles, parts=parts, folder=tmp_path if folder else None, progress=seen.append
    )
    assert np.array_equal(out.image, whole.image) and np.array_equal(out["depth"], whole["depth"])
    assert (out.samples, out.complete) == (20, True)
    assert engine.parts == list(range(tiles * parts))
    assert sum(films - 1 for _, films in engine.merges) == tiles * parts - 1
    assert seen == sorted(seen) and seen[-1] == 1.0
    assert len(list(tmp_path.iterdir())) == (len(engine.parts) + len(engine.merges) if folder else 0)


def test_the_number_of_parts_follows_workers_and_samples(scene, render):
    for number, threads, tiles, samples, parts in [(2, 1, 1, 64, 8), (4, 2, 1, 64, 8), (2, 1, 4, 64, 8), (8, 1, 1, 3, 3)]:
        _, engine = render(scene, samples, number=number, threads=threads, tiles=tiles, width=16, height=16)
        assert len(engine.parts) == parts


def test_a_temporary_folder_is_removed(scene, render, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    whole = tr.render(scene, 4).image
    out, engine = render(scene, 4, is_here=True, parts=2)
    assert np.array_equal(out.image, whole)
    with pytest.raises(OSError, match="disk is full"):
        render(scene, 4, is_here=True, parts=2, broken=1)
    assert glob.glob(os.path.join(tmp_path, "turner-films-*")) == []


def test_what_cannot_be_split_is_refused(scene, render):
    for error, settings in [
        ("99 parts of 8 samples", {"parts": 99}),
        ("tiles of 48 rows", {"tiles": 49}),
        ("adaptive sampling", {"adaptive": True}),
        ("a crop cannot have tiles", {"crop": (0, 0, 8, 8), "tiles": 2}),
    ]:
        with pytest.raises(ValueError, match=error):
            render(scene, 8, **settings)

"""Pictures and datasets over a Dask cluster: `pip install turner[dask]`.

Tasks name their results by what they are made of. With a shared `folder`, films are files: a worker that is lost costs the
task that it ran, and a render that was stopped continues. Without one, films travel as bytes; those that a lost worker held
are rendered again. Either way the picture has the same bytes as that of one process.
"""

from __future__ import annotations

import contextlib
import os
import time

from ..dataset._views import Options, record, tables
from ._engine import render as _render
from ._parts import merge_part, pack, render_part, unpack, write_bytes

#: Deaths of workers that a task may see before it is given up, in clusters that are made here.
DEATHS = 100


def held(data):
    """The scene's bytes as a result of their own, which the scheduler can make again."""
    return data


def view_task(data, digest, camera, number, options):
    """A view of a dataset on a worker."""
    return record(unpack(data, digest), camera, number, options)


@contextlib.contextmanager
def connected(client):
    """A client: the given one, one of a scheduler's address, or one of a cluster on this machine."""
    import dask
    from distributed import Client, LocalCluster

    if isinstance(client, Client):
        yield client
        return
    if isinstance(client, str):
        with Client(client) as made:
            yield made
        return
    with dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}):
        with LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as made:
                yield made


class _Dask:
    """Dask as an engine."""

    #: A task whose worker is lost runs again.
    options = {"pure": False, "retries": 2}

    def __init__(self, client):
        self.client = client

    def workers(self, threads):
        return len(self.client.scheduler_info(n_workers=-1)["workers"])

    def scene(self, data, job):
        """The path of a file that all see, or a result that each worker fetches once."""
        if job.folder is not None:
            path = os.path.join(job.folder, f"scene-{job.digest[:20]}.zip")
            if not os.path.exists(path):
                write_bytes(path, data)
            return path
        return self.client.submit(held, data, key=f"turner-scene-{job.digest[:20]}")

    def part(self, given, job, index):
        return self.client.submit(render_part, given, job, index, key=f"turner-part-{job.name}-{index}", **self.options)

    def merge(self, films, job, name):
        return self.client.submit(merge_part, films, job, name, key=f"turner-{name}-{job.name}", **self.options)

    def result(self, tasks, last, report):
        return _wait(tasks, last, report)


@contextlib.contextmanager
def _engine(client):
    with connected(client) as own:
        yield _Dask(own)


def _wait(futures, last, report):
    """Waits for the last future and reports the fraction of the others that is done."""
    try:
        while last.status == "pending":
            if report:
                report(sum(future.done() for future in futures) / (len(futures) + 1))
            time.sleep(0.05)
        return last.result()
    except BaseException:
        for future in [*futures, last]:
            future.cancel()
        raise


def render(scene, samples=None, aovs=(), *, client=None, parts=None, tiles=1, folder=None, threads=1, progress=None, **settings):
    """Renders a scene on a Dask cluster and returns its `Picture`.

    client: a `distributed.Client`, the address of a scheduler, or None for a cluster of processes on this machine.
    parts: ranges of samples; by default four a worker. tiles: bands of the picture, for pictures of very many pixels.
    folder: a folder that all workers see, for films; the caller removes it. By default a temporary one for a cluster on this
    machine. threads: of each task. Other arguments are those of `turner.render`.

    The bytes of the picture are those of `turner.render`, whatever happens to workers.
    """
    return _render(
        _engine(client),
        scene,
        samples,
        aovs,
        is_here=client is None,
        parts=parts,
        tiles=tiles,
        folder=folder,
        threads=threads,
        progress=progress,
        settings=settings,
    )


def views(scene, cameras, out, *, client=None, first=0, categories=None, progress=None, **options):
    """`turner.dataset.views` on a Dask cluster. `out` is a folder that all workers see. Arguments are the same; the files
    have the same bytes."""
    from .._progress import reporter

    known = ("aovs", "samples", "image", "format", "coco", "bop", "colmap_points", "occlusion", "units_to_mm")
    own = {key: options.pop(key) for key in known if key in options}
    options.pop("threads", None)
    common = Options(out, **own, settings={"threads": 1, **options})
    os.makedirs(common.out, exist_ok=True)
    data, digest = pack(scene)
    with connected(client) as connection, reporter(progress) as report:
        given = connection.submit(held, data, key=f"turner-scene-{digest[:20]}")
        futures = [
            connection.submit(view_task, given, digest, camera, first + i, common, pure=False, retries=2)
            for i, camera in enumerate(cameras)
        ]
        last = connection.submit(len, futures, pure=False)
        _wait(futures, last, report)
        records = connection.gather(futures)
        if report:
            report(1.0)
    return tables(scene, records, common, categories)


__all__ = ["render", "views"]

"""Pictures and datasets over a Dask cluster: `pip install turner[dask]`.

Tasks name their results by what they are made of. With a shared `folder`, films are files: a worker that is lost costs the
task that it ran, and a render that was stopped continues. Without one, films travel as bytes; those that a lost worker held
are rendered again. Either way the picture has the same bytes as that of one process.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import time

from ..dataset._views import Options, record, tables
from ._parts import finished, job_of, merge_part, pack, render_part, tree, unpack, write_bytes

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


def _scene_for(client, data, digest, folder):
    """What tasks get for the scene: the path of a file that all see, or a result that each worker fetches once."""
    if folder is not None:
        path = os.path.join(folder, f"scene-{digest[:20]}.zip")
        if not os.path.exists(path):
            write_bytes(path, data)
        return path
    return client.submit(held, data, key=f"turner-scene-{digest[:20]}")


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
    from .._progress import reporter

    made = None
    if client is None and folder is None:
        folder = made = tempfile.mkdtemp(prefix="turner-films-")
    try:
        with connected(client) as own, reporter(progress) as report:
            workers = max(1, len(own.scheduler_info(n_workers=-1)["workers"]))
            data, job, renderer = job_of(
                scene,
                samples,
                aovs,
                parts=parts,
                tiles=tiles,
                threads=threads,
                folder=folder,
                workers=workers,
                settings=settings,
            )
            given = _scene_for(own, data, job.digest, folder)
            options = {"pure": False, "retries": 2}
            futures = [
                own.submit(render_part, given, job, i, key=f"turner-part-{job.name}-{i}", **options)
                for i in range(len(job.parts))
            ]
            last = tree(
                futures,
                lambda group, name: own.submit(merge_part, group, job, name, key=f"turner-{name}-{job.name}", **options),
            )
            film = _wait(futures, last, report)
            picture = finished(renderer, film)
            if report:
                report(1.0)
            return picture
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)


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

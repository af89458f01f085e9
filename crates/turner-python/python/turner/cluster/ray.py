"""Pictures over a Ray cluster, with the interface of `turner.cluster.dask`: `pip install turner[ray]`."""

from __future__ import annotations

import contextlib
import shutil
import tempfile

from ._parts import finished, job_of, merge_part, render_part, tree


@contextlib.contextmanager
def connected(client):
    """A connection: one that exists, one of an address, or one of processes on this machine."""
    import ray

    if ray.is_initialized():
        yield ray
        return
    ray.init(address=client, include_dashboard=False, log_to_driver=False)
    try:
        yield ray
    finally:
        ray.shutdown()


def render(scene, samples=None, aovs=(), *, client=None, parts=None, tiles=1, folder=None, threads=1, progress=None, **settings):
    """Renders a scene on a Ray cluster and returns its `Picture`.

    client: the address of a cluster, or None for the one that `ray.init` made or for processes on this machine. Other
    arguments are those of `turner.cluster.dask.render`.
    """
    from .._progress import reporter

    made = None
    if client is None and folder is None:
        folder = made = tempfile.mkdtemp(prefix="turner-films-")
    try:
        with connected(client) as ray, reporter(progress) as report:
            workers = max(1, int(ray.cluster_resources().get("CPU", 1)) // threads)
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
            given = ray.put(data)
            # A lost worker's task runs again, however often.
            part = ray.remote(num_cpus=threads, max_retries=-1)(render_part)
            merge = ray.remote(num_cpus=1, max_retries=-1)(_merged)
            tasks = [part.remote(given, job, i) for i in range(len(job.parts))]
            last = tree(tasks, lambda group, name: merge.remote(job, name, *group))
            waiting, done = list(tasks), 0
            while waiting:
                ready, waiting = ray.wait(waiting, timeout=0.1)
                done += len(ready)
                if report:
                    report(done / (len(tasks) + 1))
            picture = finished(renderer, ray.get(last))
            if report:
                report(1.0)
            return picture
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)


def _merged(job, name, *films):
    return merge_part(list(films), job, name)


__all__ = ["render"]

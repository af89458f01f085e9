"""Pictures over a Ray cluster, with the interface of `turner.cluster.dask`: `pip install turner[ray]`."""

from __future__ import annotations

import contextlib

from ._engine import render as _render
from ._parts import merge_part, render_part


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


class _Ray:
    """Ray as an engine."""

    def __init__(self, ray):
        self.ray = ray
        # A lost worker's task runs again, however often.
        self.render_part = ray.remote(max_retries=-1)(render_part)
        self.merged = ray.remote(num_cpus=1, max_retries=-1)(_merged)

    def workers(self, threads):
        return int(self.ray.cluster_resources().get("CPU", 1)) // threads

    def scene(self, data, job):
        return self.ray.put(data)

    def part(self, given, job, index):
        return self.render_part.options(num_cpus=job.threads).remote(given, job, index)

    def merge(self, films, job, name):
        return self.merged.remote(job, name, *films)

    def result(self, tasks, last, report):
        waiting, done = list(tasks), 0
        while waiting:
            ready, waiting = self.ray.wait(waiting, timeout=0.1)
            done += len(ready)
            if report:
                report(done / (len(tasks) + 1))
        return self.ray.get(last)


@contextlib.contextmanager
def _engine(client):
    with connected(client) as ray:
        yield _Ray(ray)


def render(scene, samples=None, aovs=(), *, client=None, parts=None, tiles=1, folder=None, threads=1, progress=None, **settings):
    """Renders a scene on a Ray cluster and returns its `Picture`.

    client: the address of a cluster, or None for the one that `ray.init` made or for processes on this machine. Other
    arguments are those of `turner.cluster.dask.render`.
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


def _merged(job, name, *films):
    return merge_part(list(films), job, name)


__all__ = ["render"]

"""A picture over an engine that runs tasks: what all engines share."""

from __future__ import annotations

import shutil
import tempfile
from typing import Any, Protocol

from .._progress import reporter
from ._parts import finished, job_of, merged


class Engine(Protocol):
    """An engine. What it returns for a task (a future, a reference) may be given to `merge` and `result`."""

    def workers(self, threads: int) -> int:
        """How many tasks of so many threads run at once."""

    def scene(self, data: bytes, job) -> Any:
        """What the tasks get for the scene's bytes: `render_part` takes bytes or the path of a file."""

    def part(self, given, job, index: int) -> Any:
        """Starts `render_part(given, job, index)`."""

    def merge(self, films: list, job, name: str) -> Any:
        """Starts `merge_part(films, job, name)` after the tasks that make the films."""

    def result(self, tasks: list, last, report) -> bytes | str:
        """Waits for `last` and returns its film. `report`, if there is one, gets the fraction that is done."""


def render(connected, scene, samples, aovs, *, is_here, parts, tiles, folder, threads, progress, settings):
    """Renders a scene in parts, merges their films in trees, and returns the `Picture`.

    connected: a context manager of an `Engine`. is_here: whether all workers are on this machine; without a folder, films
    then go through a temporary one. An error of a task is raised here.
    """
    made = None
    if is_here and folder is None:
        folder = made = tempfile.mkdtemp(prefix="turner-films-")
    try:
        with connected as engine, reporter(progress) as report:
            data, job, renderer = job_of(
                scene,
                samples,
                aovs,
                parts=parts,
                tiles=tiles,
                threads=threads,
                folder=folder,
                workers=max(1, engine.workers(threads)),
                settings=settings,
            )
            given = engine.scene(data, job)
            tasks = [engine.part(given, job, i) for i in range(len(job.parts))]
            last = merged(tasks, job, lambda films, name: engine.merge(films, job, name))
            picture = finished(renderer, engine.result(tasks, last, report))
            if report:
                report(1.0)
            return picture
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)

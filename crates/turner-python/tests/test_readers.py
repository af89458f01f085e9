"""Others read a renderer while it runs: soon, and without a change of the result."""

import threading
import time

import numpy as np
import pytest
import turner as tr

#: Settings whose passes differ: independent samples, light paths, photons, samples that follow the noise.
SETTINGS = {
    "plain": {},
    "light paths": {"integrator.caustics": "light-tracing"},
    "photons": {"integrator.caustics": "full"},
    "adaptive": {"film.adaptive_sampling": True},
}


def watched(renderer, read, **goal):
    """Runs on a thread. Calls `read` until the run ends. Returns the results of `read` and the longest time of a call."""
    worker = threading.Thread(target=lambda: renderer.run(**goal))
    found, longest = [], 0.0
    worker.start()
    while worker.is_alive():
        begun = time.monotonic()
        found.append(read())
        longest = max(longest, time.monotonic() - begun)
    worker.join()
    return found, longest


def test_pictures_of_a_long_run_come_at_once(scene):
    renderer = tr.Renderer(scene, 1 << 22, ["depth"], width=640, height=480)
    worker = threading.Thread(target=renderer.run)
    worker.start()
    samples, waits = [], []
    for _ in range(5):
        time.sleep(0.2)
        begun = time.monotonic()
        out = renderer.picture()
        waits.append(time.monotonic() - begun)
        samples.append(out.samples)
        assert out.image.shape == (480, 640, 4) and not out.complete
    begun = time.monotonic()
    numbers = (renderer.samples, renderer.complete, len(renderer.film()))
    waits.append((time.monotonic() - begun) / len(numbers))
    until = time.monotonic() + 30
    while (noise := renderer.noise) is None and time.monotonic() < until:
        time.sleep(0.1)
    assert worker.is_alive()
    renderer.cancel()
    worker.join(10)
    assert not worker.is_alive()
    # About .1 s each; a loaded machine gets more.
    assert max(waits) < 1.5, waits
    assert samples == sorted(set(samples)) and numbers[0] > samples[-1] > 0
    assert noise > 0 and numbers[1] is False and numbers[2] > 0


@pytest.mark.parametrize("kind", SETTINGS)
@pytest.mark.parametrize("threads", [1, 2])
def test_readers_change_no_byte(scene, kind, threads):
    settings = {"width": 160, "height": 120, "threads": threads, "settings": SETTINGS[kind]}
    alone = tr.Renderer(scene, 64, ["normal"], **settings)
    alone.run()
    renderer = tr.Renderer(scene, 64, ["normal"], **settings)
    found, _ = watched(renderer, renderer.picture)
    assert renderer.complete and renderer.film() == alone.film()
    assert np.array_equal(renderer.picture().image, alone.picture().image)
    samples = [out.samples for out in found]
    assert samples == sorted(samples)


def test_a_run_to_low_noise_ends_at_the_same_sample(scene):
    films = []
    for read in (None, lambda renderer: renderer.samples):
        renderer = tr.Renderer(scene, 1 << 16, width=96, height=72)
        if read is None:
            renderer.run(noise=0.06)
        else:
            watched(renderer, lambda own=renderer: read(own), noise=0.06)
        assert not renderer.complete and renderer.noise <= 0.06
        films.append(renderer.film())
    assert films[0] == films[1]


def test_many_readers_do_not_stop_a_run(scene):
    renderer = tr.Renderer(scene, 256, width=160, height=120)
    over = threading.Event()

    def read():
        while not over.is_set():
            renderer.samples

    readers = [threading.Thread(target=read) for _ in range(8)]
    [reader.start() for reader in readers]
    worker = threading.Thread(target=renderer.run)
    worker.start()
    worker.join(60)
    ended = not worker.is_alive()
    over.set()
    renderer.cancel()
    [reader.join(10) for reader in readers]
    assert ended and not any(reader.is_alive() for reader in readers)


def test_a_progress_function_may_read(scene):
    renderer = tr.Renderer(scene, 512, width=160, height=120)
    seen = []
    renderer.run(progress=lambda fraction: seen.append((fraction, renderer.samples)))
    fractions, samples = zip(*seen)
    assert list(fractions) == sorted(fractions) and list(samples) == sorted(samples)
    assert seen[-1] == (1.0, 512)


def test_changes_wait_for_the_end_of_a_run(scene):
    part = tr.Renderer(scene, 512)
    part.run(512, first=256)
    renderer = tr.Renderer(scene, 512)
    worker = threading.Thread(target=lambda: renderer.run(256))
    worker.start()
    while renderer.samples == 0:
        time.sleep(0.001)
    renderer.merge(part.film())
    worker.join()
    assert renderer.complete

"""Pictures: arrays, AOVs, determinism, progress, cancel."""

import asyncio
import os
import signal
import threading
import time

import numpy as np
import pytest
import turner as tr


def test_arrays_have_shapes_types_and_no_copy(scene):
    out = tr.render(scene, aovs=["depth", "normal", "object_id", "cryptomatte", "position"])
    assert out.image.shape == (48, 64, 4) and out.image.dtype == np.float32
    assert out.display.shape == (48, 64, 4) and out.display.dtype == np.uint8
    assert out["depth"].shape == (48, 64) and out["depth"].dtype == np.float32
    assert out["normal"].shape == (48, 64, 3)
    assert out["object_id"].dtype == np.uint32
    assert out["cryptomatte"].shape == (48, 64, 12)
    for array in (out.image, out.display, *out.aovs.values()):
        # The memory is the renderer's own, handed over: the array is a view of it in another shape.
        assert array.flags.c_contiguous and array.base is not None
    assert out.names == {1: "ball", 2: "floor"}
    assert (out.samples, out.complete, out.non_finite) == (4, True, 0)


def test_ids_masks_and_names_agree(scene):
    out = tr.render(scene, 16, aovs=["object_id", "crypto_object"])
    hard = out["object_id"] == 1
    soft = out.mask("ball")
    assert 0 < hard.sum() < hard.size
    assert abs(soft.sum() - hard.sum()) < 0.05 * hard.sum()
    assert soft.min() >= 0 and soft.max() <= 1 + 1e-6
    with pytest.raises(KeyError, match="did you mean"):
        out.mask("bal")


def test_the_same_arguments_give_the_same_bytes(scene):
    films = []
    for threads in (1, 2, 3):
        renderer = tr.Renderer(scene, 8, ["normal"], threads=threads)
        if threads == 2:
            renderer.step(3)
        renderer.run()
        films.append(renderer.film())
    assert films[0] == films[1] == films[2]


def test_the_command_line_makes_the_same_picture(scene, tmp_path):
    scene.save(tmp_path / "a.toml")
    import subprocess
    import sys

    made = tmp_path / "cli.exr"
    command = [sys.executable, "-m", "turner", "render", str(tmp_path / "a.toml"), "-o", str(made), "--aov", "depth"]
    subprocess.run([*command, "--quiet"], check=True)
    out = tr.render(tmp_path / "a.toml", aovs=["depth"])
    out.save(tmp_path / "python.exr")
    # Pixels and AOVs of both files, by the command line itself: no difference at all.
    for layer in ([], ["--layer", "Z"]):
        compare = [sys.executable, "-m", "turner", "compare", str(made), str(tmp_path / "python.exr")]
        subprocess.run([*compare, "--metric", "max", "--tolerance", "0", *layer], check=True, stdout=subprocess.DEVNULL)
    assert np.array_equal(out.image, tr.render(scene).image)


def test_parts_of_a_picture_merge_to_the_whole(scene):
    whole = tr.Renderer(scene, 8)
    whole.run()
    parts = []
    for first in (0, 3, 6):
        part = tr.Renderer(scene, 8)
        part.run(min(first + 3, 8), first=first)
        parts.append(part.film())
    merged = tr.merge_films(reversed(parts))
    assert merged == whole.film()
    loaded = tr.Renderer(scene, 8)
    loaded.load(merged)
    assert loaded.complete and np.array_equal(loaded.picture().image, whole.picture().image)
    with pytest.raises(ValueError, match="hold"):
        loaded.merge(parts[0])
    with pytest.raises(ValueError, match="checksum|cannot be read"):
        loaded.load(merged[:-3] + b"abc")


def test_films_that_do_not_belong_together_are_refused_with_a_remedy(scene):
    def film(first=0, end=4, **settings):
        renderer = tr.Renderer(scene, 4, **settings)
        renderer.run(end, first=first)
        return renderer.film()

    whole, first, other = film(), film(0, 2), film(2, 4)
    assert tr.merge_films([first, other]) == whole
    left, right = ((0, 0, 32, 48), (32, 0, 32, 48))
    cases = [
        ("E0107", r"films\[0\] and films\[1\].* seed: 0 and 7", "same settings", [whole, film(seed=7)]),
        ("E0107", "size: 64x48 and 32x48", "same settings", [whole, film(width=32, crop=(0, 0, 32, 48))]),
        ("E0107", "have different channels", "aovs", [whole, film(aovs=["depth"])]),
        ("E0107", r"films\[1\] and films\[2\].* hold samples 2 to 3", "once", [film(crop=left), other, whole]),
        ("E0107", "leave a gap", "missing parts", [film(crop=left), film(crop=(40, 0, 24, 48))]),
        ("E0107", "overlap", "pixels of its own", [film(crop=left), film(crop=(16, 0, 48, 48))]),
        ("E0107", "hold different samples", "missing samples", [film(crop=left), film(0, 2, crop=right)]),
        ("E0207", r"films\[1\].* cannot be read", "again", [whole, b"x"]),
        ("E0207", "no films", "all parts", []),
    ]
    for code, message, remedy, films in cases:
        with pytest.raises(tr.SceneError, match=message) as caught:
            tr.merge_films(films)
        assert remedy in caught.value.help, caught.value
        assert caught.value.code == code, caught.value
    renderer = tr.Renderer(scene, 4)
    renderer.run(2)
    for wrong, remedy in [(first, "once"), (film(seed=7), "same settings")]:
        with pytest.raises(tr.SceneError) as caught:
            renderer.merge(wrong)
        assert remedy in caught.value.help
    with pytest.raises(tr.SceneError, match="another picture") as caught:
        renderer.load(film(seed=7))
    assert "settings of the film" in caught.value.help
    renderer.merge(other)
    assert renderer.film() == whole


def test_progress_rises_to_the_end(scene):
    seen = []
    tr.render(scene, 256, width=256, height=192, progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1.0


def test_an_exception_of_progress_ends_the_render(scene):
    class Enough(Exception):
        pass

    def stop(fraction):
        raise Enough

    begun = time.monotonic()
    with pytest.raises(Enough):
        tr.render(scene, 1 << 20, progress=stop)
    assert time.monotonic() - begun < 5


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_ends_a_render_soon(scene):
    ended = []

    def interrupt():
        ended.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.4, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        tr.render(scene, 1 << 22, width=640, height=480)
    # The limit is .2 s; a loaded machine gets more.
    assert time.monotonic() - ended[0] < 2


def test_cancel_from_another_thread_keeps_the_samples(scene):
    renderer = tr.Renderer(scene, 1 << 22)
    worker = threading.Thread(target=renderer.run)
    worker.start()
    time.sleep(0.3)
    renderer.cancel()
    worker.join(5)
    assert not worker.is_alive()
    assert renderer.samples > 0 and not renderer.complete


def test_asyncio_goes_on_and_cancels(scene):
    async def main():
        renderer = tr.Renderer(scene, 1 << 22)
        task = asyncio.create_task(renderer.run_async())
        beats = 0
        for _ in range(10):
            await asyncio.sleep(0.02)
            beats += 1
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return beats, renderer.samples

    beats, samples = asyncio.run(main())
    assert beats == 10 and samples > 0


def test_threads_render_side_by_side(scene):
    alone = tr.render(scene, 8).image
    found = [None] * 4

    def one(i):
        found[i] = tr.render(scene, 8, threads=1).image

    workers = [threading.Thread(target=one, args=(i,)) for i in range(4)]
    [w.start() for w in workers]
    [w.join() for w in workers]
    assert all(np.array_equal(alone, image) for image in found)


def test_a_time_limit_gives_a_whole_picture(scene):
    out = tr.render(scene, seconds=0.3, width=320, height=240)
    assert out.samples > 0 and np.isfinite(out.image).all() and (out.image[..., 3] > 0).all()
    with pytest.raises(ValueError):
        tr.render(scene, seconds=-1)


def test_noise_is_reached(scene):
    out = tr.render(scene, noise=0.2)
    assert out.noise <= 0.2


def test_files_of_all_formats(scene, tmp_path):
    out = tr.render(scene, aovs=["depth"])
    for name in ("a.png", "a.exr", "a.jpg", "a.webp", "a.hdr"):
        out.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100
    assert out._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    with pytest.raises(OSError):
        out.save(tmp_path / "a.xyz")
    with pytest.raises(OSError):
        out.save(tmp_path / "missing" / "a.png")


def test_debug_views_and_denoising(scene):
    normals = tr.render(scene, integrator="normals")
    assert normals.samples == 1
    clean = tr.denoise(scene, 16)
    noisy = tr.render(scene, 16)
    truth = tr.render(scene, 1024)
    error = [tr.compare(truth, p)["rmse"] for p in (noisy, clean)]
    assert error[1] < error[0]


def test_labels_are_those_of_a_picture_with_one_sample(scene):
    aovs = ["depth", "normal", "object_id", "position", "albedo", "instance_id"]
    out = tr.render(scene, 1, aovs, antialias="none", warn=False)
    for threads in (1, 2):
        found = tr.labels(scene, aovs, threads=threads)
        for aov in aovs:
            assert np.array_equal(found[aov], out[aov]), aov
    assert found.names == out.names and found.camera["K"] == out.camera["K"]
    with pytest.raises(tr.SceneError, match="first surface"):
        tr.labels(scene, ["direct"])


def test_an_integrator_brings_its_sampling():
    plain = tr.Scene(objects=[tr.Sphere()], lights=[tr.AmbientLight(intensity=1)], film={"width": 16, "height": 16})
    assert plain.film.samples == 16 and plain.film.antialias == "none"
    out = tr.render(plain, integrator="path")
    assert out.samples == 64
    plain.integrator = tr.PathIntegrator(max_depth=3)
    assert plain.film.samples == 64 and plain.integrator.max_depth == 3


def test_memory_does_not_grow(scene):
    import gc
    import resource

    def used():
        gc.collect()
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * resource.getpagesize()

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("needs /proc")

    def once(i):
        scene.objects["ball"].radius = 0.5 + 0.0001 * (i % 100)
        tr.render(scene, 1, aovs=["depth"], camera=tr.Camera.look_at((0, 2, 6 + 0.001 * i), (0, 1, 0)))

    for i in range(100):
        once(i)
    before = used()
    for i in range(1000):
        once(i)
    assert used() - before < 8 << 20

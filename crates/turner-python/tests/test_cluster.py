"""Many processes: the same bytes, whatever happens to them."""

import os
import random
import signal
import threading

import numpy as np
import pytest
import turner as tr
from turner.cluster import _parts

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def cluster():
    import dask
    from turner.cluster.dask import DEATHS

    with dask.config.set({"distributed.scheduler.allowed-failures": DEATHS}):
        with distributed.LocalCluster(n_workers=4, threads_per_worker=1, dashboard_address=None) as made:
            with distributed.Client(made) as client:
                yield client


def test_a_scene_travels_as_the_same_bytes(scene, bumpy):
    points, faces, _, _ = bumpy
    scene.objects.append(tr.Mesh(vertices=points, faces=faces, name="m"))
    (data, digest), again = _parts.pack(scene), _parts.pack(scene)
    assert (data, digest) == again
    copy = _parts.unpack(data, digest)
    assert _parts.unpack(data, digest) is copy
    assert np.array_equal(tr.render(copy, 2).image, tr.render(scene, 2).image)
    with pytest.raises(ValueError, match="hash"):
        _parts.unpack(data + b"x", "0" * 64)


@pytest.mark.parametrize("tiles, parts", [(1, 5), (3, 2), (1, 1)])
def test_parts_make_the_whole(scene, cluster, tmp_path, tiles, parts):
    from turner.cluster import dask

    whole = tr.render(scene, 8, ["depth"])
    for folder in (None, tmp_path):
        out = dask.render(scene, 8, ["depth"], client=cluster, parts=parts, tiles=tiles, folder=folder)
        assert np.array_equal(out.image, whole.image) and np.array_equal(out["depth"], whole["depth"])
    with pytest.raises(ValueError, match="parts"):
        dask.render(scene, 8, client=cluster, parts=99)
    with pytest.raises(ValueError, match="adaptive"):
        dask.render(scene, 8, client=cluster, adaptive=True)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_killed_workers_change_nothing(scene, cluster, tmp_path):
    from turner.cluster import dask

    runs = int(os.environ.get("TURNER_KILLS", "2"))
    whole = tr.Renderer(scene, 64, width=320, height=240)
    whole.run()
    expected = whole.picture().image
    for run in range(runs):
        rng, done = random.Random(run), threading.Event()

        def kill():
            while not done.wait(rng.uniform(0.1, 0.5)):
                pids = [info["pid"] for info in cluster.run(lambda: {"pid": os.getpid()}).values()]
                if pids:
                    os.kill(rng.choice(pids), signal.SIGKILL)
                    return

        killer = threading.Thread(target=kill)
        killer.start()
        folder = tmp_path / str(run)
        folder.mkdir()
        out = dask.render(scene, 64, client=cluster, parts=16, width=320, height=240, folder=folder)
        done.set()
        killer.join()
        assert np.array_equal(out.image, expected)


def test_views_are_those_of_one_process(scene, cluster, tmp_path):
    from turner.cluster import dask

    cameras = tr.dataset.orbit(4)
    tr.dataset.views(scene, cameras, tmp_path / "one", samples=1, aovs=["depth"], coco=True)
    dask.views(scene, cameras, tmp_path / "many", client=cluster, samples=1, aovs=["depth"], coco=True)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file())
    assert len(files) > 8
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "many" / file).read_bytes(), file


def test_trees_merge_everything_once():
    merged = _parts.tree(list(range(100)), lambda group, name: tuple(group))

    def flat(item):
        return [item] if isinstance(item, int) else [leaf for part in item for leaf in flat(part)]

    assert flat(merged) == list(range(100))
    assert _parts.tree([7], None) == 7

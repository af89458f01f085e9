"""Datasets: views with labels, formats of others, randomisation."""

import json
import pickle

import numpy as np
import pytest
import turner as tr
from turner import dataset


@pytest.fixture
def model():
    """Two balls, one before the other."""
    return tr.Scene(
        objects=[
            tr.Sphere(name="near", radius=0.5, transform={"translate": [0, 0, 2]}),
            tr.Sphere(name="far", radius=1.0),
        ],
        lights=[tr.EnvironmentLight()],
        camera=tr.Camera.look_at((0, 0, 6), (0, 0, 0)),
        film={"width": 64, "height": 48, "samples": 2},
        integrator="path",
    )


def read_png(path):
    from PIL import Image

    return np.array(Image.open(path))


def test_views_write_what_others_read(model, tmp_path):
    cameras = dataset.orbit(4, elevation=10)
    dataset.views(model, cameras, tmp_path, aovs=["depth", "normal"], coco=True, bop=True, threads=2)
    table = json.loads((tmp_path / "transforms.json").read_text())
    assert len(table["frames"]) == 4 and table["w"] == 64
    for number, frame in enumerate(table["frames"]):
        pose = np.array(frame["transform_matrix"])
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
        depth = np.load(tmp_path / "depth" / f"{number:06}.npy")
        picture = read_png(tmp_path / frame["file_path"])
        assert depth.shape == (48, 64) and picture.shape[:2] == (48, 64)
    # COLMAP's poses are the inverses of those of transforms.json, with the axes of OpenCV.
    lines = [line for line in (tmp_path / "colmap" / "images.txt").read_text().splitlines() if line and line[0] != "#"]
    assert len(lines) == 4
    for line, frame in zip(lines, table["frames"]):
        w, x, y, z, *t = map(float, line.split()[1:8])
        R = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        camera_to_world = np.array(frame["transform_matrix"]) @ np.diag([1, -1, -1, 1])
        assert np.allclose(np.linalg.inv(camera_to_world)[:3], np.column_stack([R, t]), atol=1e-9)
    points = [line for line in (tmp_path / "colmap" / "points3D.txt").read_text().splitlines() if line[0] != "#"]
    assert len(points) > 20


def test_masks_boxes_and_occlusion(model, tmp_path):
    front = tr.Camera.look_at((0, 0, 6), (0, 0, 0))
    dataset.views(model, [front], tmp_path, coco=True, bop=True)
    coco = json.loads((tmp_path / "annotations.json").read_text())
    names = {c["id"]: c["name"] for c in coco["categories"]}
    found = {names[a["category_id"]]: a for a in coco["annotations"]}
    assert found["near"]["visible_fraction"] == 1
    assert 0.2 < found["far"]["visible_fraction"] < 0.9
    for annotation in coco["annotations"]:
        counts, (height, width) = annotation["segmentation"]["counts"], annotation["segmentation"]["size"]
        flat = np.concatenate([np.full(n, i % 2) for i, n in enumerate(counts)])
        mask = flat.reshape(width, height).T
        assert mask.sum() == annotation["area"]
        x, y, w, h = annotation["bbox"]
        assert mask[y : y + h, x : x + w].sum() == mask.sum() and mask[y].any() and mask[:, x].any()
    truth = json.loads((tmp_path / "scene_gt.json").read_text())["0"]
    facts = json.loads((tmp_path / "scene_gt_info.json").read_text())["0"]
    # The near ball stands 4 units from the camera, straight ahead.
    assert np.allclose(truth[0]["cam_t_m2c"], [0, 0, 4000], atol=1e-6)
    assert facts[1]["px_count_all"] > facts[1]["px_count_visib"] > 0
    whole = read_png(tmp_path / "mask" / "000000_000001.png") > 0
    seen = read_png(tmp_path / "mask_visib" / "000000_000001.png") > 0
    assert whole.sum() == facts[1]["px_count_all"] and (whole & ~seen).any() and not (seen & ~whole).any()
    depth = read_png(tmp_path / "depth" / "000000.png")
    assert abs(int(depth[24, 32]) * 0.1 - 3500) < 5


def test_the_same_call_writes_the_same_bytes(model, tmp_path):
    texts = []
    for folder, threads in (("a", 1), ("b", 3)):
        dataset.views(model, dataset.hemisphere(5), tmp_path / folder, aovs=["object_id"], coco=True, threads=threads)
        files = sorted(p for p in (tmp_path / folder).rglob("*") if p.is_file())
        texts.append([(str(p.relative_to(tmp_path / folder)), p.read_bytes()) for p in files])
    assert texts[0] == texts[1]
    assert not any(".tmp" in name or "/." in name for name, _ in texts[0])


@pytest.mark.parametrize("format", ["png", "npy", "exr"])
def test_formats(model, tmp_path, format):
    dataset.views(model, dataset.orbit(2), tmp_path, aovs=["depth"], format=format)
    assert len(list((tmp_path / "images").iterdir())) == 2
    with pytest.raises(ValueError, match="format"):
        dataset.views(model, [], tmp_path, format="gif")


def test_run_lengths_in_closed_form():
    mask = np.zeros((3, 4), bool)
    mask[1, 1] = mask[2, 1] = True
    assert dataset.rle(mask) == {"size": [3, 4], "counts": [4, 2, 6]}
    assert dataset.rle(np.ones((2, 2)))["counts"] == [0, 4]
    assert dataset.boxes(mask.astype(int)) == {1: {"box": [1, 1, 1, 2], "pixels": 2}}


def test_png_files_hold_the_values(tmp_path):
    rng = np.random.default_rng(1)
    for array in (
        rng.integers(0, 256, (7, 5), np.uint8),
        rng.integers(0, 65536, (7, 5), np.uint16),
        rng.integers(0, 256, (7, 5, 3), np.uint8),
        rng.integers(0, 256, (7, 5, 4), np.uint8),
    ):
        dataset.write_png(tmp_path / "a.png", array)
        assert np.array_equal(read_png(tmp_path / "a.png"), array)


def test_items_are_drawn_from_their_number_alone(model, tmp_path):
    variations = {
        "object.0.radius": dataset.uniform(0.2, 0.6),
        "light.0.strength": dataset.choice([0.5, 1.0, 2.0]),
        "camera": lambda rng: tr.Camera.orbit(rng.uniform(0, 360), rng.uniform(5, 60)),
        "film.exposure": 0.5,
    }
    many = dataset.items(model, 4, variations, tmp_path / "many", seed=7)
    dataset.items(model, 1, variations, tmp_path / "one", seed=7, first=2)
    name = "images/000002.png"
    assert (tmp_path / "many" / name).read_bytes() == (tmp_path / "one" / name).read_bytes()
    assert many[2]["object.0.radius"] == dataset.item(variations, 2, 7)["object.0.radius"]
    assert len({values["object.0.radius"] for values in many}) == 4
    # A value does not depend on the other variations.
    alone = dataset.item({"object.0.radius": variations["object.0.radius"]}, 2, 7)
    assert alone["object.0.radius"] == many[2]["object.0.radius"]
    lines = (tmp_path / "many" / "items-000000-000003.jsonl").read_text().splitlines()
    assert json.loads(lines[2])["values"]["object.0.radius"] == many[2]["object.0.radius"]
    assert model.objects[0].radius == 0.5


def one_view(arguments):
    views, index = arguments
    return views[index]["depth"]


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_views_are_a_dataset_for_workers(model, tmp_path, method):
    import multiprocessing

    model.save(tmp_path / "model.toml")
    views = dataset.Views(tmp_path / "model.toml", dataset.orbit(3), aovs="depth", samples=1)
    assert len(views) == 3 and set(views[0]) == {"image", "depth", "K", "camera_to_world"}
    pickle.dumps(views)
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map(one_view, [(views, i) for i in range(3)])
    assert all(np.array_equal(views[i]["depth"], found[i]) for i in range(3))
    with pytest.raises(IndexError):
        views[3]

"""Views of a model as a PyTorch dataset: `python examples/python/torch_dataset.py scenes/guides/solids.toml`.

`turner.dataset.Views` is a map-style dataset as it is. Workers load the scene themselves, so they may be forked or spawned.
"""

import sys

import turner as tr


def views(path, count=64):
    """Views of a scene with depth and normals, 160 x 120 pixels."""
    cameras = tr.dataset.hemisphere(count)
    return tr.dataset.Views(path, cameras, samples=4, aovs=["depth", "normal"], width=160, height=120)


def main(path):
    """One pass over the views in batches of 8, by two workers."""
    from torch.utils.data import DataLoader

    loader = DataLoader(views(path), batch_size=8, shuffle=True, num_workers=2)
    for batch in loader:
        images = batch["image"][..., :3].permute(0, 3, 1, 2)
        print(images.shape, batch["depth"].shape, batch["camera_to_world"].shape)


if __name__ == "__main__":
    main(sys.argv[1])

"""COCO: masks and boxes of what is seen, and how much of it is hidden."""

from __future__ import annotations


def rle(mask):
    """A mask (height, width) as COCO's run lengths: counts of 0s and 1s in turn, column by column."""
    import numpy as np

    flat = np.asarray(mask, bool).ravel(order="F")
    edges = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    ends = np.concatenate([[0], edges, [flat.size]])
    counts = np.diff(ends).tolist()
    if flat.size and flat[0]:
        counts.insert(0, 0)
    return {"size": [int(v) for v in np.shape(mask)], "counts": counts}


def box(mask):
    """The box of a mask as [x, y, width, height] in pixels; None if it is empty."""
    import numpy as np

    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if rows.size == 0:
        return None
    x, y = int(columns[0]), int(rows[0])
    return [x, y, int(columns[-1]) + 1 - x, int(rows[-1]) + 1 - y]


def boxes(ids):
    """For each number in an array of ids: its box [x, y, width, height] and its pixels. 0 counts as nothing."""
    import numpy as np

    ids = np.asarray(ids)
    numbers, counts = np.unique(ids, return_counts=True)
    return {int(number): {"box": box(ids == number), "pixels": int(count)} for number, count in zip(numbers, counts) if number}


class Coco:
    """Gathers the annotations of pictures."""

    def __init__(self, categories=None):
        self.category_of = categories or (lambda name: name)
        self.categories: dict = {}
        self.images: list = []
        self.annotations: list = []

    def _category(self, name):
        found = self.category_of(name)
        return None if found is None else self.categories.setdefault(str(found), len(self.categories) + 1)

    def add(self, number, file, ids, names, whole=None):
        """The annotations of a picture. `whole`: pixels of each id as if nothing stood before it."""
        height, width = ids.shape
        self.images.append({"id": number, "file_name": file, "width": width, "height": height})
        for label, found in boxes(ids).items():
            name = names.get(label, str(label))
            category = self._category(name)
            if category is None:
                continue
            annotation = {
                "id": len(self.annotations) + 1,
                "image_id": number,
                "category_id": category,
                "object": name,
                "bbox": found["box"],
                "area": found["pixels"],
                "iscrowd": 0,
                "segmentation": rle(ids == label),
            }
            if whole is not None and whole.get(label):
                annotation["visible_fraction"] = found["pixels"] / whole[label]["pixels"]
                annotation["full_bbox"] = whole[label]["box"]
            self.annotations.append(annotation)

    def table(self):
        """The file's contents."""
        categories = [{"id": number, "name": name} for name, number in self.categories.items()]
        return {"images": self.images, "annotations": self.annotations, "categories": categories}

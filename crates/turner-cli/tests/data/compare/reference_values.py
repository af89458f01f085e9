"""Reference values of the metrics, by others' programs.

    pip install flip-evaluator==1.7 scikit-image numpy
    python reference_values.py > values.json

FLIP is by its authors' package, SSIM by scikit-image with the window of Wang et al. 2004; the pictures are those of this folder.
"""

import json
import pathlib

import flip_evaluator
import numpy as np
from skimage.metrics import structural_similarity

HERE = pathlib.Path(__file__).parent


def load(name):
    return np.ascontiguousarray(flip_evaluator.load(str(HERE / name))[:, :, :3].astype(np.float32))


def worst(picture):
    y, x = np.unravel_index(np.argmax(picture), picture.shape)
    return [int(x), int(y), float(picture[y, x])]


def flip(a, b, kind):
    picture, mean, used = flip_evaluator.evaluate(a, b, kind, applyMagma=False)
    picture = picture[:, :, 0]
    # A sample of the map: every 7th column of every 5th row.
    sample = [round(float(v), 7) for v in picture[::5, ::7].ravel()]
    return {"mean": float(mean), "worst": worst(picture), "sample": sample, "exposures": int(used["numExposures"])}


def ssim(a, b):
    return structural_similarity(
        a, b, data_range=1.0, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False
    )


values = []
for a, b in [("reference.png", "noisy.png"), ("reference.png", "brighter.png"), ("noisy.png", "brighter.png")]:
    x, y = load(a), load(b)
    similar = float(ssim(x.astype(np.float64), y.astype(np.float64)))
    values.append({"a": a, "b": b, "flip": flip(x, y, "LDR"), "ssim": similar})
for a, b in [("reference.exr", "noisy.exr"), ("light.exr", "light-noisy.exr")]:
    x, y = load(a), load(b)
    values.append({"a": a, "b": b, "flip": flip(x, y, "HDR"), "ssim": None})
print("[" + ",\n".join(json.dumps(v) for v in values) + "]")

"""Files that appear whole or not at all: PNG, NPY, JSON, text."""

from __future__ import annotations

import json
import os
import struct
import tempfile
import zlib


def atomically(path, write):
    """Calls `write(temporary path)` and renames the file, so that a reader never sees a part of it."""
    path = os.fspath(path)
    folder, name = os.path.split(path)
    stem, extension = os.path.splitext(name)
    handle, temporary = tempfile.mkstemp(extension, f".{stem}-", folder or ".")
    os.close(handle)
    try:
        write(temporary)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def write_bytes(path, data):
    """Writes bytes."""

    def write(temporary):
        with open(temporary, "wb") as file:
            file.write(data)

    atomically(path, write)


def write_json(path, data):
    """Writes JSON; floats with all their digits."""
    write_bytes(path, (json.dumps(data, indent=1) + "\n").encode())


def write_npy(path, array):
    """Writes a NumPy file."""
    import numpy as np

    def write(temporary):
        with open(temporary, "wb") as file:
            np.save(file, array)

    atomically(path, write)


def write_png(path, array, level=6):
    """Writes a PNG of uint8 or uint16: (height, width) grey, (…, 3) RGB or (…, 4) RGBA with straight alpha."""
    import numpy as np

    array = np.asarray(array)
    if array.dtype == bool:
        array = array.astype(np.uint8) * np.uint8(255)
    if array.dtype not in (np.uint8, np.uint16):
        raise TypeError(f"a PNG of {array.dtype}; expected uint8, uint16 or bool")
    kind = {2: 0, 3: {1: 0, 3: 2, 4: 6}.get(array.shape[-1])}.get(array.ndim)
    if kind is None:
        raise ValueError(f"a PNG of shape {array.shape}; expected (height, width) or (height, width, 1, 3 or 4)")
    height, width = array.shape[:2]
    rows = np.ascontiguousarray(array.astype(array.dtype.newbyteorder(">"))).view(np.uint8).reshape(height, -1)
    # The filter "up" where rows resemble one another: masks and depth compress well.
    up = rows.copy()
    up[1:] -= rows[:-1]
    lines = np.concatenate([np.full((height, 1), 2, np.uint8), up], 1)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, 8 * array.dtype.itemsize, kind, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes(), level)) + chunk(b"IEND", b"")
    write_bytes(path, b"\x89PNG\r\n\x1a\n" + body)

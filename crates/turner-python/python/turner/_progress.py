"""Progress: a bar in a notebook or a terminal, or a function of the caller's."""

from __future__ import annotations

import contextlib
import sys
import time


def in_notebook():
    """Whether this runs in a Jupyter kernel."""
    shell = sys.modules.get("IPython")
    get = getattr(shell, "get_ipython", None)
    return bool(get and get() and hasattr(get(), "kernel"))


class _Line:
    """A line on standard error: fraction and time left."""

    def __init__(self):
        self.begun, self.shown = time.monotonic(), 0.0

    def __call__(self, fraction):
        now = time.monotonic()
        if now - self.shown < 0.1 and fraction < 1:
            return
        self.shown = now
        gone = now - self.begun
        left = f", {gone * (1 - fraction) / fraction:.0f} s left" if 0.01 < fraction < 1 else ""
        filled = round(30 * fraction)
        sys.stderr.write(f"\r{'█' * filled}{'░' * (30 - filled)} {100 * fraction:3.0f} %{left}   ")
        sys.stderr.flush()

    def close(self):
        sys.stderr.write("\n")


class _Widget:
    """A bar in a notebook."""

    def __init__(self):
        import ipywidgets
        from IPython.display import display

        self.bar = ipywidgets.FloatProgress(min=0, max=1, description="Rendering")
        display(self.bar)

    def __call__(self, fraction):
        self.bar.value = fraction

    def close(self):
        self.bar.close()


@contextlib.contextmanager
def reporter(progress):
    """The function that gets the fraction done; None for none."""
    if progress is None or progress is False:
        yield None
        return
    if callable(progress):
        yield progress
        return
    bar = None
    if in_notebook():
        with contextlib.suppress(ImportError):
            bar = _Widget()
    bar = bar or _Line()
    try:
        yield bar
    finally:
        bar.close()

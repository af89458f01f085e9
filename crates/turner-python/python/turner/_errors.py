"""Errors and warnings of scenes."""

from __future__ import annotations

import warnings


class SceneError(ValueError):
    """What is wrong in a scene, where, and the remedy.

    Attributes:
        code: the stable code, such as "E0102"; `turner help E0102` explains it.
        message: the problem in one sentence.
        file, line, column: the position in a file, from 1; None for values from Python.
        path: the key path of a value from Python, such as "objects[3].radius".
        help: the remedy in words, such as the nearest valid name, or None.
        others: further errors of the same scene.
    """

    def __init__(self, message, code="E0901", file=None, line=None, column=None, path=None, help=None, others=()):
        self.message = message
        self.code = code
        self.file = file
        self.line = line
        self.column = column
        self.path = _in_python(path)
        self.help = help
        self.others = list(others)
        super().__init__(self._text())

    def _text(self):
        place = ""
        if self.file is not None:
            place = f"{self.file}:{self.line}:{self.column}: "
        elif self.path:
            place = f"{self.path}: "
        text = f"[{self.code}] {place}{self.message}"
        if self.help:
            text += f"\n  help: {self.help}"
        for other in self.others:
            text += f"\n{other}"
        return text

    def __reduce__(self):
        fields = (self.message, self.code, self.file, self.line, self.column, self.path, self.help, self.others)
        return (SceneError, fields)


def _in_python(path):
    """`object[3].radius`, as `Scene` names it: `objects[3].radius`."""
    head, bracket, rest = (path or "").partition("[")
    return f"{head}s[{rest}" if bracket and head in ("object", "light", "view", "animation") else path


class SceneWarning(UserWarning):
    """Something in a scene is ignored, approximated or doubtful."""


def issue(kind, message, place, count):
    """Issues a warning of the renderer as Python's."""
    text = f"{kind}: {message}"
    if place:
        text = f"{place}: {text}"
    if count > 1:
        text += f" ({count} times)"
    warnings.warn(text, SceneWarning, stacklevel=3)

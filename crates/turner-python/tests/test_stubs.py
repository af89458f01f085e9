"""The type stubs agree with the schema."""

import ast
from pathlib import Path

import turner
from turner import _stubs


def test_the_stubs_are_those_of_the_schema():
    text = _stubs.text()
    ast.parse(text)
    written = Path(turner.__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
    assert written == text, "run `python -m turner._stubs crates/turner-python/python/turner/__init__.pyi`"

from typing import Any

VERSION: str

def __getattr__(name: str) -> Any: ...

"""Packages that are used where they are installed."""

from __future__ import annotations

import importlib
from typing import Any

from softfish._errors import MissingError


def optional(name: str) -> Any:
    """The module `name`, or a `MissingError`."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.split(".")[0]
        raise MissingError(f"the package `{package}` is not installed", str(error), f"pip install {package}") from error

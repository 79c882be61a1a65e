"""Type checkers accept the code of the notebooks under strict rules, and find planted mistakes."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import SOURCE

NOTEBOOKS = sorted((SOURCE / "notebooks").glob("*.ipynb"))
MISTAKES = Path(__file__).with_name("mistakes.py")


def run(folder: Path, *words: str | Path) -> str:
    """What a checker says; it takes packages of `folder` before installed ones."""
    command = [sys.executable, "-m", *map(str, words)]
    ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=900, check=False)
    return ran.stdout + ran.stderr


def mypy(files: list[Path]) -> list[tuple[str, int, str]]:
    """File, line and message of each error."""
    # what other packages leave without types is not ours
    others = ["--disable-error-code=import-untyped", *(f"--untyped-calls-exclude={name}" for name in ("torch", "jax"))]
    said = run(files[0].parent, "mypy", "--strict", "--no-error-summary", "--cache-dir", files[0].parent / ".mypy_cache", *others, *files)
    found = re.findall(r"^(.+?):(\d+): error: (.*)$", said, flags=re.MULTILINE)
    return [(Path(name).name, int(line), message) for name, line, message in found]


def pyright(files: list[Path]) -> list[tuple[str, int, str]]:
    """File, line and message of each error."""
    package = (files[0].parent / "__init__.py").exists()
    said = run(files[0].parents[package], "pyright", "--pythonpath", sys.executable, "--outputjson", *files)
    if "{" not in said:
        pytest.skip(f"pyright does not start: {said[-200:]}")
    errors = [one for one in json.loads(said[said.index("{") :])["generalDiagnostics"] if one["severity"] == "error"]
    return [(Path(one["file"]).name, one["range"]["start"]["line"] + 1, one["message"]) for one in errors]


@pytest.fixture(scope="module", params=[mypy, pyright], ids=lambda checker: checker.__name__)
def checker(request: pytest.FixtureRequest) -> Callable[[list[Path]], list[tuple[str, int, str]]]:
    if importlib.util.find_spec(request.param.__name__) is None:
        pytest.skip(f"{request.param.__name__} is not installed")
    return request.param


def test_the_package_has_types(checker) -> None:
    if checker is mypy:
        pytest.skip("just test-python checks it")
    assert not checker(sorted((SOURCE / "softfish").glob("*.py")))


def test_the_code_of_the_notebooks_has_types(checker, tmp_path: Path) -> None:
    files = []
    for path in NOTEBOOKS:
        cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        code = "\n\n".join("".join(cell["source"]) for cell in cells)
        absent = [package for package in ("torch", "jax") if f"import {package}" in code and importlib.util.find_spec(package) is None]
        if not absent:
            files.append(tmp_path / f"{path.stem}.py")
            files[-1].write_text(code, encoding="utf-8")
    assert len(files) >= 2
    assert not checker(files)


def test_planted_mistakes_are_found_and_nothing_else(checker, tmp_path: Path) -> None:
    lines = MISTAKES.read_text(encoding="utf-8").splitlines()
    copy = tmp_path / "mistakes.py"
    copy.write_text("\n".join(lines), encoding="utf-8")
    planted = {n for n, line in enumerate(lines, 1) if line.endswith("# mistake")}
    errors = checker([copy])
    assert len(planted) >= 20
    assert {line for _, line, _ in errors} == planted, errors

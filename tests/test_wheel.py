"""The wheel carries the layouts: built, unpacked where nothing else of the project is, and asked to list them."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_an_installed_wheel_lists_the_layouts(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path / "dist", ROOT],
        check=True,
        capture_output=True,
    )
    (wheel,) = (tmp_path / "dist").glob("posreal-*.whl")
    # A clean environment with the dependencies of this one in reach, but not its editable posreal.
    venv.create(tmp_path / "clean", with_pip=True)
    python = tmp_path / "clean" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-deps", wheel], check=True, capture_output=True)
    (site,) = (tmp_path / "clean" / "lib").glob("python*/site-packages")
    for dependency in {Path(p) for p in sys.path if p.endswith("site-packages")}:
        for entry in dependency.iterdir():
            if "posreal" not in entry.name and not (site / entry.name).exists() and entry.suffix != ".pth":
                (site / entry.name).symlink_to(entry)
    elsewhere = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    run = subprocess.run(
        [tmp_path / "clean" / "bin" / "posreal", "layouts"],
        check=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=elsewhere,
    )
    assert [line.split()[0] for line in run.stdout.splitlines()[2:]] == [f"S{i}" for i in range(1, 8)]
    where = subprocess.run(
        [python, "-c", "import posreal; print(posreal.__file__)"],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env=elsewhere,
    )
    assert str(site) in where.stdout

"""Commands, each in a process of its own that is forked from one that has imported posreal: some milliseconds each.

A child has its own standard output and error, limits on CPU time and memory, and is ended if it does not end. Requests
and answers are JSON lines on the server's standard input and output.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
CPU, WALL, MEMORY = 60, 300, 6 * 2**30  # seconds, seconds, bytes


@dataclass(frozen=True)
class Answer:
    """What a command did; `code` is None where it had to be ended."""

    code: int | None
    out: str
    err: str
    cpu: float


class Commands:
    """``with Commands() as run: run("check", "s")``"""

    def __init__(self) -> None:
        self._server = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz.runner"],
            cwd=ROOT,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def __enter__(self) -> Commands:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.communicate()

    def __call__(self, *words: str, folder: Path | None = None, cpu: int = CPU, wall: int = WALL) -> Answer:
        request = {"words": words, "folder": str(folder or ROOT), "cpu": cpu, "wall": wall}
        assert self._server.stdin is not None
        assert self._server.stdout is not None
        self._server.stdin.write(json.dumps(request) + "\n")
        self._server.stdin.flush()
        return Answer(**json.loads(self._server.stdout.readline()))


def serve() -> None:
    """Answer requests until standard input ends."""
    answers = os.fdopen(os.dup(1), "w")
    import posreal
    from posreal import cli

    for name in ("quarter-car", "vertical-comfort", "lateral-comfort"):  # imports and tables that all children share
        posreal.evaluate(posreal.problem(name), "c=1.2345e4").to_dict()
    for line in sys.stdin:
        request = json.loads(line)
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = os.fork()
            if child == 0:
                _run(cli.main, request, out.fileno(), err.fileno())
            code, cpu = _wait(child, request["wall"])
            out.seek(0), err.seek(0)
            answer = {
                "code": code,
                "out": out.read(2_000_000).decode(errors="replace"),
                "err": err.read(200_000).decode(errors="replace"),
                "cpu": cpu,
            }
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _wait(child: int, wall: float) -> tuple[int | None, float]:
    """Exit code (None if it had to be ended) and CPU seconds."""
    end, pause = time.monotonic() + wall, 0.002
    while True:
        done, status, usage = os.wait4(child, os.WNOHANG)
        if done:
            code = os.waitstatus_to_exitcode(status)
            return (None if code in (-signal.SIGXCPU, -signal.SIGKILL) else code), usage.ru_utime + usage.ru_stime
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
            _, _, usage = os.wait4(child, 0)
            return None, usage.ru_utime + usage.ru_stime
        time.sleep(pause)
        pause = min(0.05, 1.2 * pause)


def _run(main, request: dict, out: int, err: int) -> None:
    """In the child: as the command would, traceback included. Does not return."""
    code = 1
    try:
        os.setpgid(0, 0)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(out, 1)
        os.dup2(err, 2)
        os.chdir(request["folder"])
        resource.setrlimit(resource.RLIMIT_CPU, (request["cpu"], request["cpu"]))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (2**30, 2**30))
        warnings.resetwarnings()
        sys.argv = ["posreal", *request["words"]]
        try:
            main()
            code = 0
        except SystemExit as leave:
            code = leave.code if isinstance(leave.code, int) else 0 if leave.code is None else 1
        except BaseException:
            traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


if __name__ == "__main__":
    serve()

"""Samples a second beside explauto 1.4.0, in turns on the same machine.

./bha shell python -m benchmarks.speed.explauto_speed

Both learn on a planar arm with 20 joints, each time from nothing. explauto uses its
fastest learner, nearest neighbours, and needs an environment of its own, which is made once in a
cache folder where there is a Python 3.8.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.speed.learners import compiled_babbler

REQUIREMENTS = [
    "setuptools<58",  # the last that can install explauto
    "wheel",
    "numpy<1.20",
    "scipy<1.6",
    "scikit-learn<0.24",
    "matplotlib<3.6",
]
EXPLAUTO = "explauto==1.4.0"
WORKER = Path(__file__).with_name("explauto_worker.py")


def main() -> int:
    """Measure, and return 1 where explauto cannot be had or the bound does not hold."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--bound", type=float, default=80.0, help="times explauto, at least")
    arguments = parser.parse_args()
    python = find_python()
    if python is None:
        print("no Python 3.8 found (looked at PATH, uv and pyenv): explauto cannot be measured")
        return 1
    environment = make_environment(python)
    ours, theirs = measure(environment, arguments.samples, arguments.rounds)
    ratios = theirs / ours
    print("round  ours [samples/s]  explauto [samples/s]  ratio")
    for index, (our, their) in enumerate(zip(ours, theirs, strict=True)):
        rates = arguments.samples / our, arguments.samples / their
        print(f"{index:5d}  {rates[0]:16,.0f}  {rates[1]:20,.0f}  {their / our:5.1f}")
    ratio = float(np.median(ratios))
    print(f"median ratio {ratio:.1f} (bound: >= {arguments.bound:g})")
    return 0 if ratio >= arguments.bound else 1


def find_python() -> str | None:
    """Return a Python 3.8, or None."""
    candidates = [shutil.which("python3.8")]
    if uv := shutil.which("uv"):
        found = subprocess.run([uv, "python", "find", "3.8"], capture_output=True, text=True)
        candidates.append(found.stdout.strip() or None)
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    candidates += [str(path) for path in pyenv.glob("versions/3.8*/bin/python")]
    for candidate in filter(None, candidates):
        # A shim of pyenv is on the path even where its version is not switched on.
        asked = [candidate, "-c", "import sys; print(sys.version_info[:2])"]
        answer = subprocess.run(asked, capture_output=True, text=True)
        if answer.stdout.strip() == "(3, 8)":
            return candidate
    return None


def make_environment(python: str) -> Path:
    """Return the Python of explauto's environment, made if it is not there yet."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    folder = cache / "bha-explauto-1.4.0"
    interpreter = folder / "bin" / "python"
    if not (folder / "complete").exists():
        print(f"making explauto's environment in {folder}", file=sys.stderr)
        shutil.rmtree(folder, ignore_errors=True)
        install = [interpreter, "-m", "pip", "install", "--quiet"]
        for command in (
            [python, "-m", "venv", folder],
            [*install, *REQUIREMENTS],
            [*install, "--no-build-isolation", EXPLAUTO],
        ):
            subprocess.run(command, check=True, env=environment_variables(), stdout=sys.stderr)
        (folder / "complete").touch()
    return interpreter


def environment_variables() -> dict[str, str]:
    """Return the environment without the paths of our own packages."""
    return {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}


def measure(interpreter: Path, samples: int, rounds: int) -> tuple[np.ndarray, np.ndarray]:
    """Return processor times [s] of ours and of explauto, shapes (rounds,), measured in turns."""
    compiled_babbler(0).run(100)
    ours, theirs = np.empty(rounds), np.empty(rounds)
    with subprocess.Popen(
        [interpreter, "-W", "ignore", WORKER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=environment_variables(),
    ) as worker:
        assert worker.stdin is not None
        assert worker.stdout is not None
        while worker.stdout.readline() not in ("ready\n", ""):
            pass
        for index in range(rounds):
            babbler = compiled_babbler(index)
            began = time.process_time()
            babbler.run(samples)
            ours[index] = time.process_time() - began
            print(f"{index} {samples}", file=worker.stdin, flush=True)
            theirs[index] = float(worker.stdout.readline())
        worker.stdin.close()
    return ours, theirs


if __name__ == "__main__":
    sys.exit(main())

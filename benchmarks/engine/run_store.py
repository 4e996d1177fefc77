"""The runs that have been made, kept on disk as they end, so that a table resumes where it stopped.

One line of JSON a run. A line that was cut off with the process that wrote it counts as not there.
"""

import json
from dataclasses import dataclass
from pathlib import Path

from benchmarks.engine.experiment import Run, Settings
from benchmarks.engine.plain_json import round_trip, to_line


@dataclass(frozen=True)
class StoredRun:
    """A run, and how long it took [s]."""

    run: Run
    seconds: float


class RunStore:
    """Runs of one table in one file.

    Parameters
    ----------
    path : Path
        The file; it and its folder are made when the first run is added.
    fingerprint : str
        What the runs were made with (see `benchmarks.engine.provenance`). Others are passed over.
    """

    def __init__(self, path: Path, fingerprint: str) -> None:
        self._path = path
        self._fingerprint = fingerprint
        self._runs = dict(self._read())

    def get(self, seed: int, settings: Settings) -> StoredRun | None:
        """Return the run with this seed and these settings, None if it is not there."""
        return self._runs.get(_key(seed, settings))

    def add(self, stored: StoredRun) -> None:
        """Keep a run, on disk too, before anything else happens."""
        run = stored.run
        line = to_line(
            {
                "fingerprint": self._fingerprint,
                "seed": run.seed,
                "settings": run.settings,
                "figures": run.figures,
                "seconds": stored.seconds,
            }
        )
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as stream:
            # The line break comes first: after a line that was cut off it spoils no other.
            stream.write(f"\n{line}")
        self._runs[_key(run.seed, run.settings)] = _plain(stored)

    def _read(self) -> list[tuple[str, StoredRun]]:
        if not self._path.exists():
            return []
        found = []
        for line in self._path.read_text(encoding="utf-8").splitlines():
            try:
                entry = json.loads(line)
            except json.JSONDecodeError:
                continue
            if entry["fingerprint"] == self._fingerprint:
                run = Run(entry["seed"], entry["settings"], entry["figures"])
                found.append((_key(run.seed, run.settings), StoredRun(run, entry["seconds"])))
        return found


def _key(seed: int, settings: Settings) -> str:
    return to_line([seed, sorted(settings.items())])


def _plain(stored: StoredRun) -> StoredRun:
    """Return a run as it will be read back, so that a table is the same whether it resumed."""
    run = stored.run
    settings, figures = round_trip(run.settings), round_trip(run.figures)
    return StoredRun(Run(run.seed, settings, figures), stored.seconds)

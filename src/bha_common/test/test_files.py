"""Model files: whole or not there, and refused where they do not belong."""

import hashlib
import io
import os
import stat
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bha_common import files
from bha_common.files import ModelFileError, atomic_write, load_versioned, save_versioned

ARRAYS = {"slope": np.arange(12.0).reshape(3, 4) / 7.0, "counts": np.array([1, 2, 3])}
SETTINGS = {"error": 1 / 3, "name": "a", "nested": {"switch": True, "none": None}}


def save(path: Path, **changes: Any) -> None:
    """Write a model file that `load` reads."""
    values = {"kind": "thing", "version": 2, "robot": "bha", "arrays": ARRAYS, "settings": SETTINGS}
    save_versioned(path, **{**values, **changes})


def signed(archive: bytes) -> bytes:
    """Return an archive of zip with the checksum of a model file at its end."""
    body = archive[:-2] + (64).to_bytes(2, "little")
    return body + hashlib.sha256(body).hexdigest().encode()


def load(path: Path, **changes: Any) -> files.VersionedFile:
    return load_versioned(path, **{"kind": "thing", "version": 2, "robot": "bha", **changes})


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """Path of a whole model file."""
    path = tmp_path / "model.npz"
    save(path)
    return path


@pytest.fixture
def umask() -> Iterator[None]:
    """Put the umask back that a test changes."""
    before = os.umask(0o022)
    yield
    os.umask(before)


class TestAtomicWrite:
    """The old content or the new, never a part."""

    def test_writes_and_replaces(self, tmp_path: Path) -> None:
        path = tmp_path / "file"
        for data in (b"first, and longer", b"second", b""):
            atomic_write(path, data)
            assert path.read_bytes() == data
        assert [entry.name for entry in tmp_path.iterdir()] == ["file"]

    def test_makes_missing_folders(self, tmp_path: Path) -> None:
        atomic_write(tmp_path / "a" / "b" / "file", b"x")
        assert (tmp_path / "a" / "b" / "file").read_bytes() == b"x"

    def test_takes_text_paths_and_home(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("HOME", str(tmp_path))
        atomic_write("~/file", b"x")
        assert (tmp_path / "file").read_bytes() == b"x"

    @pytest.mark.parametrize(("owner", "step"), [(os, "fsync"), (Path, "chmod"), (Path, "replace")])
    def test_a_failure_leaves_the_old_file_and_no_other(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, step: str
    ) -> None:
        path = tmp_path / "file"
        atomic_write(path, b"old")

        def fail(*_: Any) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(owner, step, fail)
        with pytest.raises(OSError, match="No space left"):
            atomic_write(path, b"new")
        assert path.read_bytes() == b"old"
        assert [entry.name for entry in tmp_path.iterdir()] == ["file"]

    def test_an_interrupt_leaves_the_old_file_and_no_other(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Ctrl-C is no OSError, and must not leave a temporary file either."""
        path = tmp_path / "file"
        atomic_write(path, b"old")

        def interrupt(*_: Any) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr(os, "fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            atomic_write(path, b"new")
        assert path.read_bytes() == b"old"
        assert [entry.name for entry in tmp_path.iterdir()] == ["file"]

    def test_a_process_that_dies_while_writing_leaves_the_old_file(self, tmp_path: Path) -> None:
        path = tmp_path / "file"
        atomic_write(path, b"old")
        program = f"""
            import os
            from bha_common import files
            os.fsync = lambda _: os._exit(9)
            files.atomic_write({str(path)!r}, b"new" * 100_000)
        """
        folder = str(Path(files.__file__).parents[1])
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(program)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join([folder, *sys.path])},
            check=False,
        )
        assert done.returncode == 9
        assert path.read_bytes() == b"old"

    def test_content_is_on_the_disk_before_it_has_the_name(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Renamed before it is synced, a power failure could leave an empty file."""
        order: list[str] = []
        for owner, step in ((os, "fsync"), (Path, "replace")):
            real = getattr(owner, step)

            def note(*arguments: Any, real: Any = real, step: str = step) -> Any:
                order.append(step)
                return real(*arguments)

            monkeypatch.setattr(owner, step, note)
        atomic_write(tmp_path / "file", b"x")
        assert order == ["fsync", "replace"]

    @pytest.mark.parametrize(("mask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
    @pytest.mark.usefixtures("umask")
    def test_mode_is_that_of_any_new_file(self, tmp_path: Path, mask: int, mode: int) -> None:
        """Others in the lab can read the models, unless the user's umask says no."""
        os.umask(mask)
        atomic_write(tmp_path / "file", b"x")
        assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == mode
        if mode != mask:  # the umask itself is as it was
            assert os.umask(mask) == mask

    def test_a_folder_is_not_replaced(self, tmp_path: Path) -> None:
        (tmp_path / "file").mkdir()
        with pytest.raises(OSError, match="file"):
            atomic_write(tmp_path / "file", b"x")
        assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


class TestRoundTrip:
    """What is saved comes back to the last bit."""

    def test_numpy_alone_can_read_the_arrays(self, model: Path) -> None:
        with np.load(model) as stored:
            np.testing.assert_array_equal(stored["slope"], ARRAYS["slope"])

    def test_everything_comes_back(self, model: Path) -> None:
        stored = load(model)
        assert stored.settings == SETTINGS
        assert stored.robot == "bha"
        assert set(stored.arrays) == set(ARRAYS)
        for name, array in ARRAYS.items():
            assert stored.arrays[name].dtype == array.dtype
            np.testing.assert_array_equal(stored.arrays[name], array)

    @settings(max_examples=25, deadline=None)
    @given(
        array=hnp.arrays(
            dtype=st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_]),
            shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
        ),
        number=st.floats(allow_nan=False, allow_infinity=False),
        text=st.text(max_size=20),
    )
    def test_any_array_any_number_any_text(
        self, tmp_path_factory: pytest.TempPathFactory, array: Any, number: float, text: str
    ) -> None:
        path = tmp_path_factory.getbasetemp() / "any.npz"
        save(path, arrays={"a": array}, settings={"n": number, "t": text}, robot=text)
        stored = load(path, robot=text)
        assert stored.arrays["a"].dtype == array.dtype
        assert stored.arrays["a"].shape == array.shape
        assert stored.arrays["a"].tobytes() == array.tobytes()  # NaN and -0.0 too
        assert stored.settings == {"n": number, "t": text}

    def test_views_are_saved_as_they_look(self, tmp_path: Path) -> None:
        array = np.arange(24.0).reshape(4, 6).T[::2, ::-1]
        save(tmp_path / "a", arrays={"view": array})
        np.testing.assert_array_equal(load(tmp_path / "a").arrays["view"], array)

    def test_any_robot(self, model: Path) -> None:
        assert load(model, robot=None).robot == "bha"

    def test_the_path_is_taken_as_it_is(self, tmp_path: Path) -> None:
        """numpy would add .npz, and the file would not be found again."""
        save(tmp_path / "model.backup")
        assert load(tmp_path / "model.backup").settings == SETTINGS

    def test_the_reserved_name(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match="'header'"):
            save(tmp_path / "a", arrays={"header": np.zeros(3)})
        assert not (tmp_path / "a").exists()

    def test_settings_that_json_cannot_hold_leave_the_old_file(self, model: Path) -> None:
        with pytest.raises(TypeError):
            save(model, settings={"array": np.zeros(3)})
        assert load(model).settings == SETTINGS

    def test_objects_are_not_pickled(self, model: Path) -> None:
        with pytest.raises(ValueError, match="object hold objects"):
            save(model, arrays={"object": np.array([{}, None])})
        assert load(model).settings == SETTINGS


class TestRefusals:
    """Every file that cannot be used gives a ModelFileError that says why."""

    @pytest.mark.parametrize(
        ("changes", "message"),
        [
            ({"kind": "other"}, "kind is 'other', but 'thing' is needed"),
            ({"version": 1}, "version is 1, but 2 is needed"),
            ({"version": 3}, "version is 3, but 2 is needed"),
            ({"robot": "bha_2"}, "belongs to robot 'bha_2', but this robot is 'bha'"),
        ],
    )
    def test_files_of_others(self, tmp_path: Path, changes: dict[str, Any], message: str) -> None:
        save(tmp_path / "a", **changes)
        with pytest.raises(ModelFileError, match=message):
            load(tmp_path / "a")

    def test_no_file(self, tmp_path: Path) -> None:
        with pytest.raises(ModelFileError, match=r"nowhere\.npz: there is no such file"):
            load(tmp_path / "nowhere.npz")

    def test_a_folder(self, tmp_path: Path) -> None:
        with pytest.raises(ModelFileError, match="this is a folder"):
            load(tmp_path)

    @pytest.mark.parametrize(
        ("error", "message"),
        [
            (PermissionError(13, "Permission denied"), "this file may not be read"),
            (OSError(5, "Input/output error"), "cannot be read .Input/output error"),
        ],
    )
    def test_a_file_that_may_not_be_read(
        self, model: Path, monkeypatch: pytest.MonkeyPatch, error: OSError, message: str
    ) -> None:
        """Root may read any file, so the refusal of the system is played."""

        def refuse(*_: Any) -> None:
            raise error

        monkeypatch.setattr(Path, "read_bytes", refuse)
        with pytest.raises(ModelFileError, match=message):
            load(model)

    @pytest.mark.parametrize("data", [b"", b"PK", b"hello\n" * 50, b"\x80\x04]\x94."])
    def test_other_content(self, tmp_path: Path, data: bytes) -> None:
        """Also pickles, which numpy would run if it were let."""
        (tmp_path / "a").write_bytes(data)
        with pytest.raises(ModelFileError, match="not a whole model file"):
            load(tmp_path / "a")

    def test_a_plain_array(self, tmp_path: Path) -> None:
        np.save(tmp_path / "a.npy", np.zeros(9))
        with pytest.raises(ModelFileError, match="not a whole model file"):
            load(tmp_path / "a.npy")

    @pytest.mark.parametrize(
        "header",
        ["", "3", "[]", "{}", '{"kind": "thing", "version": 2, "robot": "bha", "settings": 3}'],
    )
    def test_a_header_that_is_none_although_the_checksum_fits(
        self, tmp_path: Path, header: str
    ) -> None:
        stream = io.BytesIO()
        np.savez(stream, header=np.array(header), slope=ARRAYS["slope"])
        (tmp_path / "a.npz").write_bytes(signed(stream.getvalue()))
        with pytest.raises(ModelFileError, match="not a whole model file"):
            load(tmp_path / "a.npz")

    def test_no_header_although_the_checksum_fits(self, tmp_path: Path) -> None:
        stream = io.BytesIO()
        np.savez(stream, slope=ARRAYS["slope"])
        (tmp_path / "a.npz").write_bytes(signed(stream.getvalue()))
        with pytest.raises(ModelFileError, match="not a whole model file"):
            load(tmp_path / "a.npz")

    def test_cut_anywhere(self, model: Path, tmp_path: Path) -> None:
        data = model.read_bytes()
        cut = tmp_path / "cut.npz"
        for size in range(0, len(data), 7):
            cut.write_bytes(data[:size])
            with pytest.raises(ModelFileError):
                load(cut)

    def test_something_added(self, model: Path) -> None:
        model.write_bytes(model.read_bytes() + b"\n")
        with pytest.raises(ModelFileError):
            load(model)

    def test_one_byte_altered_anywhere(self, model: Path, tmp_path: Path) -> None:
        """Also where it would change no number: times and modes of the archive's entries."""
        data = model.read_bytes()
        altered = tmp_path / "altered.npz"
        for position in range(len(data)):
            flipped = data[position] ^ (1 if position % 2 else 0xFF)
            altered.write_bytes(data[:position] + bytes([flipped]) + data[position + 1 :])
            with pytest.raises(ModelFileError):
                load(altered)

    def test_a_number_altered_with_a_tool(self, model: Path) -> None:
        """Whoever writes the archive anew writes its own checksums anew as well."""
        with np.load(model) as stored:
            arrays = {name: stored[name] for name in stored.files}
        arrays["slope"][1, 2] += 1e-12
        np.savez(model, **arrays)
        with pytest.raises(ModelFileError, match="altered"):
            load(model)

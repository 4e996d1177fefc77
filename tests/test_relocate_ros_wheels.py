"""The CMake files of the ROS wheels are made to fit."""

import os
from pathlib import Path

from tools.relocate_ros_wheels import relocate

FOREIGN = (
    'set(dirs "/opt/python/cp312-cp312/include/python3.12;'
    '/opt/python/cp312-cp312/lib/python3.12/site-packages/numpy/_core/include")\n'
)


def test_only_foreign_folders_are_rewritten(tmp_path: Path) -> None:
    cmake = tmp_path / "share" / "some_msgs" / "cmake"
    cmake.mkdir(parents=True)
    (cmake / "export.cmake").write_text(FOREIGN)
    (cmake / "other.cmake").write_text('set(dirs "/usr/include")\n')

    assert relocate(tmp_path, "/here/include", "/here/site-packages") == 1

    assert (cmake / "export.cmake").read_text() == (
        'set(dirs "/here/include;/here/site-packages/numpy/_core/include")\n'
    )
    assert (cmake / "other.cmake").read_text() == 'set(dirs "/usr/include")\n'
    assert sorted(path.name for path in cmake.iterdir()) == ["export.cmake", "other.cmake"]
    assert relocate(tmp_path, "/here/include", "/here/site-packages") == 0


def test_the_installers_cache_stays_as_it_is(tmp_path: Path) -> None:
    cached = tmp_path / "cached.cmake"
    cached.write_text(FOREIGN)
    installed = tmp_path / "venv" / "share" / "export.cmake"
    installed.parent.mkdir(parents=True)
    os.link(cached, installed)

    relocate(tmp_path / "venv", "/here/include", "/here/site-packages")

    assert cached.read_text() == FOREIGN
    assert "/here/include" in installed.read_text()

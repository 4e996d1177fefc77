"""./bha: what it says, what it refuses, and what it leaves in the environment."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOOLS = (
    "bash cat cp cut dirname env find flock grep ln mkdir nproc printf readlink rm sed sha256sum "
    "sort tail touch uname xargs"
)


def bha(*arguments: str, root: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    # As a user calls it, so without what ./bha test has put into this process's environment.
    clean = {key: os.environ[key] for key in ("HOME", "PATH") if key in os.environ}
    return subprocess.run(
        [str(root / "bha"), *arguments],
        env=clean | environment,
        capture_output=True,
        text=True,
        timeout=280,
    )


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a checkout that was never set up, with what ./bha itself consists of."""
    root = tmp_path / "checkout"
    root.mkdir()
    shutil.copy(ROOT / "bha", root)
    shutil.copytree(ROOT / "tools", root / "tools")
    shutil.copytree(ROOT / "requirements", root / "requirements")
    return root


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    """Return a folder with the programs of a system that has neither Python nor apt."""
    folder = tmp_path / "programs"
    folder.mkdir()
    for name in TOOLS.split():
        path = shutil.which(name)
        if path:
            (folder / name).symlink_to(path)
    return folder


def python(programs: Path, script: str) -> None:
    """Put a python3 there that does what a shell script says; $2 is the code it is given."""
    (programs / "python3").write_text(f"#!/bin/bash\n{script}\n")
    (programs / "python3").chmod(0o755)


def test_help_needs_no_set_up(checkout: Path) -> None:
    for said in (bha("--help", root=checkout), bha(root=checkout)):
        assert said.returncode == 0
        for verb in ("demo", "test", "check", "paper", "run", "shell", "setup", "reach"):
            assert f"\n  {verb}" in said.stdout or f" {verb}," in said.stdout
    assert not (checkout / ".venv").exists()


def test_a_python_that_is_too_old_is_refused(checkout: Path, programs: Path) -> None:
    python(programs, '[ "$1" = --version ] && echo "Python 3.9.2" || exit 1')
    said = bha("setup", root=checkout, PATH=str(programs))
    assert said.returncode == 1
    assert "3.11 to 3.13" in said.stderr
    assert "Python 3.9.2" in said.stderr
    assert not (checkout / ".venv").exists()


def test_a_missing_python_is_named(checkout: Path, programs: Path) -> None:
    said = bha("demo", root=checkout, PATH=str(programs))
    assert said.returncode == 1
    assert "not installed" in said.stderr


def test_without_rights_it_prints_the_line_to_run(checkout: Path, programs: Path) -> None:
    # A Debian python3 as it comes: no venv, no headers. There is no compiler either.
    python(programs, 'case "$2" in *version_info*) echo 3.11 ;; *) exit 1 ;; esac')
    said = bha("setup", root=checkout, PATH=str(programs))
    assert said.returncode == 1
    line = "sudo apt-get update && sudo apt-get install -y python3.11-venv python3.11-dev g++"
    assert line in said.stderr
    assert not (checkout / ".venv").exists()


def test_a_path_that_ros_cannot_take_is_refused(checkout: Path) -> None:
    spaced = checkout.rename(checkout.with_name("my checkout"))
    said = bha("setup", root=spaced)
    assert said.returncode == 1
    assert "space" in said.stderr


def test_a_build_leaves_the_caller_in_its_folder(checkout: Path, tmp_path: Path) -> None:
    """A relative path, such as that of results, is meant from where ./bha was called."""
    package, venv = checkout / "ros2_ws" / "src" / "some", checkout / ".venv" / "bin"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package/>")
    (checkout / "ros2_ws" / "colcon_defaults.yaml").touch()
    venv.mkdir(parents=True)
    (venv / "colcon").write_text("#!/bin/sh\nmkdir -p install/some && echo built in $(pwd) >&2\n")
    (venv / "colcon").chmod(0o755)
    script = f"""
        set -euo pipefail
        ROOT={checkout} VENV=$ROOT/.venv WORKSPACE=$ROOT/ros2_ws LOG={tmp_path}/log
        ENVIRONMENT=$WORKSPACE/install/environment.sh
        say() {{ echo "$@" >&2; }}
        die() {{ say "$@"; exit 1; }}
        source "$ROOT/tools/setup.bash"
        provide_system() {{ :; }}
        venv_ready() {{ :; }}
        record_environment() {{ touch "$ENVIRONMENT"; }}
        setup && pwd
    """
    said = subprocess.run(
        ["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert said.returncode == 0, said.stderr
    assert f"built in {checkout}/ros2_ws" in (tmp_path / "log").read_text()
    assert said.stdout.strip() == str(tmp_path)


def test_the_second_call_is_at_work_at_once() -> None:
    first = bha("setup")
    assert first.returncode == 0, first.stderr
    start = time.monotonic()
    second = bha("shell", "true")
    assert second.returncode == 0, second.stderr
    assert time.monotonic() - start < 3.0
    assert "colcon" not in second.stderr


def test_the_environment_keeps_to_this_machine_unless_told() -> None:
    said = bha("shell", "env").stdout
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST\n" in said
    assert f"VIRTUAL_ENV={ROOT}/.venv\n" in said
    chosen = bha("shell", "env", ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET").stdout
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET\n" in chosen


def test_a_native_ros_in_the_terminal_stays_outside() -> None:
    said = bha(
        "shell",
        "env",
        PYTHONPATH="/opt/ros/other/python",
        AMENT_PREFIX_PATH="/opt/ros/other",
        LD_LIBRARY_PATH="/opt/ros/other/lib",
        RMW_IMPLEMENTATION="rmw_other",
    ).stdout
    variables = dict(line.split("=", 1) for line in said.splitlines() if "=" in line)
    assert "/opt/ros" not in variables["PYTHONPATH"]
    assert "/opt/ros" not in variables["AMENT_PREFIX_PATH"]
    assert variables["RMW_IMPLEMENTATION"] == "rmw_fastrtps_cpp"
    libraries = variables["LD_LIBRARY_PATH"].split(":")
    assert libraries.index(f"{ROOT}/.venv/lib") < libraries.index("/opt/ros/other/lib")
    assert "" not in libraries


def test_run_names_what_there_is() -> None:
    said = bha("run", "bha_sim", "nonsense")
    assert said.returncode == 1
    for executable in (
        "bha_sim simulator",
        "bha_pressure_ctrl pressure_ctrl",
        "bha_goal_babbling learner",
        "bha_cartesian_feedback cartesian_feedback",
    ):
        assert executable in said.stderr
    assert "./bha run bha_sim simulator" in bha("run", "bha_sim").stderr

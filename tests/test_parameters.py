"""What a node does with parameters that it does not have."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix

from running_graph import ros_domain

pytestmark = pytest.mark.graph


@pytest.mark.parametrize(
    ("node", "wrong", "right"),
    [
        ("pressure_ctrl", "safety.max_presure", "safety.max_pressure"),
        ("driver", "max_presure", "max_pressure"),
    ],
)
def test_a_limit_with_a_letter_amiss_is_not_left_out(
    tmp_path: Path, node: str, wrong: str, right: str
) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text(f"/**/{node}: {{ros__parameters: {{{wrong}: 5.0e+4, use_sim_time: false}}}}")
    package = f"bha_{node}"
    executable = Path(get_package_prefix(package), "lib", package, node)
    with ros_domain() as domain:
        ended = subprocess.run(
            [executable, "--ros-args", "-r", "__ns:=/bha", "--params-file", file],
            env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
            capture_output=True,
            text=True,
            timeout=60.0,
            check=False,
        )
    assert ended.returncode == 2, ended.stderr
    assert f"error: {node}: there is no parameter {wrong!r} (is {right} " in ended.stderr
    assert "Traceback" not in ended.stderr

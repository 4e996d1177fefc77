"""What a node does with parameters that it does not have."""

from __future__ import annotations

from pathlib import Path

import pytest

from running_graph import refused_node

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
    said = refused_node(f"bha_{node}", node, "-r", "__ns:=/bha", "--params-file", str(file))
    assert f"error: {node}: there is no parameter {wrong!r} (is {right} " in said

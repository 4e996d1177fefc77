"""Nothing is left to compile, or to read from disk, when a robot waits for its first command."""

import subprocess
import sys

import pytest

# In a process of its own: other tests compile, too.
_COUNT = """
import sys
import numpy as np
from numba.core.registry import CPUDispatcher
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.task import find_task
from bha_goal_babbling.warm_up import warm_up

def compiled():
    modules = [module for name, module in sys.modules.items() if name.startswith("bha_")]
    functions = [each for module in modules for each in vars(module).values()]
    return sum(len(each.overloads) for each in functions if isinstance(each, CPUDispatcher))

task = find_task(sys.argv[1])
warm_up(task)
before = compiled()
home = task.goals().mean(axis=0)
rng = np.random.default_rng(0)
babbler = GoalBabbler(
    task.config, task.goals(), task.home_action, home, task.action_low, task.action_high, rng
)
for _ in range(60):
    babbler.tell(babbler.ask(), home + 0.05 * rng.standard_normal(home.size))
babbler.inverse(home)
babbler.practise(task.home_action, home)
GoalBabbler.restore(babbler.state()).ask()
print(before, compiled())
"""


@pytest.mark.parametrize("task", ["2d", "3d"])
def test_exploring_compiles_nothing_more(task: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _COUNT, task], capture_output=True, text=True, check=True
    )
    before, after = map(int, done.stdout.split())
    assert 5 <= before == after

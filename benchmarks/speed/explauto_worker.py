"""Goal babbling by explauto's nearest neighbours, on order; runs in explauto's own Python.

For every line on its input, "SEED SAMPLES", it babbles from nothing on an arm with 20 joints and
answers with the processor time that took [s].
"""

import math
import sys
import time

import numpy as np
from explauto.environment.simple_arm.simple_arm import SimpleArmEnvironment
from explauto.sensorimotor_model import sensorimotor_models

JOINTS = 20
GOALS = np.array([[0.2, -0.5], [0.8, 0.5]])  # [m]


def babble(seed, samples):
    """Return the processor time [s] of so many samples."""
    np.random.seed(seed)  # noqa: NPY002 - what explauto itself draws from
    limits = np.full(JOINTS, math.pi)
    arm = SimpleArmEnvironment(-limits, limits, -np.ones(2), np.ones(2), 1.0, 0.0)
    make, configurations = sensorimotor_models["nearest_neighbor"]
    settings = dict(configurations["default"], sigma_explo_ratio=0.05 / (2.0 * math.pi))
    model = make(arm.conf, **settings)
    action = np.zeros(JOINTS)
    model.update(action, arm.update(action, log=False))
    action = np.full(JOINTS, 0.1)
    model.update(action, arm.update(action, log=False))
    began = time.process_time()
    for _ in range(samples):
        goal = GOALS[0] + (GOALS[1] - GOALS[0]) * np.random.rand(2)  # noqa: NPY002
        action = model.infer(arm.conf.s_dims, arm.conf.m_dims, goal)
        model.update(action, arm.update(action, log=False))
    return time.process_time() - began


if __name__ == "__main__":
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for order in sys.stdin:
        seed, samples = order.split()
        sys.stdout.write(f"{babble(int(seed), int(samples))}\n")
        sys.stdout.flush()

"""Babbling begins when it is accepted: a client lets the robot go as soon as it is told so."""

from __future__ import annotations

import time

import rclpy
from bha_interfaces.action import Babble
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor

from bha_goal_babbling.learner import Learner
from bha_goal_babbling.learner_node import LearnerNode
from running_graph import PATIENCE, ros_domain


def test_it_has_begun_when_the_client_hears_of_it() -> None:
    with ros_domain():
        rclpy.init(args=[])
        try:
            learner, client_node = LearnerNode(), rclpy.create_node("client")
            client = ActionClient(client_node, Babble, "learner/babble")
            served = SingleThreadedExecutor()
            served.add_node(learner)
            assert client.wait_for_server(PATIENCE)
            answers = [client.send_goal_async(Babble.Goal(duration=60.0)) for _ in range(2)]
            deadline = time.monotonic() + PATIENCE
            accepted = False
            while not accepted and time.monotonic() < deadline:
                learner._serve(served)
                rclpy.spin_once(client_node, timeout_sec=0.01)
                accepted = any(each.done() and each.result().accepted for each in answers)
            assert accepted
            assert learner._learner.mode == Learner.HOMING
            while not all(each.done() for each in answers) and time.monotonic() < deadline:
                learner._serve(served)
                rclpy.spin_once(client_node, timeout_sec=0.01)
            assert sorted(each.result().accepted for each in answers) == [False, True]
        finally:
            rclpy.shutdown()

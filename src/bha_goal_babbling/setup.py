"""Installs bha_goal_babbling as an ament_python package."""

from setuptools import setup

PACKAGE = "bha_goal_babbling"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=[PACKAGE],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", ["config/task_2d.yaml", "config/task_3d.yaml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="BHA workspace maintainers",
    maintainer_email="maintainers@bha-workspace.example.org",
    description="Online goal babbling for the Bionic Handling Assistant",
    license="Apache-2.0",
    entry_points={"console_scripts": ["learner = bha_goal_babbling.learner_node:main"]},
)

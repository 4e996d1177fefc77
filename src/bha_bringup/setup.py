"""Installation of bha_bringup."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "bha_bringup"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
        (f"share/{PACKAGE}/config", glob("config/*")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="BHA workspace maintainers",
    maintainer_email="maintainers@bha-workspace.example.org",
    description="The graph as a whole: what runs, how to start it, and how to use it.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "bha = bha_bringup.cli:main",
            "terminal_emulator = bha_bringup.terminal_emulator_node:main",
        ]
    },
)

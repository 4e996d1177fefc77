"""Installation of bha_sim."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "bha_sim"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="BHA workspace maintainers",
    maintainer_email="maintainers@bha-workspace.example.org",
    description="The Bionic Handling Assistant in MuJoCo.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["simulator = bha_sim.simulator_node:main"]},
)

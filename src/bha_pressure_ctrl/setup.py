"""Installation of bha_pressure_ctrl."""

from setuptools import find_packages, setup

PACKAGE = "bha_pressure_ctrl"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="BHA workspace maintainers",
    maintainer_email="maintainers@bha-workspace.example.org",
    description="Learned equilibrium-point controller: bellows lengths to pressures.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": ["pressure_ctrl = bha_pressure_ctrl.pressure_ctrl_node:main"],
    },
)

"""Installation of bha_driver."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "bha_driver"

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
    description="Driver of the pneumatic robot: a Festo terminal over Modbus TCP.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["driver = bha_driver.driver_node:main"]},
)

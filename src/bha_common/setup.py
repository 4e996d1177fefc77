"""Installation of bha_common."""

from setuptools import find_packages, setup

PACKAGE = "bha_common"

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
    description="What several nodes of the Bionic Handling Assistant workspace share.",
    license="Apache-2.0",
)

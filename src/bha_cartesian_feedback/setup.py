"""Installation of bha_cartesian_feedback."""

from setuptools import find_packages, setup

PACKAGE = "bha_cartesian_feedback"

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
    description="Optional Cartesian feedback: integrates the error of the tip in goal space.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "cartesian_feedback = bha_cartesian_feedback.cartesian_feedback_node:main"
        ],
    },
)

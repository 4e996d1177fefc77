"""The pinned lists are what they promise to be."""

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "requirements"
GROUPS = ("runtime", "build", "dev")
PIN = re.compile(r"([a-z0-9][a-z0-9.-]*)(\[[a-z,]+\])?==([0-9][0-9A-Za-z.+!]*)")


def lines(path: Path) -> list[str]:
    """Return a file's lines without comments and blanks."""
    bare = [line.split("#")[0].strip() for line in path.read_text().splitlines()]
    return [line for line in bare if line]


def pins(group: str) -> dict[str, str]:
    found = {}
    for line in lines(FOLDER / f"{group}.txt"):
        match = PIN.fullmatch(line)
        assert match, f"{group}.txt: {line!r} is not NAME==VERSION"
        found[match[1]] = match[3]
    return found


@pytest.mark.parametrize("group", GROUPS)
def test_what_is_asked_for_is_pinned(group: str) -> None:
    pinned = pins(group)
    for line in lines(FOLDER / f"{group}.in"):
        name = re.split(r"[\[<>=!~ ]", line)[0]
        assert name.lower() in pinned, f"{name} is in {group}.in and not in {group}.txt"


def test_the_lists_agree() -> None:
    together: dict[str, str] = {}
    for group in GROUPS:
        for name, version in pins(group).items():
            assert together.setdefault(name, version) == version, f"two versions of {name}"


@pytest.mark.parametrize("path", sorted(FOLDER.iterdir()), ids=lambda path: path.name)
def test_no_address_is_in_a_list(path: Path) -> None:
    text = path.read_text()
    assert "://" not in text
    assert not re.search(r"^\s*-", text, re.MULTILINE), "an option, such as an index"

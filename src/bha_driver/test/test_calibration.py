import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_common.bellows import NAMES
from bha_driver.calibration import scale_and_offset, with_calibration
from bha_driver.errors import TerminalMapError
from bha_driver.terminal_file import example_path, parse_terminal

TEXT = example_path("cpx_e").read_text()
BLOCK = """
    length:
      register: 45392   # the first one
      scale: 1.0e-5
"""


@given(
    st.floats(2e-6, 1e-4) | st.floats(-1e-4, -2e-6),
    st.floats(-0.5, 0.5),
    st.floats(0.0, 10_000.0),
    st.floats(30_000.0, 32_000.0),
)
def test_two_points_give_the_line(scale: float, offset: float, low: float, high: float) -> None:
    found = scale_and_offset((low, high), (scale * low + offset, scale * high + offset))
    assert found[0] == pytest.approx(scale, rel=1e-6)
    assert found[1] == pytest.approx(offset, abs=1e-6)


def test_points_that_are_too_near_are_refused() -> None:
    with pytest.raises(ValueError, match="29 mm apart; at least 30 mm"):
        scale_and_offset((0.0, 1000.0), (0.150, 0.179))
    with pytest.raises(ValueError, match="changed by 12 counts only"):
        scale_and_offset((500.0, 512.0), (0.15, 0.25))


@pytest.mark.parametrize("name", NAMES)
def test_only_that_bellows_changes_and_no_comment(name: str) -> None:
    text = with_calibration(TEXT, name, 2.5e-5, -0.0123)
    before, after = parse_terminal(TEXT), parse_terminal(text)
    for other, old, new in zip(NAMES, before.bellows, after.bellows, strict=True):
        assert (old == new) == (other != name)
    channel = after.bellows[NAMES.index(name)].length
    assert (channel.scale, channel.offset) == (2.5e-5, -0.0123)
    changed = [
        line
        for line in zip(TEXT.splitlines(), text.splitlines(), strict=True)
        if line[0] != line[1]
    ]
    assert len(changed) == 1


def test_an_offset_is_added_where_there_was_none() -> None:
    for old, new in ((", offset: 0.0}", "}"), (None, None)):
        text = TEXT.replace(old, new, 1) if old else _in_block_style()
        channel = (
            parse_terminal(with_calibration(text, "bellows_1_1", 2e-5, 0.01)).bellows[0].length
        )
        assert (channel.scale, channel.offset) == (2e-5, 0.01)


def _in_block_style() -> str:
    begin = TEXT.index("\n    length:")
    end = TEXT.index("    pressure:", begin)
    return TEXT[:begin] + BLOCK + TEXT[end:]


def test_a_bellows_that_is_none_is_refused() -> None:
    with pytest.raises(TerminalMapError, match="bellows_9_9 is unknown; valid are bellows_1_1"):
        with_calibration(TEXT, "bellows_9_9", 1e-5, 0.0)

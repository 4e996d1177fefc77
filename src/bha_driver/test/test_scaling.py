"""Raw words to SI and back."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_common import bellows
from bha_driver.channel import Channel
from bha_driver.scaling import Scaling
from bha_driver.terminal_file import example_path, load_terminal

MAPS = [load_terminal(example_path(name)) for name in ("cpx_e", "cpx_mpa", "emulated")]
FORMATS = st.sampled_from(["int16", "uint16"])
SCALES = st.floats(1e-6, 1e3) | st.floats(-1e3, -1e-6)


@given(st.integers(0, 0xFFFF), SCALES, st.floats(-1e3, 1e3), FORMATS)
def test_a_word_comes_back(word: int, scale: float, offset: float, kind: str) -> None:
    channel = Channel(1, scale, offset, kind)
    if abs(offset) < 1e7 * abs(scale):  # else counts drown in rounding
        assert channel.word(channel.value(word)) == word


@given(st.floats(-0.3, 0.6), FORMATS)
def test_a_value_comes_back_to_half_a_count(value: float, kind: str) -> None:
    channel = Channel(1, 2e-5, 0.05, kind)
    low, high = (-0x8000, 0x7FFF) if kind == "int16" else (0, 0xFFFF)
    nearest = min(max(value, channel.scale * low + 0.05), channel.scale * high + 0.05)
    assert channel.value(channel.word(value)) == pytest.approx(nearest, abs=1.001e-5)


def test_known_words() -> None:
    signed, unsigned = Channel(1, 0.5, 10.0, "int16"), Channel(1, 0.5, 10.0, "uint16")
    assert signed.value(0xFFFE) == 9.0
    assert unsigned.value(0xFFFE) == 0.5 * 65534 + 10.0
    assert signed.word(9.0) == 0xFFFE


@pytest.mark.parametrize("kind", ["int16", "uint16"])
def test_the_sign_of_a_block_is_that_of_its_channels(kind: str) -> None:
    base = MAPS[0]
    length = dataclasses.replace(base.bellows[0].length, format=kind, scale=1e-5, offset=0.25)
    first = dataclasses.replace(base.bellows[0], length=length)
    scaling = Scaling(dataclasses.replace(base, bellows=(first, *base.bellows[1:])))
    block = np.full(base.input_block[1], 0x7FFF)
    for word in (0x7FFF, 0x8000, 0xFFFF):
        block[length.register - base.input_block[0]] = word
        raw = word - 0x10000 if kind == "int16" and word > 0x7FFF else word
        assert scaling.raw_lengths(block).tolist() == [raw] + [0x7FFF] * 8
        assert scaling.lengths(block)[0] == pytest.approx(length.value(word))


@pytest.mark.parametrize("terminal", MAPS, ids=lambda item: item.name)
@given(st.lists(st.floats(-1e9, 1e9), min_size=9, max_size=9))
def test_no_set_point_is_negative_or_too_high(terminal, pressures) -> None:
    scaling = Scaling(terminal)
    words = scaling.set_points(np.array(pressures))
    assert words.min() >= 0
    assert words.max() <= 0x7FFF
    back = scaling.commanded(words)
    assert (back >= 0.0).all()
    assert (back <= terminal.limits.pressure * (1 + 1e-9)).all()
    inside = (np.array(pressures) >= 0) & (np.array(pressures) <= terminal.limits.pressure)
    error = np.abs(back - pressures)[inside]
    assert (error <= scaling.count_worth[inside] * 1.001).all()


def test_each_register_is_that_of_its_bellows() -> None:
    """Nothing may depend on registers lying in the order of the bellows."""
    base = MAPS[0]
    order = np.random.default_rng(0).permutation(bellows.COUNT)
    mixed = tuple(
        dataclasses.replace(
            item,
            set_point=dataclasses.replace(item.set_point, register=40001 + int(order[index])),
            length=dataclasses.replace(item.length, register=45392 + 2 * int(order[index])),
            pressure=dataclasses.replace(item.pressure, register=45393 + 2 * int(order[index])),
        )
        for index, item in enumerate(base.bellows)
    )
    terminal = dataclasses.replace(base, bellows=mixed)
    scaling = Scaling(terminal)
    block = np.arange(18) * 100
    for index, item in enumerate(terminal.bellows):
        word = int(block[item.length.register - 45392])
        assert scaling.lengths(block)[index] == pytest.approx(item.length.value(word))
        word = int(block[item.pressure.register - 45392])
        assert scaling.pressures(block)[index] == pytest.approx(item.pressure.value(word))
    pressures = np.linspace(1e4, 9e4, 9)
    words = scaling.set_points(pressures)
    for index, item in enumerate(terminal.bellows):
        word = int(words[item.set_point.register - 40001])
        assert item.set_point.value(word) == pytest.approx(pressures[index], abs=4.0)

import tracemalloc
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.receptor.lines import LONGEST, Line, Reader

ROBOTS = ("amber", "birch", "the big one")


def read(*parts):
    reader = Reader(ROBOTS)
    return [line for part in parts for line in reader.feed(part)], reader


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_lines_are_read_whatever_they_end_in(end):
    lines, reader = read(b"hit amber" + end + b"lost amber" + end)
    assert lines == [Line("amber", True), Line("amber", False)]
    assert reader.counters.lines == 2


def test_words_may_stand_apart_and_names_may_have_several():
    lines, _ = read(b"  HIT   birch \t\nLost the big   one\nhit amber token=a-long-one\n")
    assert lines == [Line("birch", True), Line("the big one", False), Line("amber", True, "a-long-one")]


@given(cuts=st.lists(st.integers(0, 60), max_size=12))
@settings(derandomize=True)
def test_bytes_may_be_split_anywhere(cuts):
    whole = b"hit amber\r\nhit birch\r\nlost amber\nnonsense\nlost birch\r\n"
    edges = [0, *sorted(min(cut, len(whole)) for cut in cuts), len(whole)]
    lines, reader = read(*[whole[a:b] for a, b in pairwise(edges)])
    assert [(line.robot, line.on) for line in lines] == [
        ("amber", True),
        ("birch", True),
        ("amber", False),
        ("birch", False),
    ]
    assert reader.counters.malformed == 1


def test_a_line_without_its_end_is_not_read_yet_but_a_message_is():
    reader = Reader(ROBOTS)
    assert reader.feed(b"hit amber") == []
    assert reader.feed(b"\n") == [Line("amber", True)]
    assert reader.whole(b"lost amber\r\nhit birch") == [Line("amber", False), Line("birch", True)]


def test_what_a_broken_stream_left_behind_is_no_line():
    reader = Reader(ROBOTS)
    reader.feed(b"hit am")
    reader.begin()
    assert reader.feed(b"ber\nhit birch\n") == [Line("birch", True)]
    assert reader.counters.malformed == 1


def test_a_robot_that_does_not_exist_is_counted_and_told_once_with_those_that_do():
    _, reader = read(b"hit ambr\nhit ambr\nhit zoe\n")
    assert reader.counters.unknown == 3
    assert len(reader.told) == 2
    assert "'ambr'" in reader.told[0]
    assert "amber, birch, the big one" in reader.told[0]
    assert "Did you mean 'amber'?" in reader.told[0]


def test_the_sentences_about_strangers_do_not_grow_without_end():
    _, reader = read(*[f"hit r{k}\n".encode() for k in range(200)])
    assert reader.counters.unknown == 200
    assert len(reader.told) == 16


@pytest.mark.parametrize("junk", [b"hit\n", b"amber hit\n", b"\xff\xfe\n", b"hit \x00\n", b"hitamber\n", b"token=x\n"])
def test_junk_is_counted_and_the_next_line_is_read(junk):
    lines, reader = read(junk, b"hit amber\n")
    assert lines == [Line("amber", True)]
    assert reader.counters.malformed + reader.counters.unknown == 1


def test_a_line_that_is_too_long_is_dropped_to_its_end():
    for parts in ([b"x" * 5000, b"hit amber\nhit birch\n"], [b"hit " + b"a" * LONGEST + b"\nhit birch\n"]):
        lines, reader = read(*parts)
        assert lines == [Line("birch", True)]
        assert reader.counters.too_long == 1
    fits = b"hit amber" + b" " * (LONGEST - 9)
    assert read(fits + b"\n")[0] == [Line("amber", True)]


def test_random_bytes_raise_nothing_and_memory_stays_flat():
    rng = np.random.default_rng(5)
    reader = Reader(ROBOTS)
    words = [b"hit ", b"lost ", b"amber", b"token=", b"\n", b"\r", b"\x00", b"\xff"]
    tracemalloc.start()
    for round_ in range(4000):
        piece = rng.bytes(int(rng.integers(1, 80))) if round_ % 2 else b"".join(rng.choice(words, 6).tolist())
        reader.feed(piece)
        if round_ == 1000:
            before, _ = tracemalloc.get_traced_memory()
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 20_000
    assert reader.feed(b"\nhit amber\n") == [Line("amber", True)]

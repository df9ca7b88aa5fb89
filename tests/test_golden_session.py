"""A session of the past is decided as it was then, but for the last digits that processors disagree about."""

import msgspec
import pytest

from armspan.cli.replay import decisions
from armspan.config.recalled import settings_of
from armspan.log import read
from armspan.records import EVENTS, Calibrated, GoTo, Pointed, Selected
from golden_session import PATH


@pytest.fixture(scope="module")
def golden():
    return read(PATH)


def numbers(value):
    """A record's numbers, in order, and the rest of it."""
    if isinstance(value, dict):
        parts = [numbers(item) for item in value.values()]
        return [n for part, _ in parts for n in part], tuple(zip(value, (rest for _, rest in parts), strict=True))
    if isinstance(value, list | tuple):
        parts = [numbers(item) for item in value]
        return [n for part, _ in parts for n in part], tuple(rest for _, rest in parts)
    return ([value], float) if isinstance(value, float) else ([], value)


def test_it_is_small_and_whole(golden):
    assert PATH.stat().st_size < 300_000
    assert golden.complete
    assert {GoTo, Calibrated, Pointed, Selected} <= {type(record) for record in golden.records}


def test_it_is_decided_as_it_was(golden):
    old = [record for record in golden.records if not isinstance(record, EVENTS)]
    new = list(decisions(golden, settings_of(golden)))
    assert [type(record) for record in new] == [type(record) for record in old]
    for was, now in zip(old, new, strict=True):
        (values, rest), (expected, told) = numbers(msgspec.to_builtins(now)), numbers(msgspec.to_builtins(was))
        assert rest == told
        assert values == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_numbers_are_told_from_the_rest():
    assert numbers({"t": 0.5, "xy": (1.0, 2.0), "robot": "a"}) == (
        [0.5, 1.0, 2.0],
        (("t", float), ("xy", (float, float)), ("robot", "a")),
    )

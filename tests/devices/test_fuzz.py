"""No bytes make a decoder raise anything but DeviceError; benchmarks/fuzz.py does the same, fifty times as often."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from armspan.errors import DeviceError

FILE = Path(__file__).parents[2] / "benchmarks" / "fuzz.py"
STRINGS = 20_000


def loaded():
    spec = importlib.util.spec_from_file_location("fuzz_benchmark", FILE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


fuzz = loaded()
NAMES = [target.name for target in fuzz.targets()]


@pytest.mark.parametrize("name", NAMES)
def test_a_decoder_raises_nothing_but_device_errors_and_recovers(name):
    target = next(target for target in fuzz.targets() if target.name == name)
    outcome = fuzz.fuzz(target, STRINGS, seed=7)
    assert outcome.failures == 0, outcome.first_failure
    assert outcome.strings == STRINGS
    assert outcome.checks == STRINGS // fuzz.CHECK_EVERY
    assert outcome.understood > STRINGS // 100
    assert outcome.refused + outcome.understood == STRINGS
    assert outcome.left_bytes < 20_000


def test_a_decoder_that_keeps_everything_is_noticed():
    kept = []
    outcome = fuzz.fuzz(fuzz.Target("hoarder", kept.append, (b"12345678",), lambda: True), 10_000, seed=7)
    assert outcome.left_bytes > 30_000


def test_a_decoder_that_fails_is_noticed():
    def feed(data):
        if len(data) > 4:
            raise IndexError("not caught")
        raise DeviceError("no")

    outcome = fuzz.fuzz(fuzz.Target("broken", feed, (b"12345678",), lambda: False), 2_000, seed=7)
    assert outcome.failures > 100
    assert "IndexError: not caught" in outcome.first_failure
    assert outcome.refused > 100


def test_the_same_seed_makes_the_same_strings():
    seeds = (b"\x01P", b"\x01A\x02")
    first, again = (list(fuzz.strings(seeds, np.random.default_rng(3), 50)) for _ in range(2))
    assert first == again
    assert len(set(first)) > 20

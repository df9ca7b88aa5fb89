"""Whatever comes in: a DeviceError or nothing, nothing that is not finite comes out, and the next good one is heard."""

import json
from contextlib import suppress

import numpy as np
import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import Browser
from armspan.devices.phone.sensor_logger import SensorLogger
from armspan.devices.phone.sensor_server import FORCE, GAME, RATE, SensorServer
from armspan.devices.phone.voices import LoggerVoice, PageVoice, ServerVoice, lying_still
from armspan.errors import DeviceError
from armspan.records import ImuSample, is_finite
from devices.promises import check_events

ROUNDS = 3000
ODD = [b"null", b"NaN", b"Infinity", b"-1", b"1e999", b"1e308", b'""', b"[]", b"{}", b"true", b"18446744073709551616"]


def good(voice, seconds):
    samples = lying_still(60.0)
    messages = [*voice.begin()]
    for k in range(int(seconds * 200)):
        messages += voice.tell(samples(k / 200), k / 200)
    return messages


def mutated(data, rng):
    """One of: other bytes, a piece left out, a piece twice, a value that is odd, noise."""
    data = bytearray(data)
    at, upto = sorted(int(k) for k in rng.integers(0, len(data) + 1, 2))
    match int(rng.integers(5)):
        case 0:
            for k in rng.integers(0, len(data), int(rng.integers(1, 5))):
                data[k] = int(rng.integers(256))
            return bytes(data)
        case 1:
            return bytes(data[:at] + data[upto:])
        case 2:
            return bytes(data[:upto] + data[at:])
        case 3:
            values = [k for k in range(len(data)) if data[k : k + 1] in b":,["]
            k = values[int(rng.integers(len(values)))] + 1
            end = next((j for j in range(k, len(data)) if data[j : j + 1] in b",]}"), len(data))
            return bytes(data[:k]) + ODD[int(rng.integers(len(ODD)))] + bytes(data[end:])
    return rng.bytes(int(rng.integers(0, 64)))


CASES = {
    "browser": (PageVoice, Browser),
    "android": (lambda: LoggerVoice("android", 0.05), SensorLogger),
    "watch": (lambda: LoggerVoice("apple-watch", 0.05), lambda band: SensorLogger(band, watch=True)),
    "server": (lambda: ServerVoice((FORCE, RATE, GAME)), SensorServer),
}


@pytest.mark.parametrize("name", CASES)
def test_nothing_that_comes_in_does_harm(name):
    voice, decoder = CASES[name]
    rng, device = np.random.default_rng(7), decoder(Band("wrist"))
    messages, events, sentences = good(voice(), 2.0), [], []
    for k in range(ROUNDS):
        data = mutated(messages[int(rng.integers(len(messages)))], rng)
        try:
            events += device.feed(data, k * 0.01)
        except DeviceError as error:
            sentences.append(str(error))
        events += device.watch(k * 0.01) if k % 10 == 0 else []
    assert len(sentences) > ROUNDS / 5
    assert all("\n" not in text and len(text) < 400 for text in sentences)
    assert device.band.counters.malformed == len(sentences)
    assert all(is_finite(event) for event in events)
    check_events(events)


@pytest.mark.parametrize("name", CASES)
def test_after_noise_a_new_beginning_is_heard(name):
    voice, decoder = CASES[name]
    rng, device = np.random.default_rng(8), decoder(Band("wrist"))
    messages = good(voice(), 1.0)
    for k in range(300):
        with suppress(DeviceError):
            device.feed(mutated(messages[k % len(messages)], rng), k * 0.01)
    fresh = voice()
    if name in ("android", "watch"):
        fresh.session, fresh.epoch_ns = "later", fresh.epoch_ns + 10**12
    elif name == "browser":
        fresh.page = "later"
    else:
        fresh.boot_ns += 10**12
    events = []
    for k, data in enumerate(good(fresh, 2.0)):
        events += device.feed(data, 1000.0 + k * 0.01)
    assert len([event for event in events if isinstance(event, ImuSample)]) > 60


def test_an_enormous_message_is_refused_quickly():
    with pytest.raises(DeviceError):
        Browser(Band("wrist")).feed(json.dumps({"n": 0, "a": [0] * 100_000}).encode(), 0.0)

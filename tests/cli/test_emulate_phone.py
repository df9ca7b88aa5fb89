"""``armspan emulate phone``: its options, and its bytes at a real door."""

import argparse
import asyncio
import contextlib
import sys

import pytest

from armspan.cli import emulate_phone
from armspan.devices.phone.driver import PhoneBands
from armspan.devices.phone.entry import PhoneEntry
from armspan.errors import ConfigError
from armspan.records import ImuSample

PROGRAM = """
import argparse, sys
from armspan.cli import emulate_phone
parser = argparse.ArgumentParser()
emulate_phone.add_parser(parser.add_subparsers(required=True))
args = parser.parse_args(sys.argv[1:])
sys.exit(args.run(args))
"""


def parsed(*words):
    parser = argparse.ArgumentParser()
    emulate_phone.add_parser(parser.add_subparsers(required=True))
    return parser.parse_args(["phone", *words])


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], r"--to is for .*say where"),
        (["--app", "sensor-server", "--to", "http://a"], r"it waits at --port"),
        (["--to", "https://a", "--rate", "0"], "--rate is 0"),
        (["--to", "https://a", "--drop", "2"], "--drop is 2"),
        (["--to", "https://a", "--jitter-ms", "-1"], "--jitter-ms is -1"),
        (["--to", "https://a", "--batch", "nan"], "--batch is nan"),
    ],
)
def test_what_cannot_be_emulated_is_one_sentence(words, sentence):
    args = parsed(*words)
    with pytest.raises(ConfigError, match=sentence):
        args.run(args)


def heard(entry, *words, folder=None):
    """The samples of a phone that is a process of its own, and how that ended."""

    async def scene():
        bands = PhoneBands([entry], folder=folder, retry_s=0.1)
        async with contextlib.aclosing(bands.source()) as source:
            first = asyncio.ensure_future(anext(source))
            while not entry.url and ":0/" in bands.urls()[entry.name]:  # the door is not open yet
                await asyncio.sleep(0.02)
            to = [] if entry.url else ["--to", bands.urls()[entry.name]]
            process = await asyncio.create_subprocess_exec(
                sys.executable, "-c", PROGRAM, "phone", "--app", entry.app, *to, *words,
                stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
            )  # fmt: skip
            events = [await asyncio.wait_for(first, 20)]
            async with asyncio.timeout(20):
                while len(events) < 40:
                    events.append(await anext(source))
            process.terminate()
            out, err = await asyncio.wait_for(process.communicate(), 10)
        return events, process.returncode, out.decode(), err.decode()

    return asyncio.run(scene())


def test_a_page_in_a_process_of_its_own(tmp_path):
    entry = PhoneEntry("wrist", listen="127.0.0.1:0", token="quiet-river-9")
    events, code, out, err = heard(entry, "--rate", "100", "--platform", "ios", folder=tmp_path)
    assert (code, err) == (0, "")
    assert out.startswith("speaking to https://127.0.0.1:")
    assert "quiet" not in out  # the token is nobody else's
    last = [event for event in events if isinstance(event, ImuSample)][-1]
    assert last.acc == pytest.approx((0, 0, 9.8), abs=0.1)

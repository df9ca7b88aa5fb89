"""Random and mutated bytes into every decoder: what it raises, whether it recovers, whether memory stays flat.

Each decoder gets strings that are random, or a valid packet with bits turned, bytes replaced, cut, lengthened or
joined to another. It may raise DeviceError and nothing else; from time to time a valid packet must decode (a stream
first gets as many zero bytes as its longest packet, which a receiver may be in the middle of). Memory is what
the last tenth of the strings leaves behind by tracemalloc's count once the garbage is collected: the same whether
there were ten thousand of them or a hundred thousand. Run: python benchmarks/fuzz.py
Prints a Markdown table; the exit code is 1 where a decoder failed.
"""

import argparse
import gc
import platform
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from armspan.devices.cellulo import relay
from armspan.devices.cellulo.wire import COMMANDS, EVENTS, Decoder
from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.boards import NAMED
from armspan.devices.metawear.usb_frames import UsbFramer, usb_frame
from armspan.devices.metawear.wire import BOOTLOADER, Ranges, decode
from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import Browser
from armspan.devices.phone.sensor_logger import SensorLogger
from armspan.devices.phone.sensor_server import FORCE, RATE, SensorServer
from armspan.devices.receptor.lines import Reader
from armspan.devices.toio import wire as toio
from armspan.devices.toio.cube import Cube
from armspan.errors import DeviceError

CHECK_EVERY = 1000
LONGEST = 40
RANGES = Ranges(8, 1000, {0: "acc", 1: "quaternion", 3: "raw"})


@dataclass(frozen=True)
class Target:
    """A decoder: ``feed`` takes bytes, ``recovers`` says whether a valid packet decodes now."""

    name: str
    feed: Callable[[bytes], object]
    seeds: tuple[bytes, ...]
    recovers: Callable[[], bool]


@dataclass
class Outcome:
    """What a decoder did with all strings; bytes are those that tracemalloc counts."""

    strings: int = 0
    understood: int = 0
    refused: int = 0
    failures: int = 0
    first_failure: str = ""
    checks: int = 0
    left_bytes: int = 0
    seconds: float = 0.0


def from_hex(words: str) -> tuple[bytes, ...]:
    return tuple(bytes.fromhex(word) for word in words.split())


FRAME_LINE = b"\x01C\x00\x02" + bytes(range(188))
CELLULO_EVENTS = (
    *from_hex(
        "014f 0144 0157 014202 015400 014c03 015203 014801 015000003039000109324650 "
        "015300004ce5000099ca23280001e240 014b01 0147 0141 01451234567800000001"
    ),
    FRAME_LINE,
)
CELLULO_COMMANDS = from_hex(
    "0150 01440014 015401 0146 012a000001cc 0142 014c02 014901 015501 014b01 0159003c003c0000 014500ff000000 "
    "014d02f001 01410064ff9c0000 0143138800000000 014700004ce5000099ca2328271000c8 014e000099ca00004ce52710 "
    "012d000001f32710 017c000001f32710 014f232800c8 0158 0156006400c8012c00640064 015a00640028 0148 "
    "012e42c8000042c80000 014a271000c8 0152 0153"
)
RELAY = from_hex("0140000666e78ad8 012102a0a4c5915e9b 013e01a0a4c5915e9b 0126") + CELLULO_EVENTS
METAWEAR = from_hex(
    "030400408000c000 031c62b7530de9fd16d04d0e57028affa1050a01 0305a400a4ff0000a400a4ff0000a400a4ff0000 "
    "1304a400a4ff0000 13050915ad2608de8a1a0d2665e48d20ac2773ec 15051000f0ff0100 19071b9b703f8c5e4dbd077f1dbe78029abe "
    "1904203e53c50cfe79460cfe79c600 1908b1f9c54144b9f1c21a2f04c2b1f9c541 1909ee20d33eb29301410459b0c0 198b000102 "
    "198cf6ff00000a00e8030300 030e11 010101 118c633410 118b01077b528fc9e8 111201 0b841504000005 "
    "0b07a1cc4d00006c010000 0b859e010000 0b0d 0383280c 13832803 19820110 03800101 1680 090201 0481000001 "
    "0903020a000000f40d3c3999110180d691d367 090300a6330d00c100b12419cd"
)
LOGGER = (
    b'{"messageId":1,"sessionId":"s","deviceId":"d","payload":[{"name":"accelerometer","time":1700000000000000000,'
    b'"values":{"x":0.1,"y":0.2,"z":0.3}},{"name":"gravity","time":1700000000000000000,"values":{"x":0,"y":0,"z":9.8}},'
    b'{"name":"gyroscope","time":1700000000000000000,"values":{"x":0,"y":0,"z":0}},{"name":"orientation","time":'
    b'1700000000000000000,"values":{"qw":1,"qx":0,"qy":0,"qz":0}}]}',
    b'{"payload":[{"name":"wrist motion","time":1.7e18,"values":{"rotationRateX":0,"rotationRateY":0,"rotationRateZ":0,'
    b'"gravityX":0,"gravityY":0,"gravityZ":-1,"accelerationX":0,"accelerationY":0,"accelerationZ":0}}]}',
)
SERVER = (
    f'{{"type":"{FORCE}","values":[0,0,9.8],"timestamp":1000000000,"accuracy":3}}'.encode(),
    f'{{"type":"{RATE}","values":[0,0,0],"timestamp":1000000000,"accuracy":3}}'.encode(),
    b'{"type":"android.sensor.game_rotation_vector","values":[0,0,0,1],"timestamp":1000000000,"accuracy":3}',
)
PAGE = (
    b'{"hello":{"page":"p","apple":false}}',
    b'{"n":1,"t":16.0,"a":[0,0,9.8],"r":[0,0,0],"o":[0,0,0]}',
    b'{"tap":2}',
    b'{"stop":true}',
)


def targets() -> list[Target]:
    """Every decoder, fresh."""
    return [
        Target("Cellulo, an event", EVENTS.decode, CELLULO_EVENTS, lambda: EVENTS.decode(b"\x01A").name != ""),
        Target("Cellulo, a command", COMMANDS.decode, CELLULO_COMMANDS, lambda: COMMANDS.decode(b"\x01P").name != ""),
        _cellulo_stream(),
        _relay_stream(),
        *(_metawear(name) for name in NAMED),
        _usb(),
        _toio(),
        *_phones(),
        _receptor(),
        _emulated_board(),
        _emulated_cube(),
    ]


def _cellulo_stream() -> Target:
    robot = Decoder(EVENTS)

    def recovers() -> bool:
        robot.feed(bytes(192))
        return [packet.name for packet in robot.feed(b"\x01A")] == ["acknowledged"]

    return Target("Cellulo, a robot's stream", robot.feed, CELLULO_EVENTS, recovers)


def _relay_stream() -> Target:
    host, server = relay.client_side(), relay.server_side()

    def feed(data: bytes) -> object:
        return host.feed(data, 0.0), server.feed(data, 0.0)

    def recovers() -> bool:
        feed(bytes(192))
        feed(bytes.fromhex("0140000666e78ad8"))
        return host.feed(b"\x01A", 0.0) == [("00:06:66:E7:8A:D8", b"\x01A")] and bool(server.feed(b"\x01P", 0.0))

    return Target("Cellulo, EPFL's relay, both ends", feed, RELAY + CELLULO_COMMANDS, recovers)


def _metawear(name: str) -> Target:
    board = NAMED[name]

    def feed(data: bytes) -> object:
        return decode(data, board, RANGES)

    def recovers() -> bool:
        return feed(bytes.fromhex("118c633410")) is not None

    return Target(f"MetaWear, {name}", feed, METAWEAR, recovers)


def _usb() -> Target:
    framer, board = UsbFramer(), NAMED["mms"]

    def feed(data: bytes) -> object:
        return [decode(payload, board, RANGES) for payload in framer.feed(data)]

    def recovers() -> bool:
        framer.feed(bytes(258))
        return framer.feed(usb_frame(b"\x11\x8c\x63\x34\x10")) == [b"\x11\x8c\x63\x34\x10"]

    return Target("MetaWear, the USB cable", feed, tuple(map(usb_frame, METAWEAR)), recovers)


def _toio() -> Target:
    seeds = from_hex("01bc0282015a00bc0282015a00 03 01010164020164 0200320201320a 8301 64 0180 010a0100 0300ff00ff0102")

    def feed(data: bytes) -> object:
        return toio.decodings(None, data)

    return Target("toio", feed, seeds, lambda: toio.decode("battery", b"\x64").name != "")


def _phones() -> list[Target]:
    """The clock stands still, as for texts of one moment."""
    logger, watch = SensorLogger(Band("a")), SensorLogger(Band("b"), watch=True)
    server, page = SensorServer(Band("c")), Browser(Band("d"))

    def pushed(data: bytes) -> object:
        return logger.feed(data, 1.0), watch.feed(data, 1.0)

    def reads(decoder: SensorLogger | SensorServer | Browser, data: bytes) -> Callable[[], bool]:
        return lambda: isinstance(decoder.feed(data, 1.0), list)

    return [
        Target("phone, Sensor Logger", pushed, LOGGER, reads(logger, LOGGER[0])),
        Target("phone, SensorServer", lambda data: server.feed(data, 1.0), SERVER, reads(server, SERVER[0])),
        Target("phone, our page", lambda data: page.feed(data, 1.0), PAGE, reads(page, PAGE[2])),
    ]


def _receptor() -> Target:
    reader, seeds = Reader(("r1", "r2")), (b"hit r1\n", b"lost r2 token=s\r\n", b"hit r1\nlost r1\n")

    def recovers() -> bool:
        reader.feed(b"\n")
        return [line.robot for line in reader.feed(b"hit r2\n")] == ["r2"]

    return Target("a receptor's lines", lambda data: (reader.feed(data), reader.whole(data)), seeds, recovers)


def _emulated_board() -> Target:
    """Its other end: a host's writes, some of which make it begin anew."""
    board, now = MetaWearBoard("mms"), [0.0]
    writes = from_hex(
        "0180 0b84 118c 118b 0303a803 0383 03020100 030101 030100 13032800 130101 15040102 150306 19020113 1982 "
        "19030800 190101 190100 190701 198b 198c 020300021f00000032000000f40188130a 020101 0801f8b80b00 "
        "0c02e8030000030001 0a02110aff080104 0a03f8b80b00 09021305ffa00f05 0908 0a05 0b0a fe0301010007 "
        "11090600060000005802 010101"
    )

    def feed(data: bytes) -> list[bytes]:
        if data[:2] != BOOTLOADER:  # from which there is no return
            board.write(data)
        return board.advance(now[0])

    def recovers() -> bool:
        now[0] += 20.0
        board.linked(True)
        feed(b"\xfe\x01")
        now[0] += 20.0
        board.linked(True)
        return b"\x03\x80\x04\x00" in feed(b"\x03\x80")

    return Target("MetaWear, the emulated board", feed, writes, recovers)


def _emulated_cube() -> Target:
    cube = Cube()
    writes = from_hex(
        "010101640201640000 020101640201640a00 03000500500000bc0282015a00 0300ff0101ff0102 18000a01 18000a010101"
    )

    def feed(data: bytes) -> object:
        cube.write(0.0, ("motor", "light", "configuration")[len(data) % 3], data)
        return cube.frame(0.0, None)

    def recovers() -> bool:
        cube.write(0.0, "motor", bytes.fromhex("01010164020164"))
        return cube.wheels == (100, 100)

    return Target("toio, the emulated cube", feed, writes, recovers)


def strings(seeds: tuple[bytes, ...], rng: np.random.Generator, count: int) -> Iterator[bytes]:
    """Random strings and mutations of valid packets."""
    draws = rng.integers(0, (6, len(seeds), len(seeds), 1 << 16, 256, LONGEST), (count, 6)).tolist()
    junk = rng.bytes(count + LONGEST)
    for k, (kind, a, b, where, byte, length) in enumerate(draws):
        one = seeds[a]
        yield _string(kind, one, seeds[b], where % len(one), byte, junk[k : k + length])


def _string(kind: int, one: bytes, other: bytes, where: int, byte: int, junk: bytes) -> bytes:
    match kind:
        case 0:
            return junk
        case 1:  # turn a bit
            return one[:where] + bytes((one[where] ^ 1 << byte % 8,)) + one[where + 1 :]
        case 2:
            return one[:where] + bytes((byte,)) + one[where + 1 :]
        case 3:
            return one[:where]
        case 4:
            return one + junk
    return one[:where] + other


def fuzz(target: Target, count: int, seed: int) -> Outcome:
    """Feed ``count`` strings; what the last tenth of them allocates and leaves behind is counted."""
    outcome, rng, start = Outcome(), np.random.default_rng(seed), time.perf_counter()
    while outcome.strings < count:
        if outcome.strings * 10 >= count * 9 and not tracemalloc.is_tracing():
            gc.collect()
            tracemalloc.start()
        for data in strings(target.seeds, rng, min(CHECK_EVERY, count - outcome.strings)):
            _feed(target, data, outcome)
        outcome.checks += 1
        if not _recovered(target):
            _fail(outcome, "a valid packet did not decode")
    outcome.left_bytes = _left()
    outcome.seconds = time.perf_counter() - start
    return outcome


def _feed(target: Target, data: bytes, outcome: Outcome) -> None:
    outcome.strings += 1
    try:
        target.feed(data)
        outcome.understood += 1
    except DeviceError:
        outcome.refused += 1
    except Exception as error:  # what this looks for
        _fail(outcome, f"{data.hex()}: {type(error).__name__}: {error}")


def _recovered(target: Target) -> bool:
    try:
        return target.recovers()
    except Exception:  # then it did not
        return False


def _fail(outcome: Outcome, words: str) -> None:
    outcome.failures += 1
    outcome.first_failure = outcome.first_failure or words


def _left() -> int:
    """Bytes allocated since the tracing began that are still there."""
    gc.collect()
    left, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return left


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--strings", type=int, default=1_000_000, help="into each decoder; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="only decoders whose name contains this; default: all")
    args = parser.parse_args()
    chosen = [target for target in targets() if (args.only or "").lower() in target.name.lower()]
    if not chosen:
        parser.error(f"no decoder is named {args.only!r}; known: {', '.join(target.name for target in targets())}")
    print(f"{args.strings} strings into each decoder; Python {platform.python_version()}, seed {args.seed}\n")
    columns = (
        "decoder",
        "decoded",
        "DeviceError",
        "anything else",
        "valid packets after",
        "left behind by the last tenth [bytes]",
        "us each",
    )
    print(f"| {' | '.join(columns)} |")
    print("|---" * len(columns) + "|")
    failures = []
    for target in chosen:
        outcome = fuzz(target, args.strings, args.seed)
        each = outcome.seconds / outcome.strings * 1e6
        print(
            f"| {target.name} | {outcome.understood} | {outcome.refused} | {outcome.failures} | {outcome.checks} "
            f"| {outcome.left_bytes} | {each:.1f} |",
            flush=True,
        )
        failures += [f"{target.name}: {outcome.first_failure}"] if outcome.failures else []
    print("\n".join(["", *failures]), file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

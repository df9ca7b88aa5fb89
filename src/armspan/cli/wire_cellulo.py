"""The Cellulo part of ``armspan wire``: lines as {"name", "args"} and {"hex"}, both directions, whole streams."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from armspan.cli.wire_lines import hexadecimal, mapping, required, text_of
from armspan.devices.cellulo.wire import COMMANDS, EVENTS, RELAY_ONLY, START, Direction, Framer
from armspan.errors import DeviceError

_SIDES = {"host": COMMANDS, "robot": EVENTS}
_HINTS = {
    "decoded": "robot",
    "parsed": "robot",
    "args": "host",
    "firmware_handlers_called": "host",
}
_DIRECTIONS = {"client->server": "host", "server->client": "robot"}


@dataclass(frozen=True)
class _Reading:
    """A stream as one receiver takes it apart: (end, packet) in order."""

    side: str
    relay: bool
    packets: tuple[tuple[int, bytes], ...]

    @property
    def covered(self) -> int:
        return sum(len(packet) for _, packet in self.packets)


def names() -> list[str]:
    """Commands, then events, with their arguments."""
    return [
        " ".join((layout.name, *(f"{key}=" for key, _ in layout.fields)))
        for direction in (COMMANDS, EVENTS)
        for layout in direction.by_name.values()
    ]


def asked(line: Mapping[str, Any]) -> str:
    """What a line wants where nobody says it."""
    return "decode" if "hex" in line and "args" not in line else "encode"


def from_words(verb: str, word: str, args: dict[str, Any]) -> dict[str, Any]:
    """The command line as a line."""
    return {"name": word, "args": args} if verb == "encode" else {"hex": word, **args}


def encode(line: Mapping[str, Any]) -> dict[str, Any]:
    """The packet of a name and its arguments; an event's may be given as it was decoded."""
    name = required(line, "name")
    args = mapping(line, "args") or mapping(line, "decoded")
    side = _side_told(line) or ("robot" if name in EVENTS.by_name and name not in COMMANDS.by_name else "host")
    direction = _SIDES[side if name in _SIDES[side].by_name else "host"]
    packet = direction.encode(name, **_arguments(direction, name, args))
    return {"name": name, "args": dict(args), "hex": packet.hex()}


def decode(line: Mapping[str, Any]) -> dict[str, Any]:
    """The packets in a stream of bytes, and what is skipped; another reading that fits as well is there ``also``.

    Where it is told who sent them, no packet at all is an answer too.
    """
    stream = hexadecimal(line, "hex", "bytes")
    side = _side_told(line)
    answers = [_answer(stream, reading) for reading in _readings(stream, (side,) if side else ("robot", "host"))]
    first, *others = [answer for answer in answers if not _refused(answer)] or answers
    if first["packets"] and _refused(first):
        raise DeviceError(first["packets"][0]["error"])
    if not first["packets"] and not side:
        raise DeviceError(f"{stream[:20].hex() or 'nothing'} holds no whole Cellulo packet: 01, type, payload")
    return first | ({"also": others} if others else {})


def told(answer: Mapping[str, Any]) -> list[str]:
    """An answer for a person."""
    if "packets" not in answer:
        return [str(answer["hex"])]
    lines = [_told_packet(answer["from"], packet) for packet in answer["packets"]]
    lines += [f"skipped: {junk}" for junk in answer["skipped"]]
    lines += [f"incomplete: {answer['rest']}"] if answer["rest"] else []
    return lines + [f"or {line}" for other in answer.get("also", ()) for line in told(other)]


def _told_packet(side: str, packet: Mapping[str, Any]) -> str:
    if "error" in packet:
        return f"from the {side}: {packet['hex']} {packet['error']}"
    args = " ".join(f"{key}={text_of(value)}" for key, value in packet["decoded"].items())
    return f"from the {side}: {packet['name']} {args}".rstrip()


def _side_told(line: Mapping[str, Any]) -> str | None:
    """Who sent a line's bytes, where it tells."""
    told = line.get("from", _DIRECTIONS.get(str(line.get("dir"))))
    if told is None:
        known = [side for side, direction in _SIDES.items() if str(line.get("name")) in direction.by_name]
        return known[0] if len(known) == 1 else next((side for key, side in _HINTS.items() if key in line), None)
    if str(told) not in _SIDES:
        raise DeviceError(f"from is {str(told)[:40]!r}; expected host or robot")
    return str(told)


def _arguments(direction: Direction, name: str, args: Mapping[str, Any]) -> dict[str, Any]:
    """What the encoder takes: an event's raw numbers of those that were decoded, pixels as bytes."""
    layout = direction.by_name.get(name)
    known = [key for key, _ in layout.fields] if layout else []
    if direction is EVENTS:
        args = {key: value for key, value in args.items() if key in known}
    for reserved in {"self", "name"} & set(args):
        raise DeviceError(f"{name} has no argument {reserved}; its arguments are {', '.join(known) or 'none'}")
    return {**args, "pixels": hexadecimal(args, "pixels", "pixels")} if name == "frameLine" else dict(args)


def _readings(stream: bytes, sides: tuple[str, ...]) -> list[_Reading]:
    """The ways to take a stream apart that explain the most of it, a robot's own link before the relay's."""
    both = {side: max((_read(stream, side, relay) for relay in (False, True)), key=_covered) for side in sides}
    most = max(map(_covered, both.values()))
    return [reading for reading in both.values() if reading.covered == most]


def _refused(answer: Mapping[str, Any]) -> bool:
    """Whether no packet of a reading makes sense."""
    return all("error" in packet for packet in answer["packets"])


def _covered(reading: _Reading) -> int:
    return reading.covered


def _read(stream: bytes, side: str, relay: bool) -> _Reading:
    framer = Framer(_SIDES[side], relay=relay)
    found = ((end, packet) for end in range(1, len(stream) + 1) for packet in framer.feed(stream[end - 1 : end]))
    return _Reading(side, relay, tuple(found))


def _answer(stream: bytes, reading: _Reading) -> dict[str, Any]:
    packets, skipped, at = [], [], 0
    for end, packet in reading.packets:
        if end - len(packet) > at:
            skipped.append(stream[at : end - len(packet)].hex())
        packets.append(_packet(reading.side, packet) | {"end": end - 1})
        at = end
    waits = _waits(stream, at, reading)
    skipped += [stream[at:waits].hex()] if waits > at else []
    alone = packets[0] if len(packets) == 1 else {}
    return {"from": reading.side, **alone, "packets": packets, "skipped": skipped, "rest": stream[waits:].hex()}


def _waits(stream: bytes, at: int, reading: _Reading) -> int:
    """From where on the receiver waits for more bytes."""
    known = [char for char in _SIDES[reading.side].lengths if reading.relay or char not in RELAY_ONLY]
    while (start := stream.find(START, at)) >= 0:
        if start + 1 == len(stream) or stream[start + 1] in known:
            return start
        at = start + 2
    return len(stream)


def _packet(side: str, packet: bytes) -> dict[str, Any]:
    try:
        meaning = _SIDES[side].decode(packet)
    except DeviceError as error:
        return {"hex": packet.hex(), "error": str(error)}
    told: dict[str, Any] = {}
    for key, value in meaning.args.items():
        if isinstance(value, bytes):
            told[key] = f"{len(value)} bytes 0x{value[0]:02x}..0x{value[-1]:02x}"
            told[f"{key}_hex"] = value.hex()
        else:
            told[key] = value
    return {"name": meaning.name, "decoded": told, "args": told, "hex": packet.hex()}

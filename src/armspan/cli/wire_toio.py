"""The toio part of ``armspan wire``: lines as {"name", "args"} and {"hex", "characteristic"}."""

from collections.abc import Mapping
from typing import Any

from armspan.cli.wire_lines import hexadecimal, mapping, required, text_of
from armspan.devices.toio.packets import COMMANDS, EVENTS
from armspan.devices.toio.wire import decodings
from armspan.devices.toio.wire import encode as packet_of
from armspan.errors import DeviceError


def names() -> list[str]:
    """Commands, then events, with their arguments."""
    layouts = (*COMMANDS.values(), *EVENTS.values())
    return [" ".join((layout.name, *(f"{key}=" for key in layout.arguments))) for layout in layouts]


def asked(line: Mapping[str, Any]) -> str:
    """What a line wants where nobody says it."""
    return "decode" if "hex" in line and "args" not in line else "encode"


def from_words(verb: str, word: str, args: dict[str, Any]) -> dict[str, Any]:
    """The command line as a line."""
    return {"name": word, "args": args} if verb == "encode" else {"hex": word, **args}


def encode(line: Mapping[str, Any]) -> dict[str, Any]:
    """The packet of a name and its arguments, and the characteristic that it is written to."""
    name = required(line, "name")
    args = mapping(line, "args")
    if "name" in args:
        raise DeviceError(f"{name} has no argument 'name'; --list shows which it has")
    characteristic, data = packet_of(name, **args)
    return {"name": name, "args": dict(args), "characteristic": characteristic, "hex": data.hex()}


def decode(line: Mapping[str, Any]) -> dict[str, Any]:
    """What a packet means; where several characteristics have such a one, the others ``also``."""
    data = hexadecimal(line, "hex", "bytes")
    at = line.get("characteristic", line.get("char"))
    if at is not None and not isinstance(at, str):
        raise DeviceError(f"a characteristic is {at!r}; expected its name, its number as 10B20102 or its UUID")
    first, *others = [
        {"name": packet.name, "characteristic": packet.characteristic, "decoded": packet.args, "args": packet.args}
        for packet in decodings(at, data)
    ]
    return {"hex": data.hex(), **first} | ({"also": others} if others else {})


def told(answer: Mapping[str, Any]) -> list[str]:
    """An answer for a person."""
    if "decoded" not in answer:
        return [f"{answer['hex']}"]
    args = " ".join(f"{key}={text_of(value)}" for key, value in answer["decoded"].items())
    line = f"{answer['characteristic']}: {answer['name']} {args}".rstrip()
    return [line, *(f"or {other}" for also in answer.get("also", ()) for other in told(also))]

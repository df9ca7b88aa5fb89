"""The bytes between a toio core cube and its host, without I/O: all characteristics, both ways.

The cube throws away what has another length than it should or a number out of range, and says nothing; so that is
refused here (toio core cube specification, toio.github.io/toio-spec, BLE protocol 2.0 to 2.5).
"""

import struct
from collections.abc import Mapping, Sequence

import msgspec

from armspan.devices.toio.fields import Field, Raw, Value, keys_of
from armspan.devices.toio.packets import ALL, COMMANDS, EVENTS, POSTURES, RESULTS, SERVICE, UUIDS, WHEELS, Layout
from armspan.errors import DeviceError, known_names

__all__ = [
    "COMMANDS",
    "EVENTS",
    "SERVICE",
    "UUIDS",
    "Layout",
    "Packet",
    "characteristic_name",
    "decode",
    "decodings",
    "encode",
]


class Packet(msgspec.Struct, frozen=True):
    """A packet's meaning: its name, its characteristic, and ``args`` in the units that their names tell."""

    name: str
    characteristic: str
    args: dict[str, Value]


def encode(name: str, **args: object) -> tuple[str, bytes]:
    """The characteristic's name and the bytes of a command, or of an event as the cube sends it.

    Raises:
        DeviceError: for a name or an argument that does not exist or is missing, or a number that must not reach
            the wire.

    """
    layout = ALL.get(name)
    if layout is None:
        raise DeviceError(known_names("toio packet", name, ALL))
    _check_arguments(layout.name, layout.arguments, args)
    data = layout.head + _packed(layout.name, layout.fields, args)
    return layout.characteristic, data + (_list_packed(layout, args[layout.many]) if layout.many else b"")


def decode(characteristic: str | None, data: bytes) -> Packet:
    """The meaning of one packet of a characteristic: its name, its number as 10B20102, its UUID, or None for any.

    Raises:
        DeviceError: where it is none, where several characteristics have such a one, or for a characteristic that
            does not exist.

    """
    readings = decodings(characteristic, data)
    if len(readings) > 1:
        could = ", ".join(f"{packet.name} of {packet.characteristic}" for packet in readings)
        raise DeviceError(f"{data.hex()} could be {could}; name the characteristic")
    return readings[0]


def decodings(characteristic: str | None, data: bytes) -> list[Packet]:
    """Everything that some bytes can mean, at least one; raises as `decode` does where they mean nothing."""
    at = None if characteristic is None else characteristic_name(characteristic)
    readings: list[Packet] = []
    wrong = ""
    for layout in ALL.values():
        if (at is None or layout.characteristic == at) and data.startswith(layout.head):
            try:
                readings.append(_decoded(layout, data))
            except ValueError as error:
                wrong = wrong or f" ({layout.name}: {error})"
    if not readings:
        where = f"of its {at} characteristic" if at is not None else "of any characteristic"
        raise DeviceError(f"{data[:24].hex() or 'nothing'} is no toio packet {where}{wrong}")
    return readings


def characteristic_name(text: str) -> str:
    """A characteristic's name from its name, its number as 10B20102, or its UUID.

    Raises:
        DeviceError: for one that does not exist.

    """
    short = text.lower()
    for name, uuid in UUIDS.items():
        if short in (name, uuid, uuid[:8]):
            return name
    raise DeviceError(known_names("toio characteristic", text, UUIDS))


def _check_arguments(what: str, wanted: Sequence[str], args: Mapping[str, object]) -> None:
    missing = [key for key in wanted if key not in args]
    if missing:
        raise DeviceError(f"{what} needs {', '.join(missing)}; its arguments are {', '.join(wanted)}")
    for key in args:
        if key not in wanted:
            raise DeviceError(known_names(f"{what}'s argument", key, wanted))


def _packed(what: str, fields: Sequence[Field], args: Mapping[str, object]) -> bytes:
    raw: list[Raw] = []
    for field in fields:
        values = [args[key] for key in field.keys]
        try:
            raw.append(field.pack(*values))
        except ValueError as error:
            told = " and ".join(f"{key} is {value!r}" for key, value in zip(field.keys, values, strict=True))
            raise DeviceError(f"{what}'s {told}; expected {error}") from None
    return struct.pack(_form(fields), *raw)


def _list_packed(layout: Layout, items: object) -> bytes:
    """A list of groups, with its length before it where it is counted."""
    if not isinstance(items, list | tuple) or not 1 <= len(items) <= layout.most:
        raise DeviceError(f"{layout.name} takes 1 to {layout.most} {layout.many}, each with {keys_of(layout.group)}")
    data = bytes((len(items),)) if layout.counted else b""
    for item in items:
        if not isinstance(item, Mapping):
            raise DeviceError(f"{layout.name}'s {layout.many} are {item!r}; expected each with {keys_of(layout.group)}")
        what = f"{layout.name}'s {layout.many}"
        _check_arguments(what, keys_of(layout.group), item)
        data += _packed(what, layout.group, item)
    return data


def _decoded(layout: Layout, data: bytes) -> Packet:
    """A packet taken apart; ValueError with what was expected."""
    body = _in_order(layout, data)[len(layout.head) :]
    length = struct.calcsize(_form(layout.fields))
    if len(body) < length or (len(body) > length and not layout.many):
        raise ValueError(f"{len(layout.head) + length} bytes")
    args: dict[str, Value] = dict(_unpacked(layout.fields, body[:length]))
    if layout.many:
        args[layout.many] = _list_unpacked(layout, body[length:])
    return Packet(layout.name, layout.characteristic, args | _in_words(args))


def _in_order(layout: Layout, data: bytes) -> bytes:
    """A motor's packet with the left wheel first: either order may be sent."""
    if layout.fields[:2] == WHEELS and len(data) >= 7 and data[1] == 2:
        return data[:1] + data[4:7] + data[1:4] + data[7:]
    return data


def _unpacked(fields: Sequence[Field], body: bytes) -> dict[str, int | float | str | bool]:
    args: dict[str, int | float | str | bool] = {}
    for field, raw in zip(fields, struct.unpack(_form(fields), body), strict=True):
        args.update(zip(field.keys, field.unpack(raw), strict=True))
    return args


def _list_unpacked(layout: Layout, body: bytes) -> list[dict[str, int | float | str | bool]]:
    size = struct.calcsize(_form(layout.group))
    if layout.counted:
        told, body = body[0] if body else 0, body[1:]
    else:
        told = len(body) // size
    if not 1 <= told <= layout.most or len(body) % size or told > len(body) // size:
        raise ValueError(f"1 to {layout.most} {layout.many} of {size} bytes each")
    return [_unpacked(layout.group, body[k * size : (k + 1) * size]) for k in range(told)]


def _form(fields: Sequence[Field]) -> str:
    return "<" + "".join(field.code for field in fields)


def _in_words(args: Mapping[str, Value]) -> dict[str, Value]:
    """What a number means, beside it."""
    result, posture = args.get("result"), args.get("posture")
    if isinstance(result, int) and "id" in args:
        return {"result_name": RESULTS[result]}
    return {"posture_name": POSTURES[posture]} if isinstance(posture, int) else {}

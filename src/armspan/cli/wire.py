"""``armspan wire``: the bytes of a device's commands, and the meaning of its bytes, for when it does not answer."""

import argparse
import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import msgspec

from armspan.cli import wire_cellulo, wire_metawear, wire_toio
from armspan.errors import ArmspanError, DeviceError, known_names


class _Language(Protocol):
    """What a device's module offers; a line is one object of a batch, or the command line as one."""

    def names(self) -> list[str]: ...
    def asked(self, line: Mapping[str, Any]) -> str: ...
    def from_words(self, verb: str, word: str, args: dict[str, Any]) -> dict[str, Any]: ...
    def encode(self, line: Mapping[str, Any]) -> dict[str, Any]: ...
    def decode(self, line: Mapping[str, Any]) -> dict[str, Any]: ...
    def told(self, answer: Mapping[str, Any]) -> list[str]: ...


_LANGUAGES: dict[str, _Language] = {"cellulo": wire_cellulo, "metawear": wire_metawear, "toio": wire_toio}
_VERBS = ("encode", "decode")


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--json", action="store_true", help="print one JSON object")
    options.add_argument("--batch", metavar="FILE", help="one JSON object a line in and out; - is stdin")
    options.add_argument("--list", action="store_true", help="list the names that can be encoded")
    options.add_argument("--from", dest="origin", choices=("host", "robot"), help="who sent what is decoded")
    parser = subparsers.add_parser(
        "wire",
        parents=[options],
        help="a command's bytes, or the meaning of bytes, of a device",
        description="`wire DEVICE encode NAME key=value ...` prints the bytes of a command, several writes one a line; "
        "`wire DEVICE decode HEX key=value ...` prints what bytes mean.",
    )
    parser.add_argument("device", choices=sorted(_LANGUAGES), metavar="DEVICE", help="cellulo, metawear or toio")
    parser.add_argument("words", nargs=argparse.REMAINDER, metavar="WORDS", help="encode NAME ..., or decode HEX ...")
    within = type(parser)(prog=f"{parser.prog} DEVICE", parents=[options], description=parser.description)
    within.add_argument("words", nargs="*", metavar="WORDS", help="encode NAME ..., or decode HEX ...")
    parser.set_defaults(run=run, within=within)


def run(args: argparse.Namespace) -> int:
    """Encode or decode; the exit code is 2 where a line of a batch was refused."""
    before = {key: value for key, value in vars(args).items() if key != "words"}
    args = args.within.parse_intermixed_args(args.words, argparse.Namespace(**before))
    language = _LANGUAGES[args.device]
    verb = args.words[0] if args.words else ""
    if verb and verb not in _VERBS:
        raise DeviceError(known_names("wire's verb", verb, _VERBS))
    if args.list:
        print("\n".join(language.names()))
        return 0
    if args.batch is not None:
        if len(args.words) > 1:
            raise DeviceError(f"--batch takes its lines from {args.batch}; {args.words[1]!r} has no place beside it")
        return _batch(language, verb, args.batch, args.origin)
    answer = _answer(language, verb, _line(language, verb, args.words[1:], args.origin))
    print(_json(answer) if args.json else "\n".join(language.told(answer)))
    return 0


def _line(language: _Language, verb: str, words: list[str], origin: str | None) -> dict[str, Any]:
    """The command line as a batch would say it."""
    args = dict(word.split("=", 1) for word in words if "=" in word)
    plain = [word for word in words if "=" not in word]
    if not verb or not plain:
        raise DeviceError("say `encode NAME key=value ...` or `decode HEX`; --list shows the names")
    if verb == "encode" and len(plain) > 1:
        raise DeviceError(f"{plain[1]!r} is no argument of {plain[0]}; expected key=value")
    line = language.from_words(verb, "".join(plain), {key: _value(text) for key, text in args.items()})
    return line | ({"from": origin} if origin else {})


def _value(text: str) -> Any:
    """A number, a list, true or null where it is one; else the text."""
    try:
        return msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError):
        return text


def _answer(language: _Language, verb: str, line: Mapping[str, Any]) -> dict[str, Any]:
    return language.encode(line) if (verb or language.asked(line)) == "encode" else language.decode(line)


def _batch(language: _Language, verb: str, file: str, origin: str | None) -> int:
    """Answer each line with one; say how many were refused."""
    refused = lines = 0
    for text in _lines(file):
        lines += 1
        try:
            line = {"from": origin, **_object(text)} if origin else _object(text)
            answer = _answer(language, verb, line)
        except ArmspanError as error:
            refused += 1
            answer = {"error": str(error)}
        print(_json(answer), flush=file == "-")
    if refused:
        print(f"armspan wire: {refused} of {lines} lines could not be understood", file=sys.stderr)
    return 2 if refused else 0


def _lines(file: str) -> Iterator[bytes]:
    if file == "-":
        yield from _stripped(sys.stdin.buffer)
        return
    with Path(file).open("rb") as stream:
        yield from _stripped(stream)


def _stripped(stream: BinaryIO) -> Iterator[bytes]:
    return (line.strip() for line in stream)


def _object(text: bytes) -> dict[str, Any]:
    try:
        line = msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DeviceError(f"not a line of JSON: {error}") from None
    if not isinstance(line, dict):
        raise DeviceError(f"a line is {text[:40].decode(errors='replace')}; expected an object, as {{...}}")
    return line


def _json(answer: Mapping[str, Any]) -> str:
    return json.dumps(answer, separators=(",", ":"))  # escapes what no encoding can carry

"""``armspan init``: a commented room file to start from."""

import argparse
import secrets
from pathlib import Path

from armspan.cli.room_texts import ROOMS, TOKEN
from armspan.errors import ConfigError


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "init",
        help="write a commented room file to start from",
        description="Write a commented room file; an existing file is never replaced.",
    )
    parser.add_argument(
        "--devices", choices=tuple(ROOMS), default="simulated", help="what stands in it; default: %(default)s"
    )
    parser.add_argument("room", type=Path, nargs="?", default=Path("room.toml"), metavar="ROOM.toml")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Write the file."""
    try:
        with args.room.open("x", encoding="utf-8") as file:
            file.write(ROOMS[args.devices].replace(TOKEN, secrets.token_urlsafe(12)))
    except FileExistsError:
        raise ConfigError(f"{args.room} exists and is kept; name another file: armspan init OTHER.toml") from None
    except OSError as error:
        raise ConfigError(f"{args.room} cannot be written: {error.strerror}") from None
    print(f"{args.room} is written; open it with: armspan run {args.room}")
    return 0

"""The verbs. Results go to stdout, talk to stderr; bad input is one sentence and exit code 2."""

import argparse
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from armspan import __version__
from armspan.cli import (
    body,
    calibrate,
    check,
    demo,
    emulate,
    evaluate,
    init,
    record,
    replay,
    run,
    spot,
    study,
    swarm,
    takes,
    train,
    wire,
)
from armspan.errors import ArmspanError

_VERBS = (
    demo,
    run,
    swarm,
    init,
    body,
    calibrate,
    record,
    takes,
    train,
    evaluate,
    spot,
    study,
    replay,
    check,
    emulate,
    wire,
)


class _OneLine(argparse.ArgumentParser):
    """Says what is wrong with a command line in one sentence, without the usage before it."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; see `{self.prog} --help`\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; the exit code is 0, 1 for a difference found, 2 for bad input, 130 for Ctrl-C."""
    args = _parsed(argv)
    try:
        return int(args.run(args))
    except ArmspanError as error:
        if args.debug:
            raise
        print(f"armspan {args.verb}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of stdout has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # a full disk, a folder that may not be written
        if args.debug:
            raise
        print(f"armspan {args.verb}: {error.filename or 'the output'}: {error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"armspan {args.verb}: interrupted", file=sys.stderr)
        return 130


def _parsed(argv: Sequence[str] | None) -> argparse.Namespace:
    """The arguments; what no verb knows is complained about in the name of the verb, which argparse would not."""
    args, unknown = parser().parse_known_args(argv)
    if unknown:
        verb = f"armspan {args.verb}"
        print(f"{verb}: unrecognized arguments: {' '.join(unknown)}; see `{verb} --help`", file=sys.stderr)
        sys.exit(2)
    return args


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = _OneLine(
        prog="armspan",
        description="Your arms as a remote control for tabletop robots: point, select, steer.",
        epilog="`armspan VERB --help` tells a verb's options. Start with `armspan demo`.",
    )
    top.add_argument("--version", action="version", version=f"armspan {__version__}")
    top.add_argument("--debug", action="store_true", help="show the whole traceback of an error")
    verbs = top.add_subparsers(dest="verb", metavar="VERB", required=True, title="verbs")
    for module in _VERBS:
        module.add_parser(verbs)
    return top

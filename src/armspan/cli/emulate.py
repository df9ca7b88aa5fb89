"""``armspan emulate``: devices that are not there, in bytes, for a host that cannot tell the difference."""

import argparse

from armspan.cli import emulate_cellulo, emulate_metawear, emulate_phone, emulate_toio


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its devices."""
    verb = subparsers.add_parser(
        "emulate",
        help="pretend to be wristbands, robots or a phone, byte for byte",
        description="Emulate devices. The first line on stdout tells where they listen; Ctrl-C ends them.",
    )
    devices = verb.add_subparsers(dest="device", metavar="DEVICE", required=True, title="devices")
    for device in (emulate_metawear, emulate_phone, emulate_cellulo, emulate_toio):
        device.add_parser(devices)

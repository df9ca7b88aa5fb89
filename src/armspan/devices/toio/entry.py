"""A toio cube as a room file names it."""

import math
from typing import Literal

import msgspec

from armspan.devices.toio.quantities import MATS
from armspan.errors import ConfigError
from armspan.links.ble import checked_address
from armspan.records import Vec2


class ToioEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="toio"):
    """A cube by its Bluetooth address, and the mat that the sheet is: its name, or the position IDs of its corner.

    ``radio`` reaches it by another one than the room's, such as "hci1".

    Raises:
        ConfigError: for no name, an address that is not one, or a corner that is no place on any mat.

    """

    name: str
    address: str
    mat: Literal["ring", "tile", "simple"] | Vec2 = "ring"
    radio: str | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise ConfigError("a toio cube has no name; give it one, as in name = 'ash'")
        try:
            checked_address(self.address)
        except ConfigError as error:
            raise ConfigError(f"robot {self.name!r}: {error}") from None
        if not isinstance(self.mat, str) and not all(math.isfinite(at) and 0 <= at < 0xFFFF for at in self.mat):
            raise ConfigError(
                f"robot {self.name!r} has mat = {self.mat}; expected 'ring', 'tile', 'simple', or the two position "
                "IDs of the sheet's top left corner, 0 to 65534 each, as in [45, 45]"
            )

    @property
    def corner(self) -> Vec2:
        """The position IDs of the mat's top left corner."""
        return MATS[self.mat][0] if isinstance(self.mat, str) else self.mat

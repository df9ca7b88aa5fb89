"""The line of words by which a board on a cable says what it is."""

import pytest

from armspan.devices.metawear.carriers import identity_of
from armspan.devices.metawear.handshake import Identity

MMS = Identity("1.7.2", "8", "0.1", "MbientLab Inc", "047D22")


@pytest.mark.parametrize(
    "text",
    [
        b"MbientLab Inc MetaMotionS 8 0.1 1.7.2 047D22\n",
        b"MbientLab Inc MetaMotion S 8 0.1 1.7.2 047D22\r\n",
        b"MbientLab Inc MetaMotionR 5 0.4 1.5.0 0000AA\nMbientLab Inc MetaMotionS 8 0.1 1.7.2 047D22\n",
        b"\x1f\x12\x19\x07\x00\x00\x80\x3f\x00\x0aMbientLab Inc MetaMotionS 8 0.1 1.7.2 047D22\n\x1f\x03",
        b"noise\nMbientLab Inc MetaMotionS 8 0.1 1.7.2 047D22\nrest",
    ],
)
def test_it_is_read_from_the_right(text):
    assert identity_of(text) == MMS


@pytest.mark.parametrize(
    "text", [b"", b"MbientLab Inc MetaMotionS 8 0.1 1.7.2 047D22", b"ok\n", b"an other device of six words\n", b"\n\n"]
)
def test_what_is_no_such_line_is_none(text):
    assert identity_of(text) is None

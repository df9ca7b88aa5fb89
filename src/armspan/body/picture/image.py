"""Bytes of a photograph to upright pixels, and the focal length that its camera wrote into it."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.body.picture.native import stderr_kept
from armspan.errors import DataError, MissingExtra

Pixels: TypeAlias = NDArray[np.uint8]
"""(height, width, 3), red green blue."""

LONGEST_SIDE = 4096
"""Larger pictures are shrunk to this side [px]: a marker 5 m away still has some 90 pixels."""

_SMALLEST_SIDE = 100
_MOST_PIXELS = 250_000_000
_WIDTH_43, _WIDTH_32 = 34.61, 36.0
"""What stands for a picture's longer side on film [mm]: equivalents compare diagonals (43.27 mm), and those of a
4:3 sensor have a longer side of 4/5 of that. Wider pictures are taken for crops of 4:3 but for the 3:2 of film."""
_FOCAL_MM = (10.0, 400.0)
_ORIENTATION, _EXIF_FOLDER, _FOCAL_35MM = 0x0112, 0x8769, 0xA405


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """Upright ``pixels`` (height, width, 3) RGB, and the focal length [px] where its camera told it."""

    pixels: Pixels
    focal_px: float | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.pixels.shape[1], self.pixels.shape[0]


def read_image(data: bytes, where: str) -> Picture:
    """A JPEG, PNG or WebP picture, turned upright as its EXIF says, its longer side at most `LONGEST_SIDE`.

    The focal length comes from EXIF's FocalLengthIn35mmFilm.

    Raises:
        DataError: for what is no such picture, or not all of one; ``where`` names it in the message.
        MissingExtra: without OpenCV.

    """
    kind = _kind(data, where)
    if not _whole(kind, data):
        raise DataError(f"{where} is a {kind} file that is cut off or damaged: copy or upload it again")
    tags = _exif_tags(_exif_block(kind, data))
    pixels = _upright(_decoded(data, kind, where), tags.get(_ORIENTATION, 1))
    height, width = pixels.shape[:2]
    if min(height, width) < _SMALLEST_SIDE:
        size = f"{width} x {height} pixels"
        raise DataError(f"{where} has only {size}: to measure a person take a picture of 1000 pixels height or more")
    pixels = _shrunk(pixels)
    return Picture(pixels, _focal(tags.get(_FOCAL_35MM, 0), pixels.shape[1], pixels.shape[0]))


# --- which file it is, and whether all of it is there -----------------------------------------------------


def _kind(data: bytes, where: str) -> str:
    if not data:
        raise DataError(f"{where} is empty: a JPEG, PNG or WebP picture is expected")
    if data[:2] == b"\xff\xd8":
        return "JPEG"
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return "PNG"
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "WebP"
    raise DataError(f"{where} {_other(data)}")


def _other(data: bytes) -> str:
    if data[4:8] == b"ftyp" and data[8:12] in {b"heic", b"heix", b"hevc", b"heim", b"heis", b"mif1", b"msf1"}:
        return (
            "is a HEIC picture, which cannot be read: save it as JPEG (on an iPhone: Camera, Formats, Most Compatible)"
        )
    if data[4:8] == b"ftyp":
        return "is a video or an AVIF picture: save one picture as JPEG"
    if data[:5] == b"%PDF-":
        return "is a PDF, not a picture: save the photograph itself as JPEG or PNG"
    if data[:4] in {b"GIF8", b"II*\x00", b"MM\x00*"} or data[:2] == b"BM":
        return "is a picture of another kind: save it as JPEG or PNG"
    if _is_text(data[:200]):
        return "is a text file, not a picture: a JPEG, PNG or WebP picture is expected"
    return "is not a picture, or a damaged one: a JPEG, PNG or WebP picture is expected"


def _is_text(start: bytes) -> bool:
    try:
        return start.decode("ascii").replace("\n", "").replace("\r", "").replace("\t", "").isprintable()
    except UnicodeDecodeError:
        return False


def _whole(kind: str, data: bytes) -> bool:
    """Whether the end is there: OpenCV fills what lacks with grey and says nothing."""
    if kind == "JPEG":
        return any(marker == 0xD9 for marker, _ in _jpeg_segments(data))
    if kind == "PNG":
        names = [name for name, _ in _png_chunks(data)]
        return names[:1] == [b"IHDR"] and b"IEND" in names
    return len(data) >= 8 + int.from_bytes(data[4:8], "little")


def _jpeg_segments(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Markers and what they hold; of a scan only its header, and the coded picture after it is passed over."""
    at = 2
    while 0 <= at < len(data) - 1:
        marker = data[at + 1]
        if data[at] != 0xFF or marker == 0xFF:  # fill bytes, and the coded picture
            at = data.find(b"\xff", at + 1)
        elif marker == 0x00 or 0xD0 <= marker <= 0xD7:  # a stuffed byte or a restart, within a scan
            at = data.find(b"\xff", at + 2)
        elif marker == 0xD9:
            yield marker, b""
            return
        else:
            length = int.from_bytes(data[at + 2 : at + 4], "big")
            yield marker, data[at + 4 : at + 2 + length]
            at += 2 + max(length, 2)


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 8
    while at + 12 <= len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        if at + 12 + length <= len(data):
            yield data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        at += 12 + length


def _webp_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 12
    while at + 8 <= len(data):
        length = int.from_bytes(data[at + 4 : at + 8], "little")
        yield data[at : at + 4], data[at + 8 : at + 8 + length]
        at += 8 + length + length % 2


# --- EXIF -------------------------------------------------------------------------------------------------


def _exif_block(kind: str, data: bytes) -> bytes:
    """The TIFF structure within EXIF, empty where there is none."""
    if kind == "JPEG":
        held = (body[6:] for marker, body in _jpeg_segments(data) if marker == 0xE1 and body[:6] == b"Exif\x00\x00")
    elif kind == "PNG":
        held = (body for name, body in _png_chunks(data) if name == b"eXIf")
    else:
        held = (body.removeprefix(b"Exif\x00\x00") for name, body in _webp_chunks(data) if name == b"EXIF")
    return next(held, b"")


def _exif_tags(tiff: bytes) -> dict[int, int]:
    """The whole numbers of the first folder and of its EXIF folder; what is damaged is left out."""
    order = {b"II*\x00": "<", b"MM\x00*": ">"}.get(tiff[:4])
    if order is None or len(tiff) < 8:
        return {}
    tags = _folder(tiff, struct.unpack_from(order + "I", tiff, 4)[0], order)
    return _folder(tiff, tags.get(_EXIF_FOLDER, len(tiff)), order) | tags


def _folder(tiff: bytes, at: int, order: str) -> dict[int, int]:
    """Tags of one folder that hold one SHORT or LONG (TIFF 6.0, section 2)."""
    tags: dict[int, int] = {}
    if at + 2 > len(tiff):
        return tags
    for entry in range(struct.unpack_from(order + "H", tiff, at)[0]):
        start = at + 2 + 12 * entry
        if start + 12 > len(tiff):
            break
        tag, type_, count = struct.unpack_from(order + "HHI", tiff, start)
        if count == 1 and type_ in (3, 4):
            tags[tag] = struct.unpack_from(order + ("H" if type_ == 3 else "I"), tiff, start + 8)[0]
    return tags


def _focal(focal_mm: int, width: int, height: int) -> float | None:
    """Focal length [px] from its equivalent on film [mm], where it is told and likely."""
    if not _FOCAL_MM[0] <= focal_mm <= _FOCAL_MM[1]:
        return None
    return focal_mm * focal_share(width, height)


def focal_share(width: int, height: int) -> float:
    """Focal length [px] of a picture of this size per millimetre of its equivalent on 35 mm film."""
    longer, shorter = max(width, height), min(width, height)
    film = _WIDTH_32 if abs(longer / shorter - 1.5) < 0.02 else _WIDTH_43
    return longer / film


# --- pixels -----------------------------------------------------------------------------------------------


def _decoded(data: bytes, kind: str, where: str) -> Pixels:
    cv2 = opencv()
    pixels_claimed = _claimed_pixels(kind, data)
    if pixels_claimed > _MOST_PIXELS:
        raise DataError(
            f"{where} has {pixels_claimed / 1e6:.0f} million pixels, at most 250 can be read: save it smaller"
        )
    try:
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        with stderr_kept() as said:
            pixels = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
            said.seek(0)
            complaint = said.read()
    except cv2.error:
        pixels = None
    if pixels is None or _guessed(complaint):
        raise DataError(f"{where} is a damaged {kind} file: copy or upload it again, or save it anew as JPEG")
    turned: Pixels = pixels[:, :, ::-1]
    return turned


def _guessed(complaint: bytes) -> bool:
    """Whether libjpeg tells that it guessed a part; it tells of bytes too many as well, which harm nothing."""
    return b"corrupt jpeg data" in complaint.lower() and b"extraneous bytes" not in complaint


def png(pixels: Pixels) -> bytes:
    """A picture as the bytes of a PNG file."""
    _, data = opencv().imencode(".png", np.ascontiguousarray(pixels[:, :, ::-1]))
    return bytes(data.tobytes())


def _claimed_pixels(kind: str, data: bytes) -> int:
    """Pixels that the file's header promises, before any memory is taken for them (WebP's format has a bound)."""
    if kind == "PNG":
        width, height = struct.unpack_from(">II", data, 16)
        return int(width * height)
    if kind == "JPEG":
        for marker, body in _jpeg_segments(data):
            if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC) and len(body) >= 5:
                height, width = struct.unpack_from(">HH", body, 1)
                return int(width * height)
    return 0


def _upright(pixels: Pixels, orientation: int) -> Pixels:
    """Pixels turned as EXIF's orientation 1 to 8 says (EXIF 2.3, table 4); another number leaves them."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.transpose(1, 0, 2)
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    return np.ascontiguousarray(pixels)


def _shrunk(pixels: Pixels) -> Pixels:
    height, width = pixels.shape[:2]
    share = LONGEST_SIDE / max(height, width)
    if share >= 1.0:
        return pixels
    size = max(1, round(width * share)), max(1, round(height * share))
    cv2 = opencv()
    smaller: Pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    return smaller


def opencv() -> Any:
    """The package cv2, of the extra ``picture``."""
    try:
        import cv2
    except ImportError:
        raise MissingExtra("opencv-python-headless", "picture") from None
    return cv2

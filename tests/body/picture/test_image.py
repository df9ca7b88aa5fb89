import struct
import sys
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.body.picture.image import LONGEST_SIDE, focal_share, read_image
from armspan.errors import DataError, MissingExtra

cv2 = pytest.importorskip("cv2", reason="pictures are read by OpenCV (extra 'picture')")


def scene(width=160, height=120):
    """A picture of which every corner has another colour."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[: height // 2, : width // 2] = (200, 30, 30)
    pixels[: height // 2, width // 2 :] = (30, 200, 30)
    pixels[height // 2 :, : width // 2] = (30, 30, 200)
    pixels[height // 2 :, width // 2 :] = (220, 220, 40)
    return pixels


def written(pixels, kind=".jpg", *options):
    return cv2.imencode(kind, np.ascontiguousarray(pixels[..., ::-1]), list(options))[1].tobytes()


def tiff(orientation=None, focal_mm=None, order="<"):
    """EXIF's folders: the orientation in the first, the focal length in the one that it points to."""
    short, long = order + "HHIHxx", order + "HHII"
    entries = [] if orientation is None else [struct.pack(short, 0x0112, 3, 1, orientation)]
    count = len(entries) + 1
    inner = 8 + 2 + 12 * count + 4
    entries.append(struct.pack(long, 0x8769, 4, 1, inner))
    inner_entries = [] if focal_mm is None else [struct.pack(short, 0xA405, 3, 1, focal_mm)]
    head = {"<": b"II*\x00", ">": b"MM\x00*"}[order] + struct.pack(order + "I", 8)
    first = struct.pack(order + "H", count) + b"".join(entries) + bytes(4)
    return head + first + struct.pack(order + "H", len(inner_entries)) + b"".join(inner_entries) + bytes(4)


def with_exif(jpeg, block):
    body = b"Exif\x00\x00" + block
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:]


def test_colours_and_size_are_those_of_the_picture():
    for kind in (".jpg", ".png", ".webp"):
        picture = read_image(written(scene(), kind), "p")
        assert picture.size == (160, 120)
        assert picture.pixels.dtype == np.uint8
        assert picture.focal_px is None
        assert picture.pixels[20, 20] == pytest.approx([200, 30, 30], abs=12)
        assert picture.pixels[100, 140] == pytest.approx([220, 220, 40], abs=12)


# EXIF 2.3, table 4: what the stored picture's row 0 and column 0 are of the upright one, as index rules
STORED = {
    1: lambda up, r, c: up[r, c],
    2: lambda up, r, c: up[r, -1 - c],
    3: lambda up, r, c: up[-1 - r, -1 - c],
    4: lambda up, r, c: up[-1 - r, c],
    5: lambda up, r, c: up[c, r],
    6: lambda up, r, c: up[c, -1 - r],
    7: lambda up, r, c: up[-1 - c, -1 - r],
    8: lambda up, r, c: up[-1 - c, r],
}


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("order", "<>")
def test_every_orientation_comes_out_upright(orientation, order):
    upright = scene()
    turned = orientation >= 5
    rows, columns = np.mgrid[: 160 if turned else 120, : 120 if turned else 160]
    stored = STORED[orientation](upright, rows, columns)
    jpeg = with_exif(written(stored), tiff(orientation, 26, order))
    picture = read_image(jpeg, "p")
    assert picture.size == (160, 120)
    assert np.abs(picture.pixels.astype(int) - upright).mean() < 4
    assert picture.focal_px == pytest.approx(26 * 160 / 34.61)
    opencv = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]  # which turns JPEGs itself
    assert np.array_equal(opencv, picture.pixels)


def test_png_and_webp_carry_exif_too():
    block = tiff(6, 24)
    stored = np.ascontiguousarray(scene().transpose(1, 0, 2)[::-1])  # seen turned by 90 degrees
    png = written(stored, ".png")
    chunk = struct.pack(">I", len(block)) + b"eXIf" + block + struct.pack(">I", zlib.crc32(b"eXIf" + block))
    picture = read_image(png[:33] + chunk + png[33:], "p")
    assert picture.size == (160, 120)
    assert np.array_equal(picture.pixels, scene())
    assert picture.focal_px == pytest.approx(24 * 160 / 34.61)
    webp = written(stored, ".webp", cv2.IMWRITE_WEBP_QUALITY, 101)
    extended = struct.pack("<4sIB3x", b"VP8X", 10, 0x08) + (119).to_bytes(3, "little") + (159).to_bytes(3, "little")
    exif = struct.pack("<4sI", b"EXIF", len(block)) + block + bytes(len(block) % 2)
    body = b"WEBP" + extended + webp[12:] + exif
    picture = read_image(b"RIFF" + struct.pack("<I", len(body)) + body, "p")
    assert np.abs(picture.pixels.astype(int) - scene()).mean() < 2
    assert picture.focal_px == pytest.approx(24 * 160 / 34.61)


def test_the_focal_length_of_phones_whose_sensors_are_known():
    # real focal length / pixel pitch, by the makers' data: iPhone 11 4.25 mm / 1.4 um, iPhone 7 3.99 mm / 1.22 um
    assert 26 * focal_share(4032, 3024) == pytest.approx(4.25 / 1.4e-3, rel=0.015)
    assert 28 * focal_share(3024, 4032) == pytest.approx(3.99 / 1.22e-3, rel=0.015)
    assert 50 * focal_share(6000, 4000) == pytest.approx(50 / 36 * 6000)  # film's own 36 x 24 mm
    assert focal_share(1920, 1080) == focal_share(1920, 1440)  # a crop of 4:3


@pytest.mark.parametrize("focal_mm", [0, 5, 1000])
def test_an_unlikely_focal_length_is_unknown(focal_mm):
    assert read_image(with_exif(written(scene()), tiff(None, focal_mm)), "p").focal_px is None


def test_huge_pictures_are_shrunk_and_the_focal_length_with_them():
    huge = cv2.resize(scene(), (2 * LONGEST_SIDE, LONGEST_SIDE // 2))
    picture = read_image(with_exif(written(huge), tiff(None, 30)), "p")
    assert picture.size == (LONGEST_SIDE, LONGEST_SIDE // 4)
    assert picture.focal_px == pytest.approx(30 * LONGEST_SIDE / 34.61)
    assert picture.pixels[100, 100] == pytest.approx([200, 30, 30], abs=12)


def test_what_phones_append_does_not_matter():
    jpeg = with_exif(written(scene()), tiff(1, 26))
    assert read_image(jpeg + b"SEFT a film of a second" * 20, "p").size == (160, 120)


def test_a_thumbnail_s_end_is_not_the_picture_s():
    jpeg = with_exif(written(scene()), tiff(1) + written(scene()[::4, ::4]))
    assert read_image(jpeg, "p").size == (160, 120)
    with pytest.raises(DataError, match="cut off"):
        read_image(jpeg[:-400], "p")


def test_progressive_and_grey_pictures_are_read():
    assert read_image(written(scene(), ".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, 1), "p").size == (160, 120)
    grey = cv2.imencode(".png", scene()[..., 0])[1].tobytes()
    assert read_image(grey, "p").pixels.shape == (120, 160, 3)
    deep = cv2.imencode(".png", scene().astype(np.uint16) * 256)[1].tobytes()
    assert read_image(deep, "p").pixels.dtype == np.uint8


WRONG = {
    "empty": (b"", "empty"),
    "heic": (b"\x00\x00\x00\x18ftypheic\x00\x00\x00\x00mif1heic" + bytes(50), "HEIC.*save it as JPEG"),
    "video": (b"\x00\x00\x00\x18ftypmp42" + bytes(50), "video"),
    "pdf": (b"%PDF-1.4\n" + bytes(99), "PDF"),
    "gif": (b"GIF89a" + bytes(99), "JPEG or PNG"),
    "text": (b'{"people": []}', "text file"),
    "noise": (bytes(range(128, 256)), "not a picture"),
    "a jpeg's start": (b"\xff\xd8", "cut off"),
    "a png's start": (b"\x89PNG\r\n\x1a\n", "cut off"),
    "a webp's start": (b"RIFF\xff\x00\x00\x00WEBP", "cut off"),
    "no picture in a jpeg": (b"\xff\xd8\xff\xd9", "damaged"),
    "a bomb": (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + struct.pack(">II", 60000, 60000), "cut off"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_picture_is_told_in_one_sentence(name):
    data, words = WRONG[name]
    with pytest.raises(DataError, match=words) as told:
        read_image(data, "front.jpg")
    assert str(told.value).startswith("front.jpg ")
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("kind", [".jpg", ".png", ".webp"])
@pytest.mark.parametrize("share", [0.3, 0.7, 0.98])
def test_a_picture_that_is_cut_off_is_refused(kind, share):
    data = written(np.random.default_rng(0).integers(0, 255, (200, 200, 3), np.uint8), kind)
    with pytest.raises(DataError, match="cut off"):
        read_image(data[: int(share * len(data))], "p")


def test_a_picture_of_too_many_pixels_is_not_even_begun():
    header = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IEND", b"")]
    bomb = b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(b)) + n + b + bytes(4) for n, b in chunks)
    with pytest.raises(DataError, match="3600 million pixels"):
        read_image(bomb, "p")


def test_a_tiny_picture_is_refused():
    with pytest.raises(DataError, match="only 40 x 30 pixels"):
        read_image(written(scene(40, 30)), "p")


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    st.sampled_from([".jpg", ".png", ".webp"]),
    st.lists(st.tuples(st.floats(0, 0.999), st.integers(0, 255)), min_size=1, max_size=6),
)
def test_damaged_bytes_give_a_picture_or_one_sentence(kind, changes):
    data = bytearray(with_exif(written(scene()), tiff(6, 26)) if kind == ".jpg" else written(scene(), kind))
    for where, value in changes:
        data[int(where * min(len(data), 400))] = value
    try:
        picture = read_image(bytes(data), "p")
    except DataError:
        return
    assert picture.pixels.ndim == 3
    assert picture.pixels.shape[2] == 3
    assert picture.focal_px is None or picture.focal_px > 0


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.binary(max_size=80))
def test_any_exif_is_read_or_passed_over(block):
    jpeg = with_exif(written(scene()), b"II*\x00\x08\x00\x00\x00" + block)
    assert min(read_image(jpeg, "p").size) == 120


def test_without_opencv_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(
        MissingExtra, match=r"opencv-python-headless is not installed: pip install 'armspan\[picture\]'"
    ):
        read_image(png_bytes(), "p")


def png_bytes():
    rows = zlib.compress(b"".join(b"\x00" + bytes(300) for _ in range(100)))
    parts = [(b"IHDR", struct.pack(">IIBBBBB", 100, 100, 8, 2, 0, 0, 0)), (b"IDAT", rows), (b"IEND", b"")]
    chunks = (struct.pack(">I", len(b)) + n + b + struct.pack(">I", zlib.crc32(n + b)) for n, b in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def test_a_picture_of_hand_written_bytes_is_black():
    assert not read_image(png_bytes(), "p").pixels.any()


def test_a_jpeg_of_which_part_would_be_guessed_is_refused_and_stray_bytes_are_not(capfd):
    noise = np.random.default_rng(3).integers(0, 255, (200, 200, 3), np.uint8)
    jpeg = written(noise)
    stray = jpeg[:-2] + bytes(9) + jpeg[-2:]
    assert read_image(stray, "p").size == (200, 200)
    half = len(jpeg) // 2
    with pytest.raises(DataError, match="p is a damaged JPEG file"):
        read_image(jpeg[:half] + b"\xff\xd3" + jpeg[half + 2 :], "p")  # a restart in the midst
    assert capfd.readouterr().err == ""


def test_a_png_without_its_header_is_refused():
    with pytest.raises(DataError, match="cut off or damaged"):
        read_image(b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 0) + b"IEND" + bytes(4), "p")

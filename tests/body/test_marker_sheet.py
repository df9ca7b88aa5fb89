import contextlib
import re
import subprocess
import sys
import zlib

import numpy as np
import pytest

from armspan.body.marker_sheet import MARKER_BITS, MARKER_DICTIONARY, MARKER_ID, MARKER_SIDE, marker_pdf, marker_png

POINTS_PER_MM = 72 / 25.4


def paths(pdf, ending):
    """Corners [mm] of the lines (ending S) or filled areas (ending f) on the page."""
    texts = []
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL):
        with contextlib.suppress(zlib.error):
            texts.append(zlib.decompress(stream).decode("latin-1"))
    drawn = re.findall(r"((?:[\d.]+ [\d.]+ [ml]\n)+)h?\n*" + ending + "\n", "\n".join(texts))
    return [np.array(re.findall(r"([\d.]+) ([\d.]+) ", path), float) / POINTS_PER_MM for path in drawn]


def test_the_page_is_an_a4_page_and_the_same_bytes_every_time():
    pdf = marker_pdf()
    assert pdf.startswith(b"%PDF")
    box = re.search(rb"/MediaBox \[ ?([\d. ]+)\]", pdf)
    assert [float(x) / POINTS_PER_MM for x in box[1].split()] == pytest.approx([0, 0, 210, 297], abs=1e-3)
    assert pdf.count(b"/MediaBox") == 1
    assert b"CreationDate" not in pdf
    assert marker_pdf() == pdf


def test_bytes_are_the_same_in_another_process():
    code = "import sys; from armspan.body.marker_sheet import marker_pdf; sys.stdout.buffer.write(marker_pdf())"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, timeout=60)
    assert other.stdout == marker_pdf()


def test_the_black_square_is_170_mm_wide_and_high_in_the_pdf():
    page, square, *others = paths(marker_pdf(), "f")  # the others: white cells, and letters
    assert np.ptp(page, axis=0) == pytest.approx([210, 297], abs=1e-3)
    assert np.ptp(square, axis=0) == pytest.approx([170, 170], abs=1e-3)
    assert pytest.approx(0.170) == MARKER_SIDE
    left, top = square[:, 0].min(), square[:, 1].max()
    white = {(row, column) for row, bits in enumerate(MARKER_BITS) for column, bit in enumerate(bits) if bit == "1"}
    for cell in others[: len(white)]:
        assert np.ptp(cell, axis=0) == pytest.approx([170 / 7] * 2, abs=1e-3)
        white.remove((round((top - cell[:, 1].max()) * 7 / 170), round((cell[:, 0].min() - left) * 7 / 170)))
    assert not white


def test_the_ruler_is_100_mm_long_in_the_pdf():
    lines = [np.ptp(line, axis=0) for line in paths(marker_pdf(), "S")]
    level = [width for width, height in lines if height == 0]
    assert level == pytest.approx([100.0], abs=1e-3)
    assert len(lines) == 1 + 11  # and a tick every 10 mm


def test_the_words_say_what_to_do():
    # in the PDF words are glyphs of an embedded font: they are read where they are drawn
    from armspan.body.marker_sheet import marker_figure

    words = " ".join(text.get_text() for text in marker_figure().axes[0].texts)
    for part in ("100 %", "100 mm", "flat on the floor", "half a metre", "chest height", "3 m"):
        assert part in words


def test_no_plot_state_is_touched():
    code = "import sys; from armspan.body.marker_sheet import marker_pdf; marker_pdf(); sys.exit(any(" + (
        "name in sys.modules for name in ('matplotlib.pyplot', 'cv2')))"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


def test_the_bits_are_those_of_the_dictionary():
    cv2 = pytest.importorskip("cv2", reason="OpenCV (extra 'picture') knows the dictionary")
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, MARKER_DICTIONARY))
    drawn = cv2.aruco.generateImageMarker(dictionary, MARKER_ID, 7)
    assert tuple("".join("1" if bit else "0" for bit in row) for row in drawn) == MARKER_BITS


def test_the_sheet_is_found_where_it_is_printed():
    cv2 = pytest.importorskip("cv2", reason="OpenCV (extra 'picture') finds the marker")
    page = cv2.imdecode(np.frombuffer(marker_png(dpi=254.0), np.uint8), cv2.IMREAD_GRAYSCALE)  # 10 pixels a mm
    assert abs(page.shape[0] - 2970) <= 1
    assert abs(page.shape[1] - 2100) <= 1
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, MARKER_DICTIONARY))
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary).detectMarkers(page)
    assert ids.ravel().tolist() == [MARKER_ID]
    upper_left, upper_right, lower_right, _ = corners[0][0]
    assert upper_left == pytest.approx([200, 200], abs=2)  # upright as printed
    assert (np.linalg.norm(upper_right - upper_left) + 1) / 10 == pytest.approx(170.0, abs=0.11)
    assert (np.linalg.norm(lower_right - upper_right) + 1) / 10 == pytest.approx(170.0, abs=0.11)
    dark = np.flatnonzero(page[400] < 128)  # a row through the black rim
    assert (dark[-1] - dark[0] + 1) / 10 == pytest.approx(170.0, abs=0.11)

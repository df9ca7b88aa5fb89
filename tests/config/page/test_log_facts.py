from pathlib import Path

import pytest

from armspan.config.page.log_facts import looked_into
from armspan.log import read

GOLDEN = Path(__file__).parents[2] / "sessions" / "small.mcap"


def put(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


def test_a_whole_log_is_told_by_its_summary_and_counts_what_is_in_it(tmp_path):
    log = looked_into(put(tmp_path, "2026-11-01_101500_my_room.mcap", GOLDEN.read_bytes()))
    assert (log.began, log.room, log.seconds, log.readable) == ("2026-11-01 10:15:00", "my_room", 23.65, True)
    assert log.counts == read(GOLDEN).counts()
    assert (log.size, log.trouble) == (GOLDEN.stat().st_size, "")


@pytest.mark.parametrize("size", [20_000, 99_999, 100_000, 255_000])
def test_a_cut_log_is_counted_up_to_its_last_whole_record(tmp_path, size):
    path = put(tmp_path, "cut.mcap", GOLDEN.read_bytes()[:size])
    log, whole = looked_into(path), read(path)
    assert "cut off" in log.trouble
    assert (log.counts, log.seconds, log.readable) == (whole.counts(), whole.arrivals[-1], True)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "log.mcap is empty: nothing was recorded in it"),
        (b"hello hello", "log.mcap is not an MCAP file"),
        (GOLDEN.read_bytes()[:60], "log.mcap ends before its header is whole"),
    ],
)
def test_what_is_no_log_says_why_without_its_folder(tmp_path, data, words):
    log = looked_into(put(tmp_path, "log.mcap", data))
    assert log.trouble.startswith(words)
    assert (log.readable, log.counts, log.seconds) == (False, {}, None)

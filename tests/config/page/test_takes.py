import numpy as np
import pytest

from armspan.config.page.takes import TakeFolder
from armspan.config.take_files import COLUMNS, sidecar_of, write_take
from armspan.errors import DataError
from armspan.gesture.takes import Take


@pytest.fixture
def folder(tmp_path):
    """Two takes of stop, the second one spoilt, and one of wave."""
    for label, number, note in (("stop", 1, ""), ("stop", 2, "nothing moved"), ("wave", 1, "")):
        times = np.arange(401) / 100
        values = np.outer(np.sin(times), np.ones(len(COLUMNS)))
        values[5, 3] = np.nan
        take = Take(label, "p01", number, COLUMNS, times, values, practice=bool(note), gesture=(1.0, 3.0))
        write_take(tmp_path / "takes", take, sidecar_of(take, simulated=True, recorded="2026-01-02", note=note))
    return TakeFolder(tmp_path / "takes")


def test_takes_are_listed_with_what_they_are(folder):
    first, second, third = folder.rows()
    assert (first.key, first.label, first.number, first.seconds) == ("stop/p01_01.csv", "stop", 1, 4.0)
    assert (first.recorded, first.simulated, first.counts) == ("2026-01-02", True, True)
    assert (second.note, second.counts) == ("nothing moved", False)
    assert third.key == "wave/p01_01.csv"


def test_a_folder_that_is_not_there_holds_nothing(tmp_path):
    empty = TakeFolder(tmp_path / "takes")
    assert empty.rows() == []
    before = empty.stamp
    (tmp_path / "takes").mkdir()
    assert empty.stamp != before


@pytest.mark.parametrize("text", ["", "t_s,a\n", "t_s,a\n0.0", "a,b\n1,2\n", "t_s,a\n0,1\nx,2\n"])
def test_a_damaged_take_is_listed_and_does_not_count(folder, text):
    (folder.folder / "wave" / "p01_02.csv").write_text(text)
    row = folder.rows()[-1]
    assert (row.key, row.seconds, row.counts) == ("wave/p01_02.csv", None, False)
    assert row.note.startswith("cannot be read")


def test_curves_are_thinned_and_plain(folder):
    curves = folder.curves("stop/p01_01.csv")
    assert len(curves.times) == 300
    assert curves.times[-1] == 4.0
    assert curves.gesture == (1.0, 3.0)
    assert set(curves.columns) == set(COLUMNS)
    assert curves.columns[COLUMNS[0]][-1] == pytest.approx(np.sin(4.0), abs=1e-3)


def test_a_deleted_take_is_kept_aside(folder):
    before = folder.stamp
    kept = folder.delete("stop/p01_02.csv")
    assert kept.is_file()
    assert kept.parent.parent.name == ".deleted"
    assert [row.key for row in folder.rows()] == ["stop/p01_01.csv", "wave/p01_01.csv"]
    assert folder.stamp != before


@pytest.mark.parametrize("key", ["../x/p_01.csv", "/etc/p_01.csv", "stop/../p_01.csv", ".deleted/p_01.csv", "stop", ""])
def test_nothing_outside_of_the_folder_is_a_take(folder, key):
    for ask in (folder.curves, folder.delete):
        with pytest.raises(DataError):
            ask(key)


def test_a_take_that_is_gone_is_told(folder):
    folder.delete("wave/p01_01.csv")
    with pytest.raises(DataError, match="does not exist"):
        folder.delete("wave/p01_01.csv")

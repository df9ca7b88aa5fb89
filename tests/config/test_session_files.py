import pytest

from armspan.config.session_files import fresh_log, make_folder
from armspan.errors import LogError


@pytest.mark.parametrize("name", ["a", "b c"])
def test_logs_are_named_by_room_and_never_replaced(tmp_path, name):
    first = fresh_log(name, tmp_path)
    first.touch()
    assert fresh_log(name, tmp_path) != first
    assert first.name.endswith(f"_{name}.mcap")


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match="cannot be a folder"):
        make_folder(tmp_path / "file")

import sys
from pathlib import Path

import pytest

from armspan.config.pifpaf import predict
from armspan.errors import ConfigError, DataError

STAND_IN = """#!{python}
import json, os, sys
module, picture, checkpoint, written = sys.argv[2], sys.argv[3], sys.argv[5], sys.argv[7]
assert sys.argv[1] == "-m" and sys.argv[4] == "--checkpoint" and sys.argv[6] == "--json-output"
what = open(checkpoint).read()
if what == "fails":
    sys.exit("boom\\nCUDA is not available")
if what == "answers":
    answer = [module, open(picture).read(), os.environ["TORCH_FORCE_NO_WEIGHTS_ONLY_LOAD"]]
    json.dump(answer, open(written, "w"))
"""


@pytest.fixture
def stand_in(tmp_path):
    """An interpreter that answers in openpifpaf's place as its checkpoint tells it to."""
    python = tmp_path / "python"
    python.write_text(STAND_IN.format(python=sys.executable))
    python.chmod(0o755)
    return python


def ask(stand_in, what):
    checkpoint = stand_in.parent / "net.pkl"
    checkpoint.write_text(what)
    return predict(stand_in.parent / "me.jpg", b"upright", checkpoint=checkpoint, python=stand_in)


def test_the_answer_of_the_other_process(stand_in):
    assert ask(stand_in, "answers") == ["openpifpaf.predict", "upright", "1"]


def test_a_failure_is_told_by_its_last_line(stand_in):
    with pytest.raises(DataError, match="CUDA is not available") as caught:
        ask(stand_in, "fails")
    assert "boom" not in str(caught.value)


def test_no_answer(stand_in):
    with pytest.raises(DataError, match="without a JSON"):
        ask(stand_in, "is silent")


def test_this_environment_does_not_hold_it(tmp_path):
    (tmp_path / "net.pkl").write_bytes(b"")
    with pytest.raises(DataError, match="openpifpaf"):
        predict(tmp_path / "me.jpg", b"", checkpoint=tmp_path / "net.pkl", python=Path(sys.executable))


def test_files_that_are_not_there(tmp_path, stand_in):
    with pytest.raises(ConfigError, match="--checkpoint"):
        predict(tmp_path / "me.jpg", b"", checkpoint=tmp_path / "none.pkl", python=stand_in)
    (tmp_path / "net.pkl").write_text("answers")
    with pytest.raises(ConfigError, match="--python"):
        predict(tmp_path / "me.jpg", b"", checkpoint=tmp_path / "net.pkl", python=tmp_path / "nothing")

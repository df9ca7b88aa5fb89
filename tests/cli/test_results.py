import subprocess
import sys

from armspan.cli.results import WIDE, Results


def test_a_file_is_as_wide_as_its_tables(capsys):
    Results().print("-" * (WIDE - 1))
    assert capsys.readouterr().out.splitlines() == ["-" * (WIDE - 1)]


def test_a_reader_that_has_seen_enough_is_no_error():
    command = [sys.executable, "-m", "armspan", "body", "--height-m", "1.72"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
        process.wait(timeout=60)
    assert process.returncode == 0

import importlib.metadata
import json
import platform

from armspan.cli import check
from command_line import code_of

BASE = {
    "numpy",
    "scipy",
    "scikit-learn",
    "vqf",
    "msgspec",
    "mcap",
    "shapely",
    "rich",
    "matplotlib",
    "OneEuroFilter",
    "nicegui",
    "segno",
}


def test_json_lists_every_package_with_its_version(capsys):
    assert code_of("check", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["python"] == platform.python_version()
    base = {row["package"]: row for row in document["packages"] if row["extra"] is None}
    assert base.keys() == BASE
    for name, row in base.items():
        assert row["version"] == importlib.metadata.version(name)
        assert row["get"] is None


def without(monkeypatch, *gone):
    def version(name):
        if name in gone:
            raise importlib.metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(check.importlib.metadata, "version", version)


def test_a_missing_extra_is_told_with_how_to_get_it(monkeypatch, capsys):
    without(monkeypatch, "hypothesis")
    assert code_of("check", "--json") == 0
    rows = json.loads(capsys.readouterr().out)["packages"]
    [row] = [row for row in rows if row["version"] is None]
    assert (row["package"], row["extra"], row["get"]) == ("hypothesis", "test", "pip install 'armspan[test]'")


def test_a_missing_base_package_is_a_difference(monkeypatch, capsys):
    without(monkeypatch, "vqf")
    assert code_of("check") == 1
    out = capsys.readouterr().out
    assert platform.python_version() in out
    assert "missing" in out
    assert "pip install armspan" in out


def test_installed_reads_extras_from_the_packages_own_words(monkeypatch):
    words = ["numpy>=1.26", "bleak >=0.22 ; extra == 'ble'", 'torch; python_version < "3.14" and extra == "cnn"']
    monkeypatch.setattr(check.importlib.metadata, "requires", lambda name: words)
    without(monkeypatch, "bleak", "torch")
    assert [(row["package"], row["extra"], row["get"]) for row in check.installed()] == [
        ("numpy", None, None),
        ("bleak", "ble", "pip install 'armspan[ble]'"),
        ("torch", "cnn", "pip install 'armspan[cnn]'"),
    ]

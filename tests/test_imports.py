import json

from command_line import fresh

OPTIONAL = [
    "bleak",
    "bumble",
    "aiohttp",
    "cryptography",
    "segno",
    "torch",
    "cv2",
    "ai_edge_litert",
    "cyclonedds",
    "rclpy",
    "zenoh",
    "pylsl",
    "nicegui",
]

EVERYTHING = """
import importlib, json, pkgutil, sys, armspan
names = [found.name for found in pkgutil.walk_packages(armspan.__path__, "armspan.")]
names.remove("armspan.__main__")  # it is the program itself: importing it runs it
page = {name for name in names if name.startswith(("armspan.web", "armspan.config.page"))}
names = [name for name in names if name not in page]  # what is behind the page is loaded when it is opened
for name in ["armspan.cli", *names]:
    importlib.import_module(name)
print(json.dumps([names, sorted(sys.modules)]))
"""


def test_no_module_loads_an_optional_package():
    process = fresh("-W", "error", "-c", EVERYTHING)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    names, loaded = json.loads(out)
    assert {"armspan.cli.demo", "armspan.devices.replay", "armspan.simulation.robots", "armspan.log.tables"} < set(
        names
    )
    assert set(names) <= set(loaded)
    assert [name for name in OPTIONAL if name in loaded] == []


def test_the_program_runs_as_a_module():
    process = fresh("-m", "armspan", "--version")
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert out.startswith("armspan ")

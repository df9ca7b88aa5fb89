"""Those who look at the page, as a process of its own: prints one JSON line a second for each of them.

``lines``: connections that acknowledge every frame at once and draw nothing. ``tabs``: tabs of a headless Chromium
that draw the page; frames received and drawn are counted by the page itself. Runs until it is ended.
"""

import argparse
import asyncio
import json
import shutil
import signal
import time

from websockets.asyncio.client import connect

FLAGS = ("--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--no-first-run")


def tell(received: int, drawn: int, size: int, seconds: float) -> None:
    """Frames received and drawn and bytes received, a second."""
    print(json.dumps([received / seconds, drawn / seconds, size / seconds]), flush=True)


async def follow(address: str) -> None:
    """One connection."""
    async with connect(address.replace("http", "ws", 1) + "live") as line:
        frames, size, began = 0, 0, time.monotonic()
        async for message in line:
            frames, size = frames + 1, size + len(message)
            await line.send("k")
            if time.monotonic() - began >= 1:
                tell(frames, frames, size, time.monotonic() - began)
                frames, size, began = 0, 0, time.monotonic()


def browse(address: str, paths: list[str]) -> None:
    """One tab for each path."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = shutil.which("chromium") or shutil.which("google-chrome")
        browsers = [driver.chromium.launch(executable_path=chromium, args=list(FLAGS)) for _ in paths]
        tabs = [browser.new_page(viewport={"width": 1024, "height": 768}) for browser in browsers]
        for tab, path in zip(tabs, paths, strict=True):
            tab.goto(address + path)
            tab.wait_for_function("globalThis.armspanLine?.drawn > 0")
        before = [(time.monotonic(), tab.evaluate("({...armspanLine})")) for tab in tabs]
        while True:
            time.sleep(1)
            for k, tab in enumerate(tabs):
                (then, old), now, new = before[k], time.monotonic(), tab.evaluate("({...armspanLine})")
                tell(*(new[what] - old[what] for what in ("frames", "drawn", "bytes")), now - then)
                before[k] = (now, new)


async def lines(address: str, count: int) -> None:
    """So many connections."""
    async with asyncio.TaskGroup() as group:
        for _ in range(count):
            group.create_task(follow(address))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("lines", "tabs"))
    parser.add_argument("address")
    parser.add_argument("what", nargs="+", help="how many lines, or each tab's view: table, all, flat")
    args = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        if args.kind == "lines":
            asyncio.run(lines(args.address, int(args.what[0])))
        else:
            browse(args.address, ["" if path == "table" else path for path in args.what])
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()

"""A page that is really served: ``armspan run`` in a process of its own."""

import os
import signal
import subprocess
import sys
from pathlib import Path


class Served:
    """A page that runs: its address, and the folder it works in."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder = folder
        with (folder / "stderr.txt").open("w") as talk:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "armspan", "run", "--port", "0", "--no-browser", *words],
                cwd=folder,
                env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=talk,
                text=True,
            )
        self.address = self.process.stdout.readline().strip()
        if not self.address.startswith("http"):
            self.close()
            raise AssertionError((folder / "stderr.txt").read_text())

    def close(self) -> int:
        """Ctrl-C; the exit code."""
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(timeout=20)
        finally:
            self.process.kill()
            self.process.stdout.close()
        return self.process.returncode

"""OpenPifPaf, run as a separate process in an environment that the user names; Armspan itself does not hold it."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

from armspan.errors import ConfigError, DataError

_PATIENCE = 600.0


def predict(picture: Path, png: bytes, *, checkpoint: Path, python: Path) -> object:
    """The decoded JSON of ``python -m openpifpaf.predict`` on one picture, which the file ``picture`` holds.

    It reads ``png``, the same turned upright, as it heeds no EXIF: from a folder that is deleted at once.
    The checkpoint is a pickle: torch runs what stands in it, so it must come from someone who is trusted.

    Raises:
        ConfigError: if the checkpoint or the interpreter is not there.
        DataError: if the process fails, is too slow or writes no JSON.

    """
    _check(checkpoint, python)
    with tempfile.TemporaryDirectory(prefix="armspan-") as folder:
        upright, written = Path(folder) / "picture.png", Path(folder) / "predictions.json"
        upright.write_bytes(png)
        command = [str(python.absolute()), "-m", "openpifpaf.predict", str(upright), "--checkpoint", str(checkpoint)]
        _run([*command, "--json-output", str(written)], picture)
        try:
            return json.loads(written.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise DataError(
                f"openpifpaf ended without a JSON for {picture}: run `{' '.join(command[:3])} ...` by hand to see why"
            ) from None


def _check(checkpoint: Path, python: Path) -> None:
    if not checkpoint.is_file():
        raise ConfigError(f"{checkpoint} does not exist: name the checkpoint of openpifpaf's network with --checkpoint")
    if not python.is_file():
        raise ConfigError(
            f"{python} does not exist: name with --python the interpreter of an environment that holds openpifpaf"
        )


def _run(command: list[str], picture: Path) -> None:
    """Run it; the variable lets recent versions of torch load a checkpoint that is a pickle, in this process only."""
    environment = {**os.environ, "TORCH_FORCE_NO_WEIGHTS_ONLY_LOAD": "1"}
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE, env=environment, check=False)
    except subprocess.TimeoutExpired:
        raise DataError(
            f"openpifpaf was not done with {picture} after {_PATIENCE / 60:.0f} minutes: try a smaller picture"
        ) from None
    except OSError as error:
        raise ConfigError(f"{command[0]} cannot be run: {error.strerror}") from None
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
        raise DataError(
            f"openpifpaf failed on {picture}: {last[:300]}; name with --python an environment in which "
            "`python -m openpifpaf.predict` works"
        )

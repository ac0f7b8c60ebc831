"""A folder of machine code of kernels, which processes share. A file that is damaged is as good as none."""

import contextlib
import hashlib
import json
import os
import tempfile
from pathlib import Path

from gen_art.backend.machine_code import MachineCode

__all__ = ["LIMIT", "KernelStore"]

LIMIT = 1 << 28  # bytes; all that the tests run, with most shipped presets, takes a tenth of it


class KernelStore:
    """The machine code in a folder, by key. What cannot be written is not kept."""

    def __init__(self, folder: Path):
        self._folder = folder

    def _file(self, key: str) -> Path:
        return self._folder / f"{key}.kernel"

    def find(self, key: str) -> MachineCode | None:
        """What was kept under the key, or None."""
        file = self._file(key)
        try:
            head, _, image = file.read_bytes().partition(b"\n")
            about = json.loads(head)
            if about["digest"] != hashlib.sha256(image).hexdigest():
                return None
            os.utime(file)  # so that `tidy` knows what is in use
            return MachineCode(tuple(about["tasks"]), image)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def keep(self, key: str, code: MachineCode) -> None:
        """Keep the machine code. Another process sees the whole file or none."""
        about = {"tasks": code.tasks, "digest": hashlib.sha256(code.image).hexdigest()}
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self._folder, suffix=".part", delete=False) as part:
                part.write(json.dumps(about).encode() + b"\n" + code.image)
            os.replace(part.name, self._file(key))

    def tidy(self) -> None:
        """Delete what was not used for longest, down to half of LIMIT, where there is more than LIMIT."""
        with contextlib.suppress(OSError):
            files = [(file.stat().st_mtime, file.stat().st_size, file) for file in self._folder.iterdir()]
            total = sum(size for _, size, _ in files)
            for _, size, file in sorted(files) if total > LIMIT else ():
                file.unlink(missing_ok=True)
                total -= size
                if total <= LIMIT // 2:
                    break

"""A folder of files that processes share, within the cache folder. A file that is damaged is as good as none."""

import contextlib
import hashlib
import os
import tempfile
from pathlib import Path

__all__ = ["LIMIT", "KeptFiles"]

LIMIT = 1 << 28  # bytes of a folder; the machine code of most shipped presets takes a tenth of it


class KeptFiles:
    """The contents of files in a folder, by key. What cannot be written is not kept."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._has_written = False

    def _file(self, key: str) -> Path:
        return self._folder / f"{key}.kept"

    def read(self, key: str) -> bytes | None:
        """What was kept under the key, or None."""
        file = self._file(key)
        try:
            digest, _, content = file.read_bytes().partition(b"\n")
            if digest.decode("ascii", "replace") != hashlib.sha256(content).hexdigest():
                return None
            os.utime(file)  # so that `tidy` knows what is in use
            return content
        except OSError:
            return None

    def write(self, key: str, content: bytes) -> None:
        """Keep this under the key. Another process sees the whole file or none."""
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self._folder, suffix=".part", delete=False) as part:
                part.write(hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
            os.replace(part.name, self._file(key))
            self._has_written = True

    def tidy(self) -> None:
        """Delete what was not used for longest, down to half of LIMIT, where there is more than LIMIT.

        Only a process that has written looks: reading the sizes of thousands of files takes a tenth of a second.
        """
        if not self._has_written:
            return
        with contextlib.suppress(OSError), os.scandir(self._folder) as entries:
            files = [(entry.stat().st_mtime, entry.stat().st_size, entry.path) for entry in entries]
            total = sum(size for _, size, _ in files)
            for _, size, path in sorted(files) if total > LIMIT else ():
                Path(path).unlink(missing_ok=True)
                total -= size
                if total <= LIMIT // 2:
                    break

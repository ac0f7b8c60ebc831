"""Machine code of kernels, kept in the cache folder from one process to the next."""

import json

from gen_art.backend.kept_files import KeptFiles
from gen_art.backend.machine_code import MachineCode

__all__ = ["KernelStore"]


class KernelStore(KeptFiles):
    """The machine code of kernels in a folder, by key."""

    def find(self, key: str) -> MachineCode | None:
        """What was kept under the key, or None."""
        tasks, newline, image = (self.read(key) or b"").partition(b"\n")
        return MachineCode(tuple(json.loads(tasks)), image) if newline else None

    def keep(self, key: str, code: MachineCode) -> None:
        """Keep the machine code."""
        self.write(key, json.dumps(code.tasks).encode() + b"\n" + code.image)

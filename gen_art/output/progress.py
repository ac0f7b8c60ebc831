"""Progress events of a render job."""

import time
from collections.abc import Callable

__all__ = ["Report"]


class Report:
    """Sends progress events with the frame rate so far and the estimated time left.

    tell : function that is called with each event, or None
    frames : number of frames of the job
    """

    def __init__(self, tell: Callable[[dict], None] | None, frames: int):
        self.tell, self._frames, self._done, self._start = tell, frames, 0, time.perf_counter()

    def __call__(self, frame: int, particles: int) -> None:
        self._done += 1
        if self.tell is None:
            return
        rate = self._done / max(time.perf_counter() - self._start, 1e-9)
        self.tell(
            {
                "event": "frame",
                "frame": self._done - 1,
                "number": int(frame),
                "frames": self._frames,
                "particles": particles,
                "fps": rate,
                "eta": (self._frames - self._done) / rate,
            }
        )

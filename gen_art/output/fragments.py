"""Splits an encoded film into head and body, so that several can be appended to one file that plays.

MP4 and MOV: `moof` and `mdat` boxes follow each other after one `ftyp` and an empty `moov` (ISO 14496-12, movie
fragments). Matroska and WebM: clusters follow each other in a segment of unknown size (RFC 8794, RFC 9559).
"""

__all__ = ["skipping_header", "split"]

_EBML, _SEGMENT, _INFO, _TRACKS, _TAGS, _CLUSTER = (
    bytes.fromhex(name) for name in ("1A45DFA3", "18538067", "1549A966", "1654AE6B", "1254C367", "1F43B675")
)
_UNKNOWN_SIZE = b"\x01" + b"\xff" * 7
_DURATION, _VOID = bytes.fromhex("448988"), bytes.fromhex("EC89") + bytes(9)


def split(data: bytes, muxer: str) -> tuple[bytes, bytes]:
    """(head, body) of a film's bytes. A file is the head of the first film, then the bodies of all."""
    return _split_boxes(data) if muxer in ("mp4", "mov") else _split_elements(data)


def skipping_header(size: int, muxer: str) -> bytes:
    """The first bytes of a body of `size` bytes while it is being written: they make readers skip all of it.

    A `free` box, whose size 0 means up to the end of the file, or a Void element.
    """
    if muxer in ("mp4", "mov"):
        return (size if size < 2**32 else 0).to_bytes(4, "big") + b"free"
    return b"\xec\x01" + (size - 9).to_bytes(7, "big")


def _split_boxes(data: bytes) -> tuple[bytes, bytes]:
    head, body, at = [], [], 0
    while at < len(data):
        size, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        if size == 1:
            size = int.from_bytes(data[at + 8 : at + 16], "big")
        if kind in (b"moof", b"mdat"):
            body.append(data[at : at + size])
        elif kind in (b"ftyp", b"moov"):
            head.append(data[at : at + size])
        at += size
    return b"".join(head), b"".join(body)


def _split_elements(data: bytes) -> tuple[bytes, bytes]:
    head, body, at = [], [], 0
    while at < len(data):
        name, start, end = _element(data, at)
        if name == _SEGMENT:
            head.append(name + _UNKNOWN_SIZE)
            at = start
            continue
        element = data[at:end]
        if name == _CLUSTER:
            body.append(element)
        elif name == _INFO:  # without the duration, which is that of the first part alone
            duration = _DURATION + element[element.find(_DURATION) + 3 :][:8]
            head.append(element.replace(duration, _VOID, 1))
        elif name in (_EBML, _TRACKS, _TAGS):
            head.append(element)
        at = end
    return b"".join(head), b"".join(body)


def _element(data: bytes, at: int) -> tuple[bytes, int, int]:
    """Name, start of the content and end of the EBML element at `at`. The leading zero bits of a number give its length."""
    name = data[at : at + 9 - data[at].bit_length()]
    at += len(name)
    length = 9 - data[at].bit_length()
    size = int.from_bytes(data[at : at + length], "big") & ((1 << 7 * length) - 1)
    return name, at + length, at + length + size

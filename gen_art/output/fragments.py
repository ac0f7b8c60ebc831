"""A small film as bytes, taken apart so that films can be written one after another into one file that plays.

MP4 and MOV: `moof` and `mdat` boxes follow each other after one `ftyp` and an empty `moov` (ISO 14496-12, movie
fragments). Matroska and WebM: clusters follow each other in a segment of unknown size (RFC 8794, RFC 9559).
"""

__all__ = ["split"]

_EBML, _SEGMENT, _INFO, _TRACKS, _TAGS, _CLUSTER = (
    bytes.fromhex(name) for name in ("1A45DFA3", "18538067", "1549A966", "1654AE6B", "1254C367", "1F43B675")
)
_UNKNOWN = b"\x01" + b"\xff" * 7
_DURATION, _VOID = bytes.fromhex("448988"), bytes.fromhex("EC89") + bytes(9)


def split(data: bytes, muxer: str) -> tuple[bytes, bytes]:
    """(head, body): the head is written once, the bodies of all films after it."""
    return _split_boxes(data) if muxer in ("mp4", "mov") else _split_elements(data)


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
            head.append(name + _UNKNOWN)
            at = start
            continue
        whole = data[at:end]
        if name == _CLUSTER:
            body.append(whole)
        elif name == _INFO:
            head.append(
                whole.replace(_DURATION + whole[whole.find(_DURATION) + 3 :][:8], _VOID, 1)
            )  # of this part only
        elif name in (_EBML, _TRACKS, _TAGS):
            head.append(whole)
        at = end
    return b"".join(head), b"".join(body)


def _element(data: bytes, at: int) -> tuple[bytes, int, int]:
    """Name, start of the content and end of the element at `at`: both numbers begin with their own length in bits."""
    name = data[at : at + 9 - data[at].bit_length()]
    at += len(name)
    length = 9 - data[at].bit_length()
    size = int.from_bytes(data[at : at + length], "big") & ((1 << 7 * length) - 1)
    return name, at + length, at + length + size

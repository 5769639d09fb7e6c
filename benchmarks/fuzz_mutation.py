"""Mutations that keep checksums right: else nearly every one would end at the first of them."""

import struct
import zlib
from collections.abc import Callable

Mutate = Callable[[bytes, int], bytes]
"""The fuzzer's own: another content of at most so many bytes."""
Mutator = Callable[[bytes, int, int], bytes]
"""The same, with a seed that decides what is decided here."""

_PNG = b"\x89PNG\r\n\x1a\n"
_ZIP, _ZIP_MEMBER, _ZIP_END = b"PK\x03\x04", b"PK\x01\x02", b"PK\x05\x06"


def mutator(mutate: Mutate) -> Mutator:
    """The fuzzer's mutations with the checksums that belong to them; one in eight is left as it is."""

    def change(content: bytes, most: int, seed: int) -> bytes:
        changed = mutate(content, most)
        return changed if seed % 8 == 0 else with_right_checksums(changed)

    return change


def with_right_checksums(content: bytes) -> bytes:
    """A PNG, or a zip archive whose files are stored as they are, with checksums that fit; other files unchanged."""
    if content.startswith(_PNG):
        return _png(content)
    return _zip(content) if content.startswith(_ZIP) else content


def _png(content: bytes) -> bytes:
    """As far as chunks follow each other."""
    parts, start = [_PNG], len(_PNG)
    while len(content) - start >= 12:
        end = start + 8 + struct.unpack_from(">I", content, start)[0]
        if end + 4 > len(content):
            break
        parts += [content[start:end], struct.pack(">I", zlib.crc32(content[start + 4 : end]))]
        start = end + 4
    return b"".join([*parts, content[start:]])


def _zip(content: bytes) -> bytes:
    """As far as the directory at the end lists files where there are some (APPNOTE.TXT, sections 4.3.7 and 4.3.12)."""
    archive = bytearray(content)
    end = archive.rfind(_ZIP_END)
    if end < 0 or end + 22 > len(archive):
        return content
    count, _, place = struct.unpack_from("<HII", archive, end + 10)
    for _ in range(count):
        if archive[place : place + 4] != _ZIP_MEMBER or place + 46 > len(archive):
            break
        size, _, *lengths = struct.unpack_from("<IIHHH", archive, place + 20)
        (start,) = struct.unpack_from("<I", archive, place + 42)
        if archive[start : start + 4] == _ZIP and start + 30 <= len(archive):
            begin = start + 30 + sum(struct.unpack_from("<HH", archive, start + 26))
            checksum = zlib.crc32(archive[begin : begin + size])
            struct.pack_into("<I", archive, start + 14, checksum)
            struct.pack_into("<I", archive, place + 16, checksum)
        place += 46 + sum(lengths)
    return bytes(archive)

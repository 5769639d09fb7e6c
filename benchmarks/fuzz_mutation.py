"""Mutations that keep checksums right: else nearly every one would end at the first of them."""

import io
import struct
import zipfile
import zlib
from collections.abc import Callable

from benchmarks.fuzz_targets import Name

Mutate = Callable[[bytes, int], bytes]
"""The fuzzer's own: another content of at most so many bytes."""
Mutator = Callable[[bytes, int, int], bytes]
"""The same, with a seed that decides what is decided here."""

_PNG = b"\x89PNG\r\n\x1a\n"


def mutator_of(name: Name, mutate: Mutate) -> Mutator:
    """How the files of a target are changed. Some of their checksums stay wrong."""

    def picture(content: bytes, most: int, seed: int) -> bytes:
        changed = mutate(content, most)
        return changed if seed % 8 == 0 else with_right_checksums(changed)

    def probe(content: bytes, most: int, seed: int) -> bytes:
        members = members_of(content)
        if seed % 4 == 0 or not members:
            return mutate(content, most)
        chosen = sorted(members)[seed // 4 % len(members)]
        changed = archive_of({**members, chosen: mutate(members[chosen], most)})
        return changed if len(changed) <= most else content

    def plain(content: bytes, most: int, _: int) -> bytes:
        return mutate(content, most)

    return {"pictures": picture, "probes": probe}.get(name, plain)


def with_right_checksums(content: bytes) -> bytes:
    """A PNG whose chunks' checksums fit their contents, as far as chunks follow each other; other files as they are."""
    if not content.startswith(_PNG):
        return content
    parts, start = [_PNG], len(_PNG)
    while len(content) - start >= 12:
        end = start + 8 + struct.unpack_from(">I", content, start)[0]
        if end + 4 > len(content):
            break
        parts += [content[start:end], struct.pack(">I", zlib.crc32(content[start + 4 : end]))]
        start = end + 4
    return b"".join([*parts, content[start:]])


def members_of(archive: bytes) -> dict[str, bytes]:
    """The files in a zip archive; none where it is no whole one."""
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as file:
            return {member.filename: file.read(member) for member in file.infolist() if member.file_size < 2**16}
    except Exception:  # whatever Python's reader stumbles over: the archive is anything at all
        return {}


def archive_of(members: dict[str, bytes]) -> bytes:
    """An archive of these files."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as file:
        for name, content in members.items():
            file.writestr(name, content)
    return buffer.getvalue()

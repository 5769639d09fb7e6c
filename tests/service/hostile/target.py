"""What hostile tests attack."""

import socket
from typing import NamedTuple
from urllib.parse import urlsplit

import httpx

IMAGE_PART = b'--x\r\nContent-Disposition: form-data; name="image"; filename="a"\r\n\r\n'


class Target(NamedTuple):
    """A service, and the process that it is."""

    client: httpx.Client
    pid: int

    def connect(self) -> socket.socket:
        address = urlsplit(str(self.client.base_url))
        return socket.create_connection((str(address.hostname), address.port or 0), timeout=20)

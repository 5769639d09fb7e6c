"""compose.yaml: its proxy, a real nginx, before two real services; and its words, by what they mean to the service."""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest
import yaml

from service.settings import Settings
from tests.service.test_stopping import accepts, process, until_ready

COMPOSE: dict[str, Any] = yaml.safe_load((Path(__file__).parents[2] / "compose.yaml").read_text())
SERVICE, PROXY = COMPOSE["services"]["chiaro"], COMPOSE["services"]["proxy"]
NGINX = """
{user}
pid {folder}/nginx.pid;
error_log {folder}/error.log;
daemon off;
worker_processes 1;
events {{}}
http {{
  access_log off;
  client_body_temp_path {folder}/bodies;
  proxy_temp_path {folder}/proxied;
  fastcgi_temp_path {folder}/fastcgi;
  scgi_temp_path {folder}/scgi;
  uwsgi_temp_path {folder}/uwsgi;
{content}
}}
"""


@pytest.fixture
def replicas(bundle_directory: Path) -> Iterator[list[tuple[subprocess.Popen[str], str]]]:
    with ExitStack() as stack:
        started = [stack.enter_context(process(bundle_directory)) for _ in range(SERVICE["deploy"]["replicas"])]
        for _, address in started:
            until_ready(address)
        yield started


@pytest.fixture
def proxy(replicas: list[tuple[subprocess.Popen[str], str]], tmp_path: Path) -> Iterator[httpx.Client]:
    """A client of nginx as compose.yaml configures it, but for the addresses."""
    nginx = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
    if nginx is None:
        pytest.skip("no nginx; install it (Debian: apt-get install nginx-light) to have the proxy tested")
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    content = COMPOSE["configs"]["proxy"]["content"].replace("$$", "$")
    servers = "\n".join(f"server {urlsplit(address).netloc} max_fails=0;" for _, address in replicas)
    for theirs, ours in (("server chiaro:8000 max_fails=0;", servers), ("listen 8080", f"listen 127.0.0.1:{port}")):
        assert content.count(theirs) == 1
        content = content.replace(theirs, ours)
    # It would put its workers under another user, who may not write into this folder.
    user = "user root;" if os.geteuid() == 0 else ""
    (tmp_path / "nginx.conf").write_text(NGINX.format(folder=tmp_path, content=content, user=user))
    command = [nginx, "-p", str(tmp_path), "-e", str(tmp_path / "error.log"), "-c", str(tmp_path / "nginx.conf")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as running:
        try:
            deadline = time.monotonic() + 20
            while not accepts("127.0.0.1", port) and running.poll() is None:
                assert time.monotonic() < deadline
                time.sleep(0.02)
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=20) as client:
                until_ready(str(client.base_url).rstrip("/"))
                yield client
        finally:
            running.terminate()
            _, errors = running.communicate(timeout=20)
    assert errors == ""


def test_both_replicas_answer_and_one_alone_when_the_other_is_gone(
    proxy: httpx.Client, replicas: list[tuple[subprocess.Popen[str], str]], picture: bytes
) -> None:
    def ask(count: int) -> None:
        for _ in range(count):
            answer = proxy.post("/v1/reconstruct", files={"image": picture})
            assert answer.status_code == 200
            assert answer.content.startswith(b"glTF")

    def answered(address: str) -> bool:
        return 'route="/reconstruct",status="200"' in httpx.get(f"{address}/metrics").text

    ask(8)
    assert [answered(address) for _, address in replicas] == [True, True]
    replicas[0][0].terminate()
    replicas[0][0].wait(20)
    ask(8)


def test_what_the_service_refuses_is_said_by_the_service(proxy: httpx.Client) -> None:
    """The proxy's own limit is above the service's, and its errors are no problem+json."""
    limit = Settings.model_fields["max_upload_bytes"].default
    answer = proxy.post("/v1/reconstruct", files={"image": bytes(limit + 1)})
    assert (answer.status_code, answer.headers["content-type"]) == (413, "application/problem+json")


def test_variables_are_settings() -> None:
    assert {name.removeprefix("CHIARO_").lower() for name in SERVICE["environment"]} <= set(Settings.model_fields)


def test_a_replica_may_finish_what_it_began_before_it_is_stopped() -> None:
    assert float(SERVICE["stop_grace_period"].removesuffix("s")) > Settings.model_fields["deadline"].default


def test_nothing_can_be_written_and_no_rights_be_gained() -> None:
    for part in (SERVICE, PROXY):
        assert part["read_only"] is True
        assert part["cap_drop"] == ["ALL"]
        assert part["security_opt"] == ["no-new-privileges:true"]
    assert SERVICE["volumes"] == ["./models:/models:ro"]

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from redis import Redis
from redis.exceptions import ConnectionError as RedisConnectionError

from worker.embedded_redis import EmbeddedRedis, socket_path
from worker.errors import QueueUnavailableError

HOLDER = """
import sys, time
from pathlib import Path
from worker.embedded_redis import EmbeddedRedis
with EmbeddedRedis(Path(sys.argv[1])):
    print("ready", flush=True)
    time.sleep(600)
"""


def client(state: Path) -> Redis:
    return Redis(unix_socket_path=str(socket_path(state)))


def test_it_is_private_and_keeps_its_data(state: Path) -> None:
    with EmbeddedRedis(state) as server:
        connection = client(state)
        connection.set("surface", "rough")
        assert connection.config_get("port")["port"] == "0"
        assert server.socket.stat().st_mode & 0o777 == 0o600
        assert server.socket.parent.stat().st_mode & 0o777 == 0o700
    with pytest.raises(RedisConnectionError):
        client(state).ping()
    with EmbeddedRedis(state):
        assert client(state).get("surface") == b"rough"


def test_a_second_instance_is_refused_and_does_not_harm_the_first(state: Path) -> None:
    with EmbeddedRedis(state):
        with pytest.raises(QueueUnavailableError, match="Another Asperity"), EmbeddedRedis(state):
            pass
        assert client(state).ping()


def test_a_path_too_long_for_a_socket_is_refused(state: Path) -> None:
    with pytest.raises(QueueUnavailableError, match="ASPERITY_STATE_DIR"), EmbeddedRedis(state / ("x" * 100)):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux kills children with their parent")
def test_it_dies_with_its_launcher(state: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", HOLDER, str(state)], stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"ready\n"
        assert client(state).ping()
        os.kill(holder.pid, signal.SIGKILL)
    deadline = time.monotonic() + 10
    while True:
        try:
            client(state).ping()
        except RedisConnectionError:
            break
        assert time.monotonic() < deadline
        time.sleep(0.05)
    with EmbeddedRedis(state):
        assert client(state).ping()


def test_it_is_started_again_with_all_that_it_knew(state: Path) -> None:
    with EmbeddedRedis(state):
        connection = client(state)
        connection.set("surface", "rough")
        os.kill(connection.info("server")["process_id"], signal.SIGKILL)
        deadline = time.monotonic() + 10
        while True:
            try:
                assert client(state).get("surface") == b"rough"
                break
            except RedisConnectionError:
                assert time.monotonic() < deadline
                time.sleep(0.05)
    with pytest.raises(RedisConnectionError):
        client(state).ping()

#!/usr/bin/env python3
"""culld under a service manager: sockets handed over, states told, the watchdog fed. The manager is
played here, after sd_listen_fds(3) and sd_notify(3).
usage: systemd_test.py BIN_DIR
"""
import os
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time

CULLD = os.path.join(sys.argv[1], "culld")
CHILDREN = []  # those that run: a test that fails leaves none behind


class Manager:
    """Starts culld with sockets as descriptors from 3 on, and listens to what it tells."""

    def __init__(self, folder, abstract=False):
        self.folder = folder
        path = "\0culld-test-%d" % os.getpid() if abstract else os.path.join(folder, "notify")
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.notify.bind(path)
        self.environment = {"NOTIFY_SOCKET": path.replace("\0", "@")}
        self.told = []

    def start(self, sockets=(), arguments=(), pid=None, count=None, **environment):
        numbers = [s.fileno() for s in sockets]
        log = open(os.path.join(self.folder, "log"), "wb")
        child = os.fork()
        if child == 0:
            try:
                os.dup2(log.fileno(), 2)
                high = [os.dup2(fd, 100 + i) for i, fd in enumerate(numbers)]  # out of the way
                for i, fd in enumerate(high):
                    os.dup2(fd, 3 + i)
                os.closerange(3 + len(high), 200)
                known = dict(os.environ, **self.environment, **environment)
                if numbers:
                    known.update(LISTEN_FDS=count or str(len(numbers)), LISTEN_PID=str(pid or os.getpid()))
                os.execve(CULLD, ["culld", "serve", *arguments], known)
            finally:
                os._exit(99)
        log.close()
        CHILDREN.append(child)
        return child

    def hear(self, wanted, seconds=20):
        """Waits until a line that matches is told, or was told before; forgets all up to it."""
        until = time.monotonic() + seconds
        while True:
            for i, line in enumerate(self.told):
                if re.fullmatch(wanted, line):
                    del self.told[: i + 1]
                    return line
            left = until - time.monotonic()
            assert left > 0 and select.select([self.notify], [], [], left)[0], f"not told: {wanted}, but {self.told}"
            self.told += self.notify.recv(4096).decode().split("\n")

    def log(self):
        with open(os.path.join(self.folder, "log")) as file:
            return file.read()


def end(child, signal_number=signal.SIGTERM):
    if signal_number:
        os.kill(child, signal_number)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    CHILDREN.remove(child)
    return code


def listening(address, family=socket.AF_INET, kind=socket.SOCK_STREAM):
    s = socket.socket(family, kind)
    s.bind(address)
    if kind == socket.SOCK_STREAM:
        s.listen()
    return s


def ask(address, family=socket.AF_INET):
    with socket.socket(family) as s:
        s.settimeout(20)
        s.connect(address)
        s.sendall(b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        reply = b""
        while part := s.recv(1000):
            reply += part
    assert reply.startswith(b"HTTP/1.1 200 "), reply


def activation(folder):
    manager = Manager(folder)
    tcp, tcp6 = listening(("127.0.0.1", 0)), listening(("::1", 0), socket.AF_INET6)
    path = os.path.join(folder, "sock")
    local = listening(path, socket.AF_UNIX)
    for _ in range(2):  # the sockets outlive the daemon: who connects in between waits, and is served
        waiting = socket.create_connection(tcp.getsockname())
        child = manager.start([tcp, local, tcp6], ["--listen", "127.0.0.1:1", "--unix", os.path.join(folder, "unused")])
        manager.hear("READY=1")
        status = manager.hear("STATUS=serving on .*")
        assert "127.0.0.1:%d" % tcp.getsockname()[1] in status and path in status and "[::1]:" in status, status
        ask(tcp.getsockname())
        ask(tcp6.getsockname(), socket.AF_INET6)
        ask(path, socket.AF_UNIX)
        waiting.sendall(b"GET /livez HTTP/1.1\r\nHost: x\r\n\r\n")
        waiting.settimeout(20)
        assert b" 200 " in waiting.recv(1000)
        waiting.close()
        assert not os.path.exists(os.path.join(folder, "unused"))
        assert end(child) == 0, manager.log()
        manager.hear("STOPPING=1")
        assert os.path.exists(path), "a socket that was handed over is its maker's to remove"

    for wrong in (listening(("127.0.0.1", 0), kind=socket.SOCK_DGRAM), socket.socket(), open(os.devnull)):
        child = manager.start([tcp, wrong])
        assert end(child, None) == 78, manager.log()
        assert manager.log() == "culld: LISTEN_FDS: descriptor 4 is not a listening stream socket\n", manager.log()
    for count in ("two", "-1", "65"):
        child = manager.start([tcp], count=count)
        assert end(child, None) == 78, manager.log()
        assert manager.log() == f"culld: LISTEN_FDS: {count} is not a number from 0 to 64\n", manager.log()
    # Meant for another process: not ours.
    child = manager.start([tcp], ["--listen", "127.0.0.1:0"], pid=1)
    status = manager.hear("STATUS=serving on .*")
    assert "127.0.0.1:%d" % tcp.getsockname()[1] not in status, status
    assert end(child) == 0


def states(folder):
    for abstract in (False, True):
        manager = Manager(folder if not abstract else tempfile.mkdtemp(dir=folder), abstract)
        child = manager.start(arguments=["--listen", "127.0.0.1:0"])
        manager.hear("STATUS=loading scenes")
        manager.hear("READY=1")
        os.kill(child, signal.SIGHUP)
        manager.hear("RELOADING=1")
        then = int(manager.hear(r"MONOTONIC_USEC=\d+").split("=")[1])
        assert 0 <= time.monotonic() * 1e6 - then < 20e6, then
        manager.hear("READY=1")
        assert end(child) == 0
        manager.hear("STOPPING=1")
        manager.notify.close()


def watchdog(folder):
    manager = Manager(folder)
    child = manager.start(arguments=["--listen", "127.0.0.1:0"], WATCHDOG_USEC="200000")
    began = time.monotonic()
    for _ in range(5):
        manager.hear("WATCHDOG=1", 5)
    assert time.monotonic() - began >= 0.3, "fed more often than asked for"
    os.kill(child, signal.SIGSTOP)  # a daemon that hangs is not vouched for
    time.sleep(0.3)
    while select.select([manager.notify], [], [], 0)[0]:
        manager.notify.recv(4096)
    assert not select.select([manager.notify], [], [], 0.5)[0]
    os.kill(child, signal.SIGCONT)
    manager.hear("WATCHDOG=1", 5)
    assert end(child) == 0
    for number, other in enumerate(({"WATCHDOG_USEC": "200000", "WATCHDOG_PID": "1"}, {"WATCHDOG_USEC": "soon"}, {"WATCHDOG_USEC": "0"})):
        own = os.path.join(folder, str(number))  # what the last daemon told is nothing to this one
        os.mkdir(own)
        manager = Manager(own)
        child = manager.start(arguments=["--listen", "127.0.0.1:0"], **other)
        manager.hear("STATUS=serving on .*")
        assert not select.select([manager.notify], [], [], 0.5)[0], manager.notify.recv(4096)
        assert end(child) == 0
        manager.hear("STOPPING=1")


try:
    for test in (activation, states, watchdog):
        with tempfile.TemporaryDirectory() as own_folder:
            test(own_folder)
            print(test.__name__, "fine")
finally:
    for left in CHILDREN:
        os.kill(left, signal.SIGKILL)

#!/usr/bin/env python3
"""`culld serve` under TLS, asked by a client that shares no code with it (Python's ssl module): which
versions and certificates, what is no TLS at all, slow handshakes, reload at SIGHUP, tokens, tickets,
users of the Unix socket. The certificates are made here, by the openssl command.

usage: tls_command_test.py BIN_DIR
"""
import base64
import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time

TOKENS = {"boss": ("acme", "admin"), "look": ("acme", "read"), "chief": (None, "admin")}


def run(*words, **options):
    return subprocess.run(words, check=True, capture_output=True, text=True, **options)


def make_certificate(folder, name):
    """A certificate of localhost that vouches for itself; returns (certificate, key)."""
    certificate, key = folder / f"{name}.pem", folder / f"{name}.key"
    run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
        "-days", "2", "-subj", f"/CN={name}", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
        "-keyout", str(key), "-out", str(certificate))
    return certificate, key


def tokens_file(*names):
    text = ""
    for name in names:
        tenant, scope = TOKENS[name]
        text += f'[[token]]\nsha256 = "{hashlib.sha256(name.encode()).hexdigest()}"\nscopes = ["{scope}"]\n'
        text += f'tenant = "{tenant}"\n' if tenant else ""
    return text


class Daemon:
    def __init__(self, bin_dir, folder, config):
        self.folder, self.log = folder, folder / "log"
        (folder / "culld.toml").write_text(config)
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [bin_dir / "culld", "serve", "--config", folder / "culld.toml"], stderr=log)
        self.await_log(" ready")
        line = next(l for l in self.log.read_text().splitlines() if "listening on 127.0.0.1:" in l)
        self.port = int(line.rsplit(":", 1)[1])

    def await_log(self, words, count=1):
        until = time.monotonic() + 30
        while self.log.read_text().count(words) < count:
            assert self.process.poll() is None, self.log.read_text()
            assert time.monotonic() < until, f"no {words!r}: {self.log.read_text()}"
            time.sleep(0.02)

    def reload(self, config=None):
        """Returns whether the daemon liked what it read."""
        if config:
            (self.folder / "culld.toml").write_text(config)
        before = self.log.read_text()
        self.process.send_signal(signal.SIGHUP)
        until = time.monotonic() + 30
        while time.monotonic() < until:
            fresh = self.log.read_text()[len(before):]
            if "configuration read" in fresh:
                return True
            if "configuration refused" in fresh:
                return False
            time.sleep(0.02)
        raise AssertionError("SIGHUP is not heeded")

    def stop(self):
        self.process.terminate()
        assert self.process.wait(20) == 0, self.log.read_text()


def client_context(ca, **versions):
    context = ssl.create_default_context(cafile=str(ca))
    for name, version in versions.items():
        setattr(context, name, version)
    return context


def connect(port, ca, **versions):
    raw = socket.create_connection(("127.0.0.1", port), timeout=15)
    try:
        return client_context(ca, **versions).wrap_socket(raw, server_hostname="localhost")
    except Exception:
        raw.close()
        raise


def read_reply(stream):
    data = b""
    while b"\r\n\r\n" not in data:
        part = stream.recv(65536)
        assert part, f"cut short: {data}"
        data += part
    head, body = data.split(b"\r\n\r\n", 1)
    fields = {k.lower(): v.strip() for k, _, v in (l.partition(":") for l in head.decode().split("\r\n")[1:])}
    while len(body) < int(fields.get("content-length", 0)):
        body += stream.recv(65536)
    return int(head.split()[1]), fields, body


def ask(stream, method, path, token=None, body=None, **fields):
    head = f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n"
    head += f"Authorization: Bearer {token}\r\n" if token else ""
    head += "".join(f"{k.replace('_', '-')}: {v}\r\n" for k, v in fields.items())
    head += f"Content-Length: {len(body)}\r\n" if body is not None else ""
    stream.sendall(head.encode() + b"\r\n" + (body or b""))
    return read_reply(stream)


def status(port, ca, method, path, token=None, body=None, **fields):
    with connect(port, ca) as stream:
        return ask(stream, method, path, token, body, **fields)[0]


def upgrade(stream, scene, subprotocol, token=None, **fields):
    return ask(stream, "GET", f"/v1/scenes/{scene}/live", token, Upgrade="websocket", Connection="Upgrade",
               Sec_WebSocket_Version=13, Sec_WebSocket_Key=base64.b64encode(b"0123456789abcdef").decode(),
               Sec_WebSocket_Protocol=subprotocol, **fields)


def ping(stream):
    stream.sendall(b"\x89\x82\0\0\0\0hi")
    reply = b""
    while len(reply) < 4:
        reply += stream.recv(4 - len(reply))
    return reply == b"\x8a\x02hi"


def subject_seen(port, ca):
    with connect(port, ca) as stream:
        return stream.getpeercert()["subject"][0][0][1]


def expect_failure(what, action, kinds):
    try:
        action()
    except kinds:
        return
    raise AssertionError(f"{what} came through")


def check_versions(port, ca):
    with connect(port, ca, maximum_version=ssl.TLSVersion.TLSv1_2) as stream:
        assert stream.version() == "TLSv1.2", stream.version()
        cipher = stream.cipher()[0]
        assert "ECDHE" in cipher and ("GCM" in cipher or "CHACHA" in cipher), cipher
        assert ask(stream, "GET", "/livez")[0] == 200
        assert ask(stream, "GET", "/livez")[0] == 200, "the connection lives on"
    with connect(port, ca) as stream:
        assert stream.version() == "TLSv1.3", stream.version()
    old = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-tls1_1", "-cipher",
                          "ALL:@SECLEVEL=0"], capture_output=True, input=b"", timeout=20, check=False)
    assert b"Cipher is (NONE)" in old.stdout or b"alert protocol version" in old.stderr, old


def check_what_is_no_tls(port, ca, limit_s):
    with socket.create_connection(("127.0.0.1", port), timeout=15) as plain:
        plain.sendall(b"GET /v1/scenes HTTP/1.1\r\nHost: localhost\r\n\r\n")
        reply = b""
        with contextlib.suppress(ConnectionResetError):
            while part := plain.recv(1000):
                reply += part
        assert b"HTTP" not in reply, reply
    before = time.monotonic()
    with socket.create_connection(("127.0.0.1", port), timeout=15) as silent:
        with contextlib.suppress(ConnectionResetError):
            assert silent.recv(100) == b"", "a handshake that never begins is ended"
    assert time.monotonic() - before < limit_s + 5
    before = time.monotonic()
    with socket.create_connection(("127.0.0.1", port), timeout=15) as slow:
        with contextlib.suppress(ConnectionResetError, BrokenPipeError):
            for byte in b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"x" * 100:
                slow.sendall(bytes([byte]))
                time.sleep(0.1)
                if time.monotonic() - before > limit_s + 5:
                    raise AssertionError("a handshake byte by byte goes on and on")
    assert status(port, ca, "GET", "/livez") == 200, "the others are served"


def check_tokens(port, ca, scene):
    assert status(port, ca, "GET", "/livez") == 200
    assert status(port, ca, "GET", "/v1/scenes") == 401
    assert status(port, ca, "GET", "/v1/scenes", "wrong") == 401
    assert status(port, ca, "GET", "/v1/scenes", "look") == 200
    assert status(port, ca, "GET", "/metrics", "look") == 403
    assert status(port, ca, "PUT", "/v1/scenes/a", "look", scene) == 403
    assert status(port, ca, "PUT", "/v1/scenes/a", "boss", scene) == 201
    assert status(port, ca, "GET", "/v1/scenes/a", "chief") == 404, "another tenant's"
    assert status(port, ca, "GET", "/v1/scenes", "look", Origin="https://evil.example") == 403
    assert status(port, ca, "GET", "/v1/scenes", "look", Origin="https://localhost") == 200
    with connect(port, ca) as stream:
        code, fields, _ = ask(stream, "OPTIONS", "/v1/tickets", Origin="https://app.example",
                              Access_Control_Request_Method="POST")
        assert code == 204 and fields["access-control-allow-origin"] == "https://app.example", fields


def check_tickets(port, ca):
    with connect(port, ca) as stream:
        code, fields, body = ask(stream, "POST", "/v1/tickets", "look", Origin="https://app.example")
        assert code == 201 and fields["access-control-allow-origin"] == "https://app.example", fields
        ticket = json.loads(body)
        assert ticket["expires_s"] == 30, ticket
    offer = "culld.v1, culld.ticket." + ticket["ticket"]
    with connect(port, ca) as stream:
        assert upgrade(stream, "a", offer, Origin="https://evil.example")[0] == 403
    with connect(port, ca) as stream:
        code, fields, _ = upgrade(stream, "a", offer, Origin="https://app.example")
        assert code == 101 and fields["sec-websocket-protocol"] == "culld.v1", (code, fields)
        assert ping(stream)
    with connect(port, ca) as stream:
        assert upgrade(stream, "a", offer)[0] == 401, "a ticket is good once"
    with connect(port, ca) as stream:
        assert upgrade(stream, "a", "culld.v1")[0] == 401


def check_reload(daemon, folder, old, old_bytes):
    port, ca = daemon.port, old[0]
    with connect(port, ca) as live:
        assert upgrade(live, "a", "culld.v1", "boss")[0] == 101
        second = make_certificate(folder, "second")
        shutil.copy(second[0], folder / "server.pem")  # the key is not yet there: a moment's disorder
        assert not daemon.reload(), "a certificate without its key"
        assert subject_seen(port, ca) == "first", "the old ones stay"
        shutil.copy(second[1], folder / "server.key")
        assert daemon.reload()
        assert subject_seen(port, second[0]) == "second"
        expect_failure("the old certificate", lambda: connect(port, ca), ssl.SSLCertVerificationError)
        assert ping(live), "an old connection lives on"
        (folder / "server.pem").write_text("no certificate at all")
        assert not daemon.reload()
        (folder / "server.pem").write_bytes(second[0].read_bytes())
        (folder / "tokens.toml").write_text("[[token]]\n")
        assert not daemon.reload()
        assert status(port, second[0], "GET", "/v1/scenes", "look") == 200, "the old tokens hold"
        assert ping(live)
        (folder / "tokens.toml").write_text(tokens_file("look", "chief"))
        assert daemon.reload()
        data = b""
        live.settimeout(15)
        while part := live.recv(1000):
            data += part
        assert b"\x03\xe9" in data, f"no close with 1001: {data}"
        assert status(port, second[0], "GET", "/v1/scenes", "boss") == 401
    assert old_bytes != (folder / "server.pem").read_bytes()
    return second[0]


def check_unix_users(daemon, folder):
    """As another user; needs one, so root."""
    def ask_as(user, path):
        code = ("import os,select,socket,sys\n"
                f"os.setgroups([]); os.setgid({user}); os.setuid({user})\n"
                "s=socket.socket(socket.AF_UNIX); s.connect(sys.argv[1])\n"
                "if not select.select([s],[],[],0.3)[0]: "  # who is refused is told so unasked
                "s.sendall(b'GET /v1/scenes HTTP/1.1\\r\\nHost: x\\r\\nConnection: close\\r\\n\\r\\n')\n"
                "print(s.recv(1000).split()[1].decode())\n")
        return int(run(sys.executable, "-c", code, path).stdout)
    path = str(folder / "sock")
    with socket.socket(socket.AF_UNIX) as own:
        own.settimeout(15)
        own.connect(path)
        assert ask(own, "GET", "/v1/scenes")[0] == 200, "the same user needs no token"
    if os.geteuid() != 0:
        print("tls_command: not root, so no other user can knock at the Unix socket")
        return
    os.chmod(folder, 0o755)
    os.chmod(path, 0o666)
    assert ask_as(12345, path) == 200, "among unix_users"
    assert ask_as(12346, path) == 403, "not among them"


def refused(bin_dir, code, words, *arguments):
    done = subprocess.run([bin_dir / "culld", *arguments], capture_output=True, text=True, timeout=20, check=False)
    assert done.returncode == code, (arguments, done)
    assert done.stderr.count("\n") == 1 and words in done.stderr, (arguments, done.stderr)


def check_refusals(bin_dir, folder, certificate, key):
    def config(text):
        (folder / "bad.toml").write_text(text)
        return "--config", str(folder / "bad.toml")
    tls = f'[tls]\ncertificate = "{certificate}"\nkey = "{key}"\n'
    tokens = f'[access]\ntokens = "{folder}/tokens.toml"\n'
    public = 'listen = "0.0.0.0:0"\n'
    refused(bin_dir, 78, "whoever reaches it may do everything", "serve", "--listen", "0.0.0.0:0")
    refused(bin_dir, 78, "whoever reaches it may do everything", "serve", *config(public + tls))
    refused(bin_dir, 78, "in plain text", "serve", *config(public + tokens))
    refused(bin_dir, 78, "certificate without a key", "serve", *config(f'[tls]\ncertificate = "{certificate}"\n'))
    refused(bin_dir, 78, "none.pem", "serve", *config(f'[tls]\ncertificate = "none.pem"\nkey = "{key}"\n'))
    refused(bin_dir, 78, "not a PEM certificate", "serve", *config(f'[tls]\ncertificate = "{key}"\nkey = "{key}"\n'))
    other = make_certificate(folder, "other")
    refused(bin_dir, 78, "not the PEM key", "serve", *config(f'[tls]\ncertificate = "{certificate}"\nkey = "{other[1]}"\n'))
    refused(bin_dir, 78, "none.toml", "serve", *config('[access]\ntokens = "none.toml"\n'))
    refused(bin_dir, 78, "not known on this machine", "serve", *config('[access]\nunix_users = ["no-such-user"]\n'))
    refused(bin_dir, 78, "origin", "serve", *config('[access]\norigins = ["*"]\n'))
    config(public + tokens)
    refused(bin_dir, 78, "in plain text", "check-config", str(folder / "bad.toml"))


def main():
    bin_dir = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory(prefix="culld_tls.") as name:
        folder = pathlib.Path(name)
        first = make_certificate(folder, "first")
        shutil.copy(first[0], folder / "server.pem")
        shutil.copy(first[1], folder / "server.key")
        (folder / "tokens.toml").write_text(tokens_file(*TOKENS))
        run(bin_dir / "make_scene", "random", "--seed", "1", "-o", folder / "random.glb")
        daemon = Daemon(bin_dir, folder, f"""
listen = "127.0.0.1:0"
unix = "{folder}/sock"
[tls]
certificate = "{folder}/server.pem"
key = "{folder}/server.key"
[access]
tokens = "{folder}/tokens.toml"
origins = ["https://app.example"]
unix_users = ["12345"]
[limits]
header_timeout_s = 1
""")
        try:
            check_versions(daemon.port, first[0])
            stranger = make_certificate(folder, "stranger")[0]
            expect_failure("a certificate that nobody vouches for", lambda: connect(daemon.port, stranger),
                           ssl.SSLCertVerificationError)
            check_what_is_no_tls(daemon.port, first[0], 1)
            check_tokens(daemon.port, first[0], (folder / "random.glb").read_bytes())
            check_tickets(daemon.port, first[0])
            check_unix_users(daemon, folder)
            ca = check_reload(daemon, folder, first, first[0].read_bytes())
            with connect(daemon.port, ca) as stream:
                metrics = ask(stream, "GET", "/metrics", "chief")[2].decode()
            for line in ('culld_tls_handshake_failures_total', 'culld_auth_failures_total{reason="token"}',
                         'culld_auth_failures_total{reason="origin"}', 'culld_auth_failures_total{reason="ticket"}',
                         'culld_tls_certificate_expiry_timestamp_seconds'):
                value = next(l for l in metrics.splitlines() if l.startswith(line)).split()[-1]
                assert float(value) > 0, metrics
            check_refusals(bin_dir, folder, *first)
            log = daemon.log.read_text()
            for secret in (*TOKENS, "Bearer", "culld.ticket"):
                assert f" {secret} " not in log and f'"{secret}"' not in log, f"{secret} is in the log: {log}"
            daemon.stop()
        finally:
            if daemon.process.poll() is None:
                daemon.process.kill()
                daemon.process.wait()
    print("tls_command: fine")


main()

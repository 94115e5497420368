#!/usr/bin/env python3
"""Load on the server of `earpoint serve`: many connections, many poses, slow and broken ones. Needs wrk.

Usage: python3 experiments/stress/serve_load.py EARPOINT CLIP [SERVE_ARGUMENT...]
Prints one JSON object per line. Exits with 1 if a request failed, or slow connections kept the server busy.
"""
import json
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

CONNECTIONS = 200
SECONDS = 8
LISTENERS = 8
POSES = 10_000
PART = 2048  # samples of one request, as in the page
SLOW = 100  # connections that send a byte a second

SCRIPT = """
-- Poses of all listeners, one after the other; without listeners, one address.
local listeners = {%s}
local method = "%s"
local count = 0
function request()
  if #listeners == 0 then return wrk.format("GET", "/api/clips") end
  count = count + 1
  local body = string.format('{"start": %%d, "samples": %d, "method": "%%s", "position_m": [0, %%.3f, 0], "yaw_deg": %%d}',
    (count * %d) %% 96000, method, (count %% 200) * 0.01 - 1, count %% 90)
  return wrk.format("POST", "/api/listeners/" .. listeners[count %% #listeners + 1] .. "/sound", {}, body)
end
function done(summary, latency, requests)
  local e = summary.errors
  io.write(string.format('JSON {"requests": %%d, "seconds": %%.2f, "failed": %%d, "timeouts": %%d, "p50_ms": %%.1f, "p99_ms": %%.1f}\\n',
    summary.requests, summary.duration / 1e6, e.connect + e.read + e.write + e.status, e.timeout,
    latency:percentile(50) / 1e3, latency:percentile(99) / 1e3))
end
"""


class Server:
    def __init__(self, program, arguments):
        self.process = subprocess.Popen([program, "serve", *arguments, "--quiet", "--listeners", str(LISTENERS)],
                                        stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.address = re.search(r"http://\S+?(?=/? )", line).group(0).rstrip("/")
        self.port = int(self.address.rsplit(":", 1)[1])

    def ask(self, path, body=None):
        request = urllib.request.Request(self.address + path, data=body, method="GET" if body is None else "POST")
        with urllib.request.urlopen(request, timeout=30) as answer:
            return answer.read()

    def join(self):
        clip = json.loads(self.ask("/api/clips"))["clips"][0]["id"]
        return json.loads(self.ask("/api/listeners", json.dumps({"clip": clip}).encode()))["listener"]

    def memory_mb(self):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as status:
            return int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1)) / 1024

    def load(self, listeners, method, connections, seconds):
        with tempfile.NamedTemporaryFile("w", suffix=".lua") as script:
            names = ", ".join(f'"{name}"' for name in listeners)
            script.write(SCRIPT % (names, method, PART, PART))
            script.flush()
            output = subprocess.run(["wrk", "-t1", f"-c{connections}", f"-d{seconds}s", "--timeout", "30s", "-s", script.name,
                                     self.address], capture_output=True, text=True, check=True).stdout
        return json.loads(re.search(r"JSON (.*)", output).group(1))


class Slow:
    """A connection that sends the headers of a request a byte a second and never ends."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.began = time.monotonic()
        self.lasted_s = None
        self.thread = threading.Thread(target=self.drip, daemon=True)
        self.thread.start()

    def drip(self):
        try:
            self.socket.sendall(b"GET / HTTP/1.1\r\nX-Slow: ")
            while time.monotonic() - self.began < 60:
                self.socket.sendall(b"x")
                self.socket.settimeout(1)
                try:
                    if self.socket.recv(1) == b"":
                        break
                except socket.timeout:
                    pass
        except OSError:
            pass
        self.lasted_s = time.monotonic() - self.began


def tell(what, **numbers):
    rounded = {name: round(value, 1) if isinstance(value, float) else value for name, value in numbers.items()}
    print(json.dumps({"load": what, **rounded}), flush=True)


def main():
    program, *arguments = sys.argv[1:]
    server = Server(program, arguments)
    failed = 0
    try:
        pages = server.load([], "", CONNECTIONS, SECONDS)
        failed += pages["failed"]
        tell(f"{CONNECTIONS} connections ask for the list of clips", **pages)

        listeners = [server.join() for _ in range(LISTENERS)]
        for method in ("input", "gtf"):
            server.load(listeners, method, LISTENERS, 2)  # everything that is made once is made
            sound = server.load(listeners, method, CONNECTIONS, SECONDS)
            failed += sound["failed"]
            tell(f"{CONNECTIONS} connections move {LISTENERS} listeners, {method}", **sound)

        before = server.memory_mb()
        posts = 0
        while posts < POSES:
            posts += server.load(listeners, "gtf", LISTENERS, 10)["requests"]
        tell("poses by gtf", poses=posts, memory_before_mb=before, memory_after_mb=server.memory_mb())

        slow = [Slow(server.port) for _ in range(SLOW)]
        time.sleep(1)
        beside = server.load([], "", 50, 5)
        failed += beside["failed"] + beside["timeouts"]
        for connection in slow:
            connection.thread.join()
        longest = max(connection.lasted_s for connection in slow)
        failed += longest > 30
        tell(f"50 connections beside {SLOW} that send a byte a second", **beside, slow_ended_after_s=longest)
    finally:
        server.process.terminate()
        server.process.wait()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

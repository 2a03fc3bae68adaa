"""A WebSocket of a client (RFC 6455), with Python's library alone."""

import base64
import os
import socket
import struct

TEXT, BINARY, PING, PONG = 1, 2, 9, 10


class WebSocket:
    def __init__(self, address, timeout):
        host, path = address[len("ws://"):].split("/", 1)
        name, port = host.rsplit(":", 1)
        self.socket = socket.create_connection((name, int(port)), timeout=timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET /{path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self.read(1)
        assert b" 101 " in head, head

    def read(self, count):
        data = bytearray()
        while len(data) < count:
            part = self.socket.recv(min(count - len(data), 1 << 20))
            assert part, "the other side has closed the connection"
            data += part
        return bytes(data)

    def receive(self):
        """Returns the kind of the next message and its data."""
        data, kind = b"", TEXT
        while True:
            first, length = self.read(2)
            final, code, length = first & 0x80, first & 0x0F, length & 0x7F
            if length >= 126:
                length = struct.unpack("!H" if length == 126 else "!Q", self.read(2 if length == 126 else 8))[0]
            part = self.read(length)
            if code == PING:
                self.send(part, PONG)
                continue
            kind = code or kind
            data += part
            if final:
                return kind, data

    def send(self, data, kind=TEXT):
        length, first = len(data), 0x80 | kind
        head = struct.pack("!BB", first, 0x80 | length) if length < 126 else (
            struct.pack("!BBH", first, 0xFE, length) if length < 1 << 16 else struct.pack("!BBQ", first, 0xFF, length))
        # A mask of zeros leaves the data as it is.
        self.socket.sendall(head + bytes(4) + data)

#!/usr/bin/env python3
"""Works out vectors/frames.txt from PROTOCOL.md alone: struct, binascii.crc_hqx and a COBS of its own.

Run: python3 vectors/make.py > vectors/frames.txt
"""
import binascii
import struct


def cobs(data: bytes) -> bytes:
    out = b""
    for block in data.split(b"\0"):
        assert len(block) < 254
        out += bytes([len(block) + 1]) + block
    return out


def frame(kind: int, body: bytes) -> bytes:
    content = bytes([kind]) + body
    crc = binascii.crc_hqx(content, 0xFFFF)  # CRC-16/CCITT-FALSE
    return cobs(content + struct.pack("<H", crc)) + b"\0"


def data(seq, time_us, counts, command_mv, flags, extra=b""):
    return frame(0x04, struct.pack("<HIihB", seq, time_us, counts, command_mv, flags) + extra)


assert binascii.crc_hqx(b"123456789", 0xFFFF) == 0x29B1
segments = struct.pack("<HhHh", 100, 0, 1234, -4500)
rows = {
    "hello": frame(0x01, b"MLAB" + struct.pack("<BBBIIHIHBH", 1, 1, 0, 0x01020304, 3000, 1500, 720, 4500, 0, 200) + b"uno"),
    "ack": frame(0x02, struct.pack("<BH", 0x84, 12)),
    "nak": frame(0x03, struct.pack("<BB", 0x82, 4)),
    "data": data(258, 4294964296, -720, 4500, 1),
    "data_measured": data(258, 4294964296, -720, 4500, 1, struct.pack("<hH", -100, 4480)),
    "end": frame(0x05, struct.pack("<IIB", 1334, 2, 1)),
    "text": frame(0x06, b"ready"),
    "identify": frame(0x81, b""),
    "configure": frame(0x82, struct.pack("<IB", 30000, 1)),
    "profile": frame(0x83, struct.pack("<HH", 2, binascii.crc_hqx(segments, 0xFFFF))),
    "chunk": frame(0x84, struct.pack("<H", 0) + segments),
    "start": frame(0x85, struct.pack("<I", 1334)),
    "stop": frame(0x86, b""),
    "alive": frame(0x87, b""),
}
print("# Frames on the wire, made by make.py; used by the crate's tests and by the sketch's.")
for name, bytes_ in rows.items():
    print(f"{name}: {bytes_.hex(' ')}")

"""The wire protocol from PROTOCOL.md alone: an encoder and a decoder that share no code with the project."""

import struct

HELLO, ACK, NAK, DATA, END, TEXT = range(1, 7)
IDENTIFY, CONFIGURE, PROFILE, CHUNK, START, STOP, ALIVE = range(0x81, 0x88)


def _table():
    rows = []
    for byte in range(256):
        value = byte << 8
        for _ in range(8):
            value = ((value << 1) ^ 0x1021) & 0xFFFF if value & 0x8000 else (value << 1) & 0xFFFF
        rows.append(value)
    return rows


TABLE = _table()


def crc(content):
    value = 0xFFFF
    for byte in content:
        value = ((value << 8) & 0xFFFF) ^ TABLE[(value >> 8) ^ byte]
    return value


def stuffed(content):
    out = bytearray()
    for block in content.split(b"\0"):
        out.append(len(block) + 1)  # a frame is shorter than the 254 bytes that need another code
        out += block
    return bytes(out)


def unstuffed(content):
    out, at = bytearray(), 0
    while at < len(content):
        length = content[at]
        out += content[at + 1:at + length]
        at += length
        if at < len(content):
            out.append(0)
    return bytes(out)


def frame(kind, body):
    content = bytes([kind]) + body
    return stuffed(content + struct.pack("<H", crc(content))) + b"\0"


def hello(version=1, boot=1, ts_us=30000, shortest_us=1000, counts_per_rev=720, supply_mv=4500, fields=0,
          segments=2688, name=b"fake", magic=b"MLAB"):
    return frame(HELLO, magic + struct.pack("<BBBIIHIHBH", version, 1, 0, boot, ts_us, shortest_us, counts_per_rev,
                                            supply_mv, fields, segments) + name)


def data(seq, time_us, counts, command_mv, flags=0):
    counts = (counts + 2**31) % 2**32 - 2**31
    return frame(DATA, struct.pack("<HIihB", seq & 0xFFFF, time_us & 0xFFFFFFFF, counts, command_mv, flags))


def end(taken, dropped=0, reason=0):
    return frame(END, struct.pack("<IIB", taken, dropped, reason))


def ack(kind, detail=0):
    return frame(ACK, struct.pack("<BH", kind, detail))


def nak(kind, reason):
    return frame(NAK, bytes([kind, reason]))


class Decoder:
    """Whole frames out of a stream, as pairs of type and body."""

    def __init__(self):
        self.begun = bytearray()

    def push(self, content):
        frames = []
        parts = content.split(b"\0")
        for k, part in enumerate(parts):
            self.begun += part
            if k + 1 < len(parts):
                whole = unstuffed(bytes(self.begun)) if self.begun else b""
                if len(whole) >= 3 and crc(whole[:-2]) == struct.unpack("<H", whole[-2:])[0]:
                    frames.append((whole[0], whole[1:-2]))
                self.begun = bytearray()
        return frames


# The worked dump of PROTOCOL.md.
assert data(258, 4294964296, -720, 4500, 1).hex() == "1104020148f4ffff30fdffff94110131a600"
assert Decoder().push(data(258, 4294964296, -720, 4500, 1))[0][0] == DATA

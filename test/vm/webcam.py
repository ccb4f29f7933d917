"""
Runs in the guest: a USB webcam for the kernel's own driver `uvcvideo`, over USB/IP.

The kernel's virtual host controller `vhci-hcd` takes one end of a pair of sockets for a cable; at
the other end this process answers as a webcam does: descriptors, controls, video. What a cheap or
broken one does otherwise is asked for with `Faults`.

Numbers: USB 2.0 chapter 9, USB Video Class 1.0, Documentation/usb/usbip_protocol.rst.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
import select
import socket
import struct
import time

WIDTH, HEIGHT = 160, 120
FRAME_RATE = 5.0
INTERVAL = 1.0 / FRAME_RATE  # s
FRAME_BYTES = 2 * WIDTH * HEIGHT
ATTACH = Path('/sys/devices/platform/vhci_hcd.0/attach')
SPEED_HIGH, DEVICE = 3, 0x10001
SUBMIT, UNLINK, SUBMITTED, UNLINKED = 1, 2, 3, 4
HEADER = struct.Struct('>5I28s')
STALL, RESET = -32, -104  # -EPIPE, -ECONNRESET
SET_CUR, GET_CUR, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF = 1, *range(0x81, 0x88)
PACKET = 2048  # bytes
CLOCK_HZ = 48_000_000  # of its own
MILLISECOND = 1e-3  # s from packet to packet
CAMERA, PROCESSING, OUTPUT = 1, 2, 3  # units
CLASS, ISOCHRONOUS, BULK = 0x20, 5, 2


@dataclass
class Setting:
    """A control: its bytes and what it may be."""

    size: int
    minimum: int
    maximum: int
    resolution: int
    default: int
    now: int = field(init=False)

    def __post_init__(self) -> None:
        self.now = self.default


def settings() -> dict[tuple[int, int], Setting]:
    """Return the controls by unit and selector."""
    return {
        # Manual (1) or governed by the aperture (8): the resolution tells which there are.
        (CAMERA, 2): Setting(1, 0, 0, 9, 8),
        (CAMERA, 4): Setting(4, 1, 5000, 1, 156),  # exposure time, 100 us
        (PROCESSING, 2): Setting(2, 0, 255, 1, 128),  # brightness
        (PROCESSING, 3): Setting(2, 0, 64, 1, 32),  # contrast
        (PROCESSING, 4): Setting(2, 0, 100, 1, 10),  # gain
    }


AUTO, EXPOSURE, BRIGHTNESS, CONTRAST, GAIN = settings()


@dataclass(frozen=True)
class Faults:
    """
    What this webcam does otherwise.

    Parameters
    ----------
    bulk : bool
        No fault: video in bulk, not isochronous.
    lost : collection of int
        Frames that never come out of it.
    endless : bool
        No frame is marked as ended.
    chatter : bool
        Headers without data while it waits for the next frame.
    clock : bool
        No fault: its own time, PTS and SCR, in the first header of a frame.
    missing : collection of (int, int)
        Controls that it does not claim to have.
    stalls : collection of (unit, selector, request)
        Requests that it refuses.
    silent : collection of (unit, selector, request)
        Requests that it never answers.

    """

    bulk: bool = False
    lost: frozenset[int] = frozenset()
    endless: bool = False
    chatter: bool = False
    clock: bool = False
    missing: frozenset[tuple[int, int]] = frozenset()
    stalls: frozenset[tuple[int, int, int]] = frozenset()
    silent: frozenset[tuple[int, int, int]] = frozenset()


def _block(*parts: bytes) -> bytes:
    """Return a descriptor with its length before it."""
    body = b''.join(parts)
    return bytes([len(body) + 1]) + body


def device_descriptor() -> bytes:
    """Return what the device is."""
    return _block(struct.pack('<BHBBBBHHHBBBB', 1, 0x200, 0xef, 2, 1, 64, 0x1d6b, 0x0102, 0x100,
                              0, 1, 0, 1))


def configuration(faults: Faults) -> bytes:
    """Return what the interfaces, units and formats are."""
    camera, processing = (0b1010, 0b10_0000_0011)  # auto and exposure; brightness, contrast, gain
    for unit, bit, claimed in ((CAMERA, 1, AUTO), (CAMERA, 3, EXPOSURE),
                               (PROCESSING, 0, BRIGHTNESS), (PROCESSING, 1, CONTRAST),
                               (PROCESSING, 9, GAIN)):
        if claimed in faults.missing:
            camera &= ~(1 << bit) if unit == CAMERA else -1
            processing &= ~(1 << bit) if unit == PROCESSING else -1
    units = b''.join((
        _block(struct.pack('<BBBHBBHHHB', 0x24, 2, CAMERA, 0x201, 0, 0, 0, 0, 0, 3),
               camera.to_bytes(3, 'little')),
        _block(struct.pack('<BBBBHBHB', 0x24, 5, PROCESSING, CAMERA, 0, 2, processing, 0)),
        _block(struct.pack('<BBBHBBB', 0x24, 3, OUTPUT, 0x101, 0, PROCESSING, 0)),
    ))
    control = _block(struct.pack('<BBHHIBB', 0x24, 1, 0x100, 13 + len(units), CLOCK_HZ, 1, 1))
    ticks = round(1e7 * INTERVAL)
    formats = b''.join((
        _block(struct.pack('<BBBB16sBBBBBB', 0x24, 4, 1, 1,
                           b'YUY2\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71', 16, 1, 0, 0, 0, 0)),
        _block(struct.pack('<BBBBHHIIIIBI', 0x24, 5, 1, 0, WIDTH, HEIGHT,
                           *[round(8 * FRAME_BYTES * FRAME_RATE)] * 2, FRAME_BYTES, ticks, 1,
                           ticks)),
    ))
    streaming = _block(struct.pack('<BBBHBBBBBBBB', 0x24, 1, 1, 14 + len(formats), 0x81, 0, OUTPUT,
                                   0, 0, 0, 1, 0))

    def interface(number: int, alternate: int, endpoints: int, kind: int) -> bytes:
        return _block(bytes([4, number, alternate, endpoints, 0x0e, kind, 0, 0]))

    if faults.bulk:
        ends = b''
        first = interface(1, 0, 1, 2)
        last = _block(struct.pack('<BBBHB', 5, 0x81, BULK, 512, 0))
    else:
        first = interface(1, 0, 0, 2)
        # Twice 1024 bytes in every eighth microframe.
        ends = _block(struct.pack('<BBBHB', 5, 0x81, ISOCHRONOUS, 1 << 11 | 1024, 4))
        last = interface(1, 1, 1, 2) + ends
    body = b''.join((
        _block(bytes([0x0b, 0, 2, 0x0e, 3, 0, 0])), interface(0, 0, 0, 1), control, units, first,
        streaming, formats, last))
    return _block(struct.pack('<BHBBBBB', 2, 9 + len(body), 2, 1, 0, 0x80, 250)) + body


@dataclass
class Request:
    """What the host waits for: its number, bytes and packets, and when it is due, s."""

    number: int
    length: int
    packets: int
    due: float


class Webcam:
    """A webcam on the virtual cable; it lives as long as `run` does."""

    def __init__(self, faults: Faults = Faults()) -> None:
        self._faults = faults
        self._settings = settings()
        self._probe = struct.pack('<HBBIHHHHHII', 1, 1, 1, round(1e7 * INTERVAL), 0, 0, 0, 0, 0,
                                  FRAME_BYTES, FRAME_BYTES + 2 if faults.bulk else PACKET)
        self._waiting: deque[Request] = deque()
        self._bus = 0.0  # s, until when it is planned
        self._began: float | None = None  # s, of frame 0
        self._frame = -1  # that is being sent
        self._left = b''  # of it
        self._identity = 0  # flips from frame to frame
        self._end, self._far_end = socket.socketpair()

    def plug(self) -> None:
        """Put the cable in."""
        ATTACH.write_text(f'0 {self._far_end.fileno()} {DEVICE} {SPEED_HIGH}')
        self._far_end.close()  # the kernel has its own

    def run(self) -> None:
        """Answer until the host lets go."""
        while True:
            due = self._waiting[0].due if self._waiting else time.monotonic() + 1.0
            if select.select([self._end], [], [], max(0.0, due - time.monotonic()))[0]:
                if not self._take():
                    return
            while self._waiting and self._waiting[0].due <= time.monotonic():
                if not self._send_video(self._waiting[0]):
                    break
                self._waiting.popleft()

    def _receive(self, count: int) -> bytes:
        return self._end.recv(count, socket.MSG_WAITALL) if count else b''

    def _take(self) -> bool:
        """Take one request; return whether the cable is still in."""
        raw = self._receive(HEADER.size)
        if len(raw) < HEADER.size:
            return False
        command, number, _, inward, endpoint, rest = HEADER.unpack(raw)
        if command == UNLINK:
            victim = int.from_bytes(rest[:4], 'big')
            there = [one for one in self._waiting if one.number == victim]
            self._waiting = deque(one for one in self._waiting if one.number != victim)
            self._end.sendall(HEADER.pack(
                UNLINKED, number, 0, 0, 0, struct.pack('>i', RESET if there else 0)))
            return True
        _, length, _, packets, _, setup = struct.unpack('>Iiiii8s', rest)
        data = self._receive(0 if inward else length)
        if endpoint:
            packets = 0 if self._faults.bulk else packets
            self._receive(16 * packets)  # where each packet goes
            now = time.monotonic()
            self._bus = max(self._bus, now - 0.1) + packets * MILLISECOND
            if self._began is None:
                self._began = now
            self._waiting.append(Request(number, length, packets, self._bus if packets else now))
            return True
        answer = self._control(setup, data)
        if answer is None:
            self._reply(number, b'', STALL)
        elif answer is not NotImplemented:
            self._reply(number, answer[:length] if inward else b'', 0,
                        len(data) if not inward else None)
        return True

    def _reply(self, number: int, data: bytes, status: int = 0, length: int | None = None,
               packets: bytes = b'') -> None:
        actual = len(data) if length is None else length
        self._end.sendall(HEADER.pack(SUBMITTED, number, 0, 0, 0, struct.pack(
            '>iiiii', status, actual, 0, len(packets) // 16, 0)) + data + packets)

    # --- controls ---

    def _control(self, setup: bytes, data: bytes) -> bytes | None:
        """Return the answer to a control request, None where it is refused."""
        kind, request, value, index, _ = struct.unpack('<BBHHH', setup)
        if not kind & CLASS:
            return self._standard(request, value, index)
        unit, selector = index >> 8, value >> 8
        if (unit, selector, request) in self._faults.silent:
            return NotImplemented
        if (unit, selector, request) in self._faults.stalls:
            return None
        if index == 1:  # the stream: its probe and its commitment
            if request == SET_CUR:
                self._probe = data[:2] + self._probe[2:]
            return {GET_INFO: b'\3', GET_LEN: struct.pack('<H', len(self._probe))}.get(
                request, self._probe)
        if unit == 0:
            return b'\6'  # why the last request was refused: there is no such control
        setting = self._settings.get((unit, selector))
        if setting is None or (unit, selector) in self._faults.missing:
            return None
        if request == SET_CUR:
            setting.now = int.from_bytes(data, 'little')
            return b''
        if request in (GET_INFO, GET_LEN):
            return b'\3' if request == GET_INFO else struct.pack('<H', setting.size)
        number = {GET_CUR: setting.now, GET_MIN: setting.minimum, GET_MAX: setting.maximum,
                  GET_RES: setting.resolution, GET_DEF: setting.default}[request]
        return number.to_bytes(setting.size, 'little')

    def _standard(self, request: int, value: int, index: int) -> bytes | None:
        if request == 6:  # GET_DESCRIPTOR
            return {0x100: device_descriptor(), 0x200: configuration(self._faults),
                    0x300: _block(struct.pack('<BH', 3, 0x409)),
                    0x301: _block(b'\3' + 'Webcam'.encode('utf-16-le'))}.get(value)
        if request == 11 and index == 1:  # SET_INTERFACE
            self._began, self._frame, self._left = None, -1, b''
        return b'\0\0' if request == 0 else b'\1' if request == 8 else b''

    # --- video ---

    def _send_video(self, request: Request) -> bool:
        """Answer with video; return False where there is none for it yet."""
        if not request.packets:
            payload = self._payload(request.due, request.length, request.length)
            if not payload:
                assert self._began is not None
                request.due = max(time.monotonic(), self._began + (self._frame + 1) * INTERVAL)
                return False
            self._reply(request.number, payload)
            return True
        data, packets = b'', b''
        for index in range(request.packets):
            at = request.due - (request.packets - index) * MILLISECOND
            payload = self._payload(at, PACKET, request.length // request.packets)
            packets += struct.pack('>IIIi', index * PACKET, PACKET, len(payload), 0)
            data += payload
        self._reply(request.number, data, packets=packets)
        return True

    def _payload(self, at: float, most: int, room: int) -> bytes:
        """Return what the camera sends next at a time, s: a header and data, or nothing."""
        assert self._began is not None
        first = False
        if not self._left and at >= self._began + (self._frame + 1) * INTERVAL:
            self._frame += 1
            self._identity ^= 1
            if self._frame not in self._faults.lost:
                self._left, first = picture(self._frame), True
        if not self._left:
            # With the mark of the frame that is to come.
            return bytes([2, 0x80 | self._identity ^ 1]) if self._faults.chatter else b''
        times = self._times(at) if first and self._faults.clock else b''
        header = b'' if self._faults.bulk and not first else b'\2\0' + times
        part, self._left = self._left[:most - len(header)], self._left[most - len(header):]
        flags = 0x80 | self._identity
        if (self._faults.bulk or not self._left) and not self._faults.endless:
            flags |= 2
        if times:
            flags |= 0b1100  # PTS and SCR
        return (bytes([len(header), flags]) + times if header else b'') + part

    def _times(self, at: float) -> bytes:
        """Return PTS, when this frame began, and SCR: now, and the number of the bus' frame."""
        assert self._began is not None
        began, now = (
            int(CLOCK_HZ * each) & 0xffffffff
            for each in (self._began + self._frame * INTERVAL, at))
        return struct.pack('<IIH', began, now, int(at / MILLISECOND) & 0x7ff)


def picture(number: int) -> bytes:
    """Return YUYV of one grey that tells the number."""
    return bytes([16 + number % 200, 128]) * (WIDTH * HEIGHT)

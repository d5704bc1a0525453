"""A network device whose other end is a file: what a host of a rehearsal has for its cable.

It is there as long as the file is open, and goes with its network namespace.
"""

import ctypes
import fcntl
import os
import socket
import struct

_DEVICE = b"cable"
_TUNSETIFF, _IFF_TAP, _IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
_SIOCADDRT, _SIOCSIFFLAGS, _SIOCSIFADDR, _SIOCSIFNETMASK = 0x890B, 0x8914, 0x8916, 0x891C
_IFF_UP, _RTF_UP = 0x1, 0x1
_CLONE_NEWNET = 0x40000000


def leave_the_network() -> None:
    """Enter a network namespace of one's own, in which there is nothing but a loopback device."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(_CLONE_NEWNET) != 0:
        error = ctypes.get_errno()
        raise OSError(error, f"a network namespace cannot be made: {os.strerror(error)}")


def open_cable(address: str) -> int:
    """Make the device in this network namespace, all of IPv4 reachable by it.

    Returns: the file of its other end: a frame is a read or a write.
    """
    cable = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(cable, _TUNSETIFF, struct.pack("16sH22x", _DEVICE, _IFF_TAP | _IFF_NO_PI))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ours:
        _up(ours, b"lo")
        _ask(ours, _SIOCSIFADDR, _DEVICE, _sockaddr(address))
        _ask(ours, _SIOCSIFNETMASK, _DEVICE, _sockaddr("255.255.255.255"))
        _up(ours, _DEVICE)
        _route_all(ours, _DEVICE)
    return cable


def _ask(ours: socket.socket, request: int, device: bytes, value: bytes) -> None:
    fcntl.ioctl(ours, request, struct.pack("16s24s", device, value))


def _up(ours: socket.socket, device: bytes) -> None:
    _ask(ours, _SIOCSIFFLAGS, device, struct.pack("H", _IFF_UP))


def _sockaddr(address: str) -> bytes:
    return struct.pack("HH4s8x", socket.AF_INET, 0, socket.inet_aton(address))


def _route_all(ours: socket.socket, device: bytes) -> None:
    """Add a route for all addresses: there is no gateway, they are all at the cable's end."""
    name = ctypes.create_string_buffer(device)
    anywhere = _sockaddr("0.0.0.0")
    entry = struct.pack(  # struct rtentry of linux/route.h
        "@L16s16s16sHhLPhPLLH",
        *(0, anywhere, anywhere, anywhere, _RTF_UP, 0, 0, 0, 0, ctypes.addressof(name), 0, 0, 0),
    )
    fcntl.ioctl(ours, _SIOCADDRT, entry)

"""A TAP device: the network interface of a virtual host, whose other end is a file.

The device exists as long as the file is open, and ends with its network namespace.
"""

import ctypes
import fcntl
import os
import socket
import struct

_DEVICE = b"tap"
_TUNSETIFF, _IFF_TAP, _IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
_SIOCADDRT, _SIOCSIFFLAGS, _SIOCSIFADDR, _SIOCSIFNETMASK = 0x890B, 0x8914, 0x8916, 0x891C
_IFF_UP, _RTF_UP = 0x1, 0x1
_CLONE_NEWNET = 0x40000000


def enter_new_network() -> None:
    """Move this process to a new network namespace, which has nothing but a loopback device."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(_CLONE_NEWNET) != 0:
        error = ctypes.get_errno()
        raise OSError(error, f"a network namespace cannot be made: {os.strerror(error)}")


def open_tap(address: str) -> int:
    """Create the device in this network namespace, with a route to all of IPv4.

    Args:
        address: The IPv4 address of the device.

    Returns:
        The file descriptor of its other end, where each read or write is an Ethernet frame.
    """
    tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tap, _TUNSETIFF, struct.pack("16sH22x", _DEVICE, _IFF_TAP | _IFF_NO_PI))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        _up(control, b"lo")
        _configure(control, _SIOCSIFADDR, _DEVICE, _sockaddr(address))
        _configure(control, _SIOCSIFNETMASK, _DEVICE, _sockaddr("255.255.255.255"))
        _up(control, _DEVICE)
        _route_all(control, _DEVICE)
    return tap


def _configure(control: socket.socket, request: int, device: bytes, value: bytes) -> None:
    fcntl.ioctl(control, request, struct.pack("16s24s", device, value))


def _up(control: socket.socket, device: bytes) -> None:
    _configure(control, _SIOCSIFFLAGS, device, struct.pack("H", _IFF_UP))


def _sockaddr(address: str) -> bytes:
    return struct.pack("HH4s8x", socket.AF_INET, 0, socket.inet_aton(address))


def _route_all(control: socket.socket, device: bytes) -> None:
    """Route all addresses to the device: there is no gateway, every host is on the link."""
    name = ctypes.create_string_buffer(device)
    anywhere = _sockaddr("0.0.0.0")
    entry = struct.pack(  # struct rtentry of linux/route.h
        "@L16s16s16sHhLPhPLLH",
        *(0, anywhere, anywhere, anywhere, _RTF_UP, 0, 0, 0, 0, ctypes.addressof(name), 0, 0, 0),
    )
    fcntl.ioctl(control, _SIOCADDRT, entry)

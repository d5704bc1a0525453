"""A network namespace whose traffic goes through a file, by a TUN device that is open there."""

import ctypes
import fcntl
import os
import socket
import struct

_DEVICE, _LOOPBACK = b"tun", b"lo"
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
_SIOCADDRT, _SIOCSIFFLAGS, _SIOCSIFADDR = 0x890B, 0x8914, 0x8916
_IFF_UP, _RTF_UP = struct.pack("H", 0x1), 0x1
_CLONE_NEWNET = 0x40000000


def enter_new_network(address: str) -> int:
    """Move this process to a new network namespace, where it has an IPv4 address.

    That lasts as long as its TUN device is open; `OSError` if it cannot be created.

    Returns:
        The file descriptor where each read is an IP packet that is sent there, to whatever address,
        and each write one that arrives.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(_CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, _TUNSETIFF, struct.pack("16sH22x", _DEVICE, _IFF_TUN | _IFF_NO_PI))
    name, anywhere = ctypes.create_string_buffer(_DEVICE), _sockaddr("0.0.0.0")
    route = struct.pack(  # struct rtentry of linux/route.h
        "@L16s16s16sHhLPhPLLH",
        *(0, anywhere, anywhere, anywhere, _RTF_UP, 0, 0, 0, 0, ctypes.addressof(name), 0, 0, 0),
    )
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        for request, device, value in (
            (_SIOCSIFFLAGS, _LOOPBACK, _IFF_UP),
            (_SIOCSIFADDR, _DEVICE, _sockaddr(address)),
            (_SIOCSIFFLAGS, _DEVICE, _IFF_UP),
        ):
            fcntl.ioctl(control, request, struct.pack("16s24s", device, value))
        fcntl.ioctl(control, _SIOCADDRT, route)
    return tun


def _sockaddr(address: str) -> bytes:
    return struct.pack("HH4s8x", socket.AF_INET, 0, socket.inet_aton(address))

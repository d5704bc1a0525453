"""What comes from the bus: a key and bytes, whatever the bus is made of."""

from typing import NamedTuple

import zenoh

from runtime.wire.packing import LARGEST

_OVERSIZE = bytes(LARGEST + 1)  # stands for what is too large to be looked at


class Sample(NamedTuple):
    """One message as it arrives: its key, and the bytes."""

    key: str
    data: bytes


def sample_of(sample: zenoh.Sample, key: str | None = None) -> Sample:
    """Return what a sample of Zenoh's holds; where its key is known, it need not be asked."""
    # in a third of the time that the class takes
    return tuple.__new__(Sample, (key or str(sample.key_expr), data_of(sample.payload)))


def data_of(payload: zenoh.ZBytes) -> bytes:
    """Return the bytes of a payload, or as many as are certainly too many."""
    return payload.to_bytes() if len(payload) <= LARGEST else _OVERSIZE

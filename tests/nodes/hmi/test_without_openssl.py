"""What is imported without OpenSSL does not load it, and works; the rest of the process has it."""

import subprocess
import sys

PAGE = """
import sys
from nodes.hmi.page import Page
from nodes.hmi.without_openssl import without_openssl

def loaded():
    return [name for name in ("_hashlib", "_ssl") if name in sys.modules]

with without_openssl():
    import nodes.hmi.serving
print(loaded())

from websockets.utils import accept_key
print(accept_key("dGhlIHNhbXBsZSBub25jZQ=="))

import ssl
print(loaded(), bool(ssl.create_default_context()))
"""
CLASS = """
import sys
from nodes.hmi.page import Page
print({"asyncio", "hashlib", "ssl", "websockets"} & set(sys.modules))
"""


def printed(code: str) -> list[str]:
    """Run code in a Python of its own, and return the lines that it prints."""
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def test_a_page_that_encrypts_nothing_does_not_load_openssl() -> None:
    assert printed(PAGE) == [
        "[]",
        "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=",  # the example of RFC 6455, section 1.3
        "['_ssl'] True",
    ]


def test_the_class_of_the_page_loads_no_server_in_processes_that_only_know_it() -> None:
    assert printed(CLASS) == ["set()"]

"""Files as they come with a form."""

from __future__ import annotations


class Sent:
    """A file that came with a form."""

    def __init__(self, name: str, content: bytes = b"1,2,3\n"):
        self.name, self.content = name, content

    def getbuffer(self) -> memoryview:
        return memoryview(self.content)

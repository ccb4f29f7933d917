from typing import Any

UNPICKLE: int

class Direct:
    count: int
    def __call__(self, *arguments: Any, **named: Any) -> Any: ...
    def add(
        self, codes: bytes, values: int, classes: tuple[type, ...], address: int
    ) -> None: ...

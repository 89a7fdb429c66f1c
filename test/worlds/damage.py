"""How the tests of loaders damage what they give them."""

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

FEW = settings(
    deadline=None,
    max_examples=120,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
pieces = st.one_of(
    st.binary(max_size=6),
    st.sampled_from([b"-1", b"nan", b"1e999", b"[]", b"{}", b": ", b"\n- ", b"null", b"'", b"\0"]),
    st.integers(-(10**12), 10**12).map(lambda n: str(n).encode()),
)


def damaged(data, content: bytes) -> bytes:
    """With some pieces replaced by others."""
    found = bytearray(content)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(found)))
        found[at : at + data.draw(st.integers(0, 10))] = data.draw(pieces)
    return bytes(found)

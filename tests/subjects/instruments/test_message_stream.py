"""Messages found in bytes that come in pieces, with foreign bytes between them, or with bytes missing."""

from hypothesis import given
from hypothesis import strategies as st

from irtiming.gateware.messages import RecordMessage, ReplyMessage, pack_record, pack_reply
from irtiming.instruments.generator.message_stream import MessageStream

REPLIES = st.builds(
    ReplyMessage,
    refusal=st.integers(0, 5), tag=st.integers(0, 255), address=st.integers(0, 255), value=st.integers(0, 2**32 - 1),
)  # fmt: skip
RECORDS = st.builds(
    RecordMessage,
    channels=st.integers(0, 127), number=st.integers(0, 2**16 - 1), time_ticks=st.integers(0, 2**48 - 1),
    is_after_loss=st.booleans(),
)  # fmt: skip
MESSAGES = st.lists(st.one_of(REPLIES, RECORDS), max_size=8)
HARMLESS = st.binary(max_size=6).map(lambda data: data.replace(b"\x5a", b"").replace(b"\xc3", b""))


def _packed(message: ReplyMessage | RecordMessage) -> bytes:
    return pack_reply(message) if isinstance(message, ReplyMessage) else pack_record(message)


@given(MESSAGES, st.lists(st.integers(1, 30), min_size=1), st.data())
def test_every_message_is_found_however_the_bytes_are_cut(messages, lengths, data):
    """Oracle: the messages that were packed, with bytes between them that start none, cut into pieces of any lengths."""
    gaps = [data.draw(HARMLESS) for _ in messages]
    line = b"".join(gap + _packed(message) for gap, message in zip(gaps, messages, strict=True))
    stream, found = MessageStream(), []
    while line:
        piece, line = line[: lengths[0]], line[lengths[0] :]
        lengths = [*lengths[1:], lengths[0]]
        found += stream.feed(piece)
    assert found == messages
    assert stream.skipped_bytes == sum(map(len, gaps))


def test_a_byte_that_changes_costs_one_message():
    """Oracle: the CRC-16 finds every burst of up to 16 bits, so each change of any one byte of ten records, by trial."""
    records = [RecordMessage(channels=9, number=n, time_ticks=1000 * n + 195, is_after_loss=False) for n in range(10)]
    line = b"".join(map(pack_record, records))
    for at in range(len(line)):
        hurt = line[:at] + bytes([line[at] ^ (1 + at * 7 % 255)]) + line[at + 1 :]
        left = [record for number, record in enumerate(records) if number != at // 12]
        assert MessageStream().feed(hurt + bytes(12)) == left


def test_a_byte_that_is_dropped_costs_one_message():
    """Oracle: ten records without any one of their bytes, by trial; the next one begins within the length of the last."""
    records = [RecordMessage(channels=9, number=n, time_ticks=1000 * n + 195, is_after_loss=False) for n in range(10)]
    line = b"".join(map(pack_record, records))
    for at in range(len(line)):
        left = [record for number, record in enumerate(records) if number != at // 12]
        assert MessageStream().feed(line[:at] + line[at + 1 :] + bytes(12)) == left


def test_a_stray_start_byte_holds_a_reply_back_until_the_next_one():
    """Oracle: by hand; 1 + 10 bytes are no record of 12 yet, the next reply settles it."""
    first, second = (ReplyMessage(refusal=0, tag=t, address=17, value=t) for t in (1, 2))
    stream = MessageStream()
    assert stream.feed(b"\xc3" + pack_reply(first)) == []
    assert stream.feed(pack_reply(second)) == [first, second]
    assert stream.skipped_bytes == 1

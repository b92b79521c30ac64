"""Datagrams of the camera alone: a forged one, from another address, is let go."""

import socket

import pytest

from irtiming.instruments.genicam.gige_datagrams import ManyAtOnce, OneByOne


@pytest.mark.parametrize("reader", [OneByOne, ManyAtOnce])
def test_what_others_send_is_let_go(reader):
    """Oracle: by hand; packets of two senders by turns, told apart by what is in them."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as camera,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger,
    ):
        here.bind(("127.0.0.1", 0))
        camera.bind(("127.0.0.2", 0))
        stranger.bind(("127.0.0.3", 0))
        taken = reader(here, slot_bytes=64, sender="127.0.0.2")
        for i in range(10):
            stranger.sendto(b"forged" * (1 + i % 3), here.getsockname())
            camera.sendto(b"frame %d" % i, here.getsockname())
        found = []
        while count := taken.receive():
            found += [taken.packets[i, : taken.lengths[i]].tobytes() for i in range(count)]
        assert found == [b"frame %d" % i for i in range(10)]
        for _ in range(5):
            stranger.sendto(b"forged", here.getsockname())
        assert taken.receive() == 0

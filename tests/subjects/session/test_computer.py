"""What a computer is held against, on files that stand in for those of the system."""

from irtiming.session import computer


def test_the_receive_buffer_is_held_against_what_a_camera_wants(tmp_path):
    """Oracle: 16 MiB, and the words; no limit where the system tells none."""
    limit = tmp_path / "rmem_max"
    limit.write_text("212992\n")
    small = computer._receive_buffer(limit)
    assert (small.status, small.found) == ("warning", "at most 0.2 MiB (net.core.rmem_max)")
    assert small.cure == "a GigE camera wants 16 MiB: sudo sysctl -w net.core.rmem_max=16777216"
    limit.write_text("16777216\n")
    assert computer._receive_buffer(limit).status == "ok"
    assert computer._receive_buffer(tmp_path / "none").status == "ok"


def test_ethernet_interfaces_are_held_against_what_a_camera_wants(tmp_path):
    """Oracle: by hand, for files like those of Linux: a fast one with large packets, one with small, a slow one, others."""
    for name, (kind, state, mtu, speed) in {
        "eth0": ("1", "up", "9000", "1000"), "eth1": ("1", "up", "1500", "10000"), "eth2": ("1", "up", "1500", "100"),
        "eth3": ("1", "down", "1500", ""), "lo": ("772", "unknown", "65536", ""),
    }.items():  # fmt: skip
        (tmp_path / name).mkdir()
        for file, text in (("type", kind), ("operstate", state), ("mtu", mtu), ("speed", speed)):
            (tmp_path / name / file).write_text(text + "\n")
    found = {check.part: check for check in computer._interfaces(tmp_path)}
    assert list(found) == ["network eth0", "network eth1", "network eth2"]
    assert [check.status for check in found.values()] == ["ok", "warning", "warning"]
    assert "sudo ip link set eth1 mtu 9000" in found["network eth1"].cure
    assert found["network eth2"].cure == "a GigE camera needs 1000 Mbit/s; see to cable and switch"

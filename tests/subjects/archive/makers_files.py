"""Small files as makers' programs write them, by hand after their descriptions, or by libraries of others."""

import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np

FRAMES = np.random.default_rng(5).integers(0, 2**14, (5, 24, 32), dtype=np.uint16)
N, ROWS, COLUMNS = FRAMES.shape
TIMES_S = 45_000.25 + 0.0312 * np.arange(N)


def ptw(path: Path) -> None:
    """PTW after the Altair reference guide; times of day."""
    head = bytearray(3476)
    head[:10] = b"CED\0\0" + b"5.60\0"
    struct.pack_into("<5I", head, 11, 3476, 1016, (1016 + 2 * ROWS * COLUMNS) // 2, ROWS * COLUMNS, N)
    struct.pack_into("<H6B", head, 35, 2024, 23, 11, 30, 12, 0, 0)
    head[44:48], head[220:226] = b"Jade", b"012275"
    struct.pack_into("<3H", head, 377, COLUMNS, ROWS, 14)
    struct.pack_into("<2f", head, 403, 0.0312, 250e-6)
    content = bytes(head)
    for time_s, frame in zip(TIMES_S, FRAMES, strict=True):
        own = bytearray(1016)
        whole, micro = divmod(round(time_s * 1e6), 10**6)
        own[80:84] = bytes([whole // 60 % 60, whole // 3600, micro // 10_000, whole % 60])
        own[160] = micro // 1000 % 10
        struct.pack_into("<H", own, 161, micro % 1000)
        content += bytes(own) + frame.astype("<u2").tobytes()
    path.write_bytes(content)


def irb(path: Path) -> None:
    """IRB with two pictures, one packed by runs; temperatures lie between places of a table."""
    table = np.linspace(250, 505, 256).astype("<f4")
    blocks, data = b"", b""
    for number, frame in enumerate(FRAMES[:2]):
        packing = number
        head = bytearray(1728)
        struct.pack_into("<4H", head, 0, 2, packing, COLUMNS, ROWS)
        head[60:1084] = table.tobytes()
        head[1226:1234] = b"VARIOCAM"
        head[1270:1277] = b"1214718"
        struct.pack_into("<dI", head, 1624, 45_000.5, 40 * number)
        low, high = (frame & 255).astype("u1").ravel(), (frame >> 8).astype("u1").ravel()
        runs = b"".join(bytes([1, one]) for one in high)
        body = low.tobytes() + runs if packing else frame.astype("<u2").tobytes()
        blocks += struct.pack("<8I", 1, 101, number + 1, 64 + 64 + len(data), len(head) + len(body), 0, 0, 0)
        data += bytes(head) + body
    start = b"\xffIRB\0" + b"IRBIS 3\0" + bytes(8) + struct.pack("<3I", 100, 64, 2) + bytes(31)
    path.write_bytes(start + blocks + data)


def irb_temperatures() -> np.ndarray:
    """What these pictures show, K: the table rises by 1 K, so the count divided by 256 is what is above 250 K."""
    return 250 + FRAMES[:2] / 256


def fff(order: str, packing: str = "") -> bytes:
    """One FFF after ExifTool's tables; the picture plain, as PNG or as JPEG-LS."""
    import imagecodecs

    raw = struct.pack(f"{order}3H", 2, COLUMNS, ROWS).ljust(32, b"\0")
    match packing:
        case "png":
            raw += imagecodecs.png_encode(FRAMES[0].byteswap())
        case "jpeg-ls":
            raw += imagecodecs.jpegls_encode(FRAMES[0])
        case _:
            raw += FRAMES[0].astype(f"{order}u2").tobytes()
    info = bytearray(0x500)
    struct.pack_into(f"{order}H", info, 0, 2)
    struct.pack_into(f"{order}f", info, 0x58, 15_000.0)
    info[0xD4:0xD8], info[0x104:0x108] = b"A655", b"0815"
    struct.pack_into(f"{order}2I", info, 0x384, 1_541_416_483, 84)
    struct.pack_into(f"{order}H", info, 0x464, 50)
    records = [(1, 0, raw), (32, 0, bytes(info))]
    place = 64 + 32 * len(records)
    directory, data = b"", b""
    for kind, sub, content in records:
        directory += struct.pack(f"{order}2H7I", kind, sub, 100, 1, place + len(data), len(content), 0, 0, 0)
        data += content
    head = b"FFF\0" + b"irtiming-test\0\0\0" + struct.pack(f"{order}3I", 100, 64, len(records))
    return head.ljust(64, b"\0") + directory + data


def sfmov(path: Path) -> None:
    """SFMOV as pysfmov reads it."""
    text = f"SFMOV test\nxPixls {COLUMNS}\nyPixls {ROWS}\nNumDPs {N}\nDaType UInt16\nsaf_padding 000\nDATA\r\n"
    path.write_bytes(text.encode() + FRAMES.astype("<u2").tobytes())


def norpix(path: Path) -> None:
    """Norpix SEQ with a time behind each picture."""
    head = bytearray(1024)
    image_bytes = 2 * ROWS * COLUMNS
    struct.pack_into("<I", head, 0, 0xFEED)
    struct.pack_into("<2i", head, 28, 3, 1024)
    struct.pack_into("<9I", head, 548, COLUMNS, ROWS, 16, 14, image_bytes, 100, N, 0, image_bytes + 20)
    struct.pack_into("<d", head, 584, 32.0)
    content = bytes(head)
    for i, frame in enumerate(FRAMES):
        stamp = struct.pack("<I2H", 1_700_000_000 + i, 250, 17)
        content += frame.astype("<u2").tobytes() + stamp.ljust(20, b"\0")
    path.write_bytes(content)


def hcc(path: Path) -> None:
    """HCC by fasthcc."""
    from fasthcc import HCCWriter

    with HCCWriter(path, COLUMNS, ROWS, calibration_mode=0, exposure_time=250.0, frame_rate=40.0) as writer:
        for i, frame in enumerate(FRAMES):
            writer.write_frame(frame, {"POSIXTime": 1_700_000_000 + i, "SubSecondTime": 2_500_000, "FrameID": 10 + i})


def fits(path: Path) -> None:
    """FITS by astropy."""
    from astropy.io import fits as astropy_fits

    hdu = astropy_fits.PrimaryHDU(FRAMES)
    hdu.header["EXPTIME"], hdu.header["INSTRUME"], hdu.header["DATE-OBS"] = 250e-6, "Hawk", "2026-11-23T12:00:00"
    hdu.writeto(path)


def video(path: Path) -> None:
    """FFV1 by PyAV."""
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = COLUMNS, ROWS, "gray16le"
        stream.time_base = Fraction(1, 1000)
        for i, values in enumerate(FRAMES):
            frame = av.VideoFrame.from_ndarray(values, format="gray16le")
            frame.pts, frame.time_base = 40 * i, Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


WRITERS: dict[str, Callable[[Path], object]] = {
    "a.ptw": ptw,
    "a.irb": irb,
    "a.fff": lambda path: path.write_bytes(fff(">")),
    "b.fff": lambda path: path.write_bytes(fff("<", "png")),
    "a.seq": lambda path: path.write_bytes(fff("<") + fff(">") + bytes(40) + fff("<")),
    "a.csq": lambda path: path.write_bytes(fff("<", "jpeg-ls") * 2),
    "a.sfmov": sfmov,
    "norpix.seq": norpix,
    "a.hcc": hcc,
    "a.fits": fits,
    "a.mkv": video,
    "a.avi": video,
}


def expected(name: str) -> np.ndarray:
    """Frames that a file of that name holds, shape (frame, row, column)."""
    repeats = {"a.fff": 1, "b.fff": 1, "a.seq": 3, "a.csq": 2}
    if name in repeats:
        return np.repeat(FRAMES[:1], repeats[name], axis=0)
    return irb_temperatures() if name == "a.irb" else FRAMES

"""The programs of programs.pio as the chip takes them. Made by scripts/assemble-pio; a test holds it against that text."""

EDGES = {
    "code": (
        0xA02B,  # mov x, ~null
        0xA04B,  # mov y, ~null
        0x0012,  # jmp low
        0x403F,  # in x, 31
        0x4041,  # in y, 1
        0x8000,  # push noblock
        0x0047,  # jmp x-- rose_1
        0x0048,  # jmp x-- rose_2
        0x0049,  # jmp x-- count_high
        0x004A,  # jmp x-- high
        0x00C9,  # jmp pin count_high
        0x403F,  # in x, 31
        0x4061,  # in null, 1
        0x8000,  # push noblock
        0x004F,  # jmp x-- fell_1
        0x0050,  # jmp x-- fell_2
        0x0051,  # jmp x-- count_low
        0x0052,  # jmp x-- low
        0x00C3,  # jmp pin rose
    ),
    "wrap_target": 17,
    "wrap": 18,
    "side_set": 0,
    "status_n": 0,
    "labels": {},
}

TRAIN = {
    "code": (
        0x80A0,  # pull block side 0
        0xA0C7,  # mov isr, osr side 0
        0x80A0,  # pull block side 0
        0xA047,  # mov y, osr side 0
        0x80A0,  # pull block side 0
        0xA027,  # mov x, osr side 0
        0x80A0,  # pull block side 0
        0x0147,  # jmp x-- delay side 0 [1]
        0xA025,  # mov x, status side 0
        0x0030,  # jmp !x done side 0
        0xB126,  # mov x, isr side 1 [1]
        0x114B,  # jmp x-- active side 1 [1]
        0xA127,  # mov x, osr side 0 [1]
        0x0170,  # jmp !y done side 0 [1]
        0x014E,  # jmp x-- idle side 0 [1]
        0x0188,  # jmp y-- pulse side 0 [1]
        0x0010,  # jmp done side 0
    ),
    "wrap_target": 0,
    "wrap": 16,
    "side_set": 1,
    "status_n": 1,
    "labels": {"active": 11, "done": 16},
}

CHOPPER = {
    "code": (
        0x80A0,  # pull block side 0
        0xA0C7,  # mov isr, osr side 0
        0x80A0,  # pull block side 0
        0xA047,  # mov y, osr side 0
        0xB126,  # mov x, isr side 1 [1]
        0x1145,  # jmp x-- active side 1 [1]
        0xA122,  # mov x, y side 0 [1]
        0x0147,  # jmp x-- idle side 0 [1]
        0xA025,  # mov x, status side 0
        0x0020,  # jmp !x load side 0
        0x0304,  # jmp pulse side 0 [3]
    ),
    "wrap_target": 0,
    "wrap": 10,
    "side_set": 1,
    "status_n": 2,
    "labels": {},
}

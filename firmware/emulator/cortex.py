"""A Cortex-M4 for stm32g4.mjs: Unicorn executes, and whatever is no memory is asked of the other end of two pipes.

    python3 cortex.py TO_US FROM_US

Orders are 9 bytes: a letter and two words of 32 bits. Answers are four words: what, and three more.

    M address length, then bytes   memory with contents; without, of zeros
    G address                      from a vector table: its stack pointer and its entry
    R count                        runs so many instructions, at the most to the end of a block; gives S
    E address                      enters the exception whose vector lies there
    X                              returns from one, after S said so

    S why, instructions, whether interrupts are masked      0 the count is over or the other end said stop, 1 wfe, 2 the end of an exception, 3 a fault
    L address, bytes, instructions                          a load; one word is awaited: the value
    W address, value, instructions                          a store; one word is awaited: not 0 = stop
"""

import os
import struct
import sys

from unicorn import UC_ARCH_ARM, UC_HOOK_BLOCK, UC_HOOK_CODE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError, arm_const

PAGE = 0x1000
# What a handler's link register says: where nothing is, so that a return is seen.
RETURN = 0x0FFFF001
REGISTERS = [
    getattr(arm_const, f"UC_ARM_REG_{name}") for name in ("R0", "R1", "R2", "R3", "R12", "LR", "PC", "XPSR")
]
SP, LR, PC, XPSR = (getattr(arm_const, f"UC_ARM_REG_{name}") for name in ("SP", "LR", "PC", "XPSR"))
COUNT_OVER, WFE, RETURNED, FAULT = range(4)


class Cortex:
    def __init__(self, orders, answers):
        self.orders, self.answers = orders, answers
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M4)
        for base in (0x40000000, 0x48000000, 0x50000000, 0xE0000000):
            self.uc.mmio_map(base, 0x100000, self.load, base, self.store, base)
        self.uc.mem_map(RETURN & -PAGE, PAGE)
        self.uc.hook_add(UC_HOOK_BLOCK, self.block)
        self.lengths = {}
        self.done = self.limit = 0
        self.event = self.waits = False

    def tell(self, what, *words):
        os.write(self.answers, struct.pack("<IIII", ord(what), *words))

    def hear(self, count):
        data = os.read(self.orders, count)
        while data and len(data) < count:
            data += os.read(self.orders, count - len(data))
        if len(data) < count:
            sys.exit(0)
        return data

    def load(self, uc, offset, size, base):
        self.tell("L", base + offset, size, self.done)
        return int.from_bytes(self.hear(4), "little")

    def store(self, uc, offset, size, value, base):
        self.tell("W", base + offset, value & 0xFFFFFFFF, self.done)
        if self.hear(4) != bytes(4):
            self.limit = 0

    def block(self, uc, address, size, _):
        if self.done >= self.limit:
            uc.emu_stop()
            return
        if (address, size) not in self.lengths:
            code, at, count = bytes(uc.mem_read(address, size)), 0, 0
            while at < size:
                at += 4 if code[at + 1] >> 3 in (0b11101, 0b11110, 0b11111) else 2
                count += 1
            self.lengths[address, size] = count
        self.done += self.lengths[address, size]

    def wfe(self, uc, address, size, _):
        self.waits = True
        uc.emu_stop()

    def sev(self, uc, address, size, _):
        self.event = True

    def memory(self, address, length):
        data = self.hear(length)
        begin, end = address & -PAGE, -(-(address + length) // PAGE) * PAGE
        try:
            self.uc.mem_map(begin, end - begin)
        except UcError:
            pass  # A page that another part has brought.
        self.uc.mem_write(address, data)
        for at in range(address & 1, length - 1, 2):
            hint = data[at : at + 2]
            if hint in (b"\x20\xbf", b"\x40\xbf"):
                place = address + at
                self.uc.hook_add(UC_HOOK_CODE, self.wfe if hint[0] == 0x20 else self.sev, begin=place, end=place)

    def run(self, count):
        self.done, self.limit, why = 0, count, None
        while why is None:
            self.waits = False
            try:
                self.uc.emu_start(self.uc.reg_read(PC) | 1, RETURN - 1)
            except UcError as error:
                print(f"cortex: {error} at {self.uc.reg_read(PC):#x}", file=sys.stderr)
                why = FAULT
                break
            if self.waits:
                # Unicorn does not execute it.
                self.uc.reg_write(PC, self.uc.reg_read(PC) + 2 | 1)
                why = None if self.event else WFE
                self.event = False
            else:
                why = RETURNED if self.uc.reg_read(PC) == RETURN - 1 else COUNT_OVER
        self.tell("S", why, self.done, self.uc.reg_read(arm_const.UC_ARM_REG_PRIMASK) & 1)

    def enter(self, vector):
        sp = self.uc.reg_read(SP)
        frame = [self.uc.reg_read(register) for register in REGISTERS]
        # Where the stack was not aligned to eight bytes, bit 9 says so.
        frame[-1] = frame[-1] & ~0x200 | (sp & 4) << 7
        at = (sp & ~7) - 32 if sp & 4 else sp - 32
        self.uc.mem_write(at, struct.pack("<8I", *frame))
        self.uc.reg_write(SP, at)
        self.uc.reg_write(LR, RETURN)
        self.uc.reg_write(XPSR, 1 << 24)
        self.uc.reg_write(PC, self.word(vector) | 1)
        self.event = True

    def leave(self):
        sp = self.uc.reg_read(SP)
        *frame, status = struct.unpack("<8I", bytes(self.uc.mem_read(sp, 32)))
        self.uc.reg_write(SP, sp + 32 + (4 if status & 0x200 else 0))
        self.uc.reg_write(XPSR, status & ~0x200 | 1 << 24)
        for register, value in zip(REGISTERS, frame):
            self.uc.reg_write(register, value | 1 if register == PC else value)
        self.event = True

    def word(self, address):
        return int.from_bytes(self.uc.mem_read(address, 4), "little")

    def serve(self):
        while True:
            order, one, two = struct.unpack("<cII", self.hear(9))
            if order == b"M":
                self.memory(one, two)
            elif order == b"G":
                self.uc.reg_write(SP, self.word(one))
                self.uc.reg_write(PC, self.word(one + 4) | 1)
            elif order == b"R":
                self.run(one)
            elif order == b"E":
                self.enter(one)
            elif order == b"X":
                self.leave()


if __name__ == "__main__":
    Cortex(os.open(sys.argv[1], os.O_RDONLY), os.open(sys.argv[2], os.O_WRONLY)).serve()

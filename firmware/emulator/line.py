"""A pseudo-terminal with a link to it: what the driver opens. Bytes from it go to stdout, those of stdin to it."""

import os
import pty
import select
import sys
import tty

link = sys.argv[1]
master, slave = pty.openpty()  # The slave stays open here: so the driver may come and go.
tty.setraw(slave)
if os.path.islink(link):
    os.unlink(link)
os.symlink(os.ttyname(slave), link)
try:
    while True:
        for ready in select.select([0, master], [], [])[0]:
            data = os.read(ready, 4096)
            if not data:
                sys.exit(0)
            os.write(1 if ready == master else master, data)
finally:
    os.unlink(link)

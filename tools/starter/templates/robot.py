"""Moves the wires of RIG_NAME one after the other, and prints where they get.

    python3 robot.py        # beside a running driver, or with one of its own

The package is sinew's for Python: `pip install` its wheel (docs/python.md).
"""

import sinew

RIG, RIG_FILE = "RIG_NAME", "RIG_NAME.toml"


def robot(rig: sinew.Rig) -> None:
    for channel in rig:
        with rig.lease(0.5) as lease:  # what is set in here holds half a second beyond its last renewal, and goes off at the end
            for stroke in (0.4, 0.1):  # 0: cold and long, 1: hot and short
                channel.stroke = stroke
                lease.sleep(2.0)  # sleeps, and renews meanwhile
                rig.check()  # raises what has gone wrong, with what to do about it
                print(f"{channel.name}: {100 * channel.stroke:.0f} % of {100 * stroke:.0f} %, about {channel.temperature_c:.0f} °C")


if __name__ == "__main__":
    try:
        rig = sinew.connect(RIG)
    except sinew.NotRunning:
        rig = sinew.run(RIG_FILE)
    with rig:
        robot(rig)

#!/usr/bin/env python3
"""A robot program on another machine: watches a rig over Zenoh, counts what it has lost, and moves a wire if it may.

    pip install eclipse-zenoh numpy

    sinew run                                     # the driver, on simulated wires
    sinew-zenoh                                   # the bridge
    python3 examples/over_zenoh.py hexapod

    sinew-zenoh certificates keys anna            # to command
    sinew-zenoh --certificates keys --commander anna
    python3 examples/over_zenoh.py hexapod --connect quic/127.0.0.1:7447 --certificates keys --commander anna --move front_left_coxa
"""

import argparse
import json
import math
import time

import numpy as np
import zenoh


def settings(args):
    config = zenoh.Config()
    tls = "transport/link/tls/"
    pairs = {
        "mode": "client",
        "connect/endpoints": [args.connect],
        "scouting/multicast/enabled": False,
        # the bridge takes this program for dead after a second without a word
        "transport/link/tx/lease": 1000,
    }
    if args.certificates:
        pairs[tls + "root_ca_certificate"] = f"{args.certificates}/authority.pem"
        pairs[tls + "connect_certificate"] = f"{args.certificates}/{args.commander}.pem"
        pairs[tls + "connect_private_key"] = f"{args.certificates}/{args.commander}.key"
        pairs[tls + "enable_mtls"] = True
    for key, value in pairs.items():
        config.insert_json5(key, json.dumps(value))
    return config


def ask(session, key, request=None):
    """The answer to a query, or an error with what is amiss."""
    for reply in session.get(key, payload=None if request is None else json.dumps(request)):
        if reply.ok is not None:
            return json.loads(reply.ok.payload.to_string())
        raise SystemExit(f"{key}: {reply.err.payload.to_string()}")
    raise SystemExit(f"{key}: nobody answers")


class Cycles:
    """Every cycle as a NumPy record, and how many were lost on the way."""

    def __init__(self, info):
        # CDR: four bytes of its own, number, time and missed periods, then each channel's fields one behind the other
        types = {"f64": "<f8", "u32": "<u4"}
        self.channel = np.dtype([(field["name"], types[field["type"]]) for field in info["fields"]])
        self.received = self.lost = 0
        self.number = None
        self.latest = None

    def __call__(self, sample):
        number = int.from_bytes(sample.attachment.to_bytes()[:8], "little")
        if self.number is not None:
            self.lost += number - self.number - 1
        self.number = number
        self.received += 1
        self.latest = np.frombuffer(sample.payload.to_bytes(), self.channel, offset=28)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rig")
    parser.add_argument("--connect", default="tcp/127.0.0.1:7447", metavar="ENDPOINT")
    parser.add_argument("--certificates", metavar="FOLDER")
    parser.add_argument("--commander", default="anna", metavar="NAME")
    parser.add_argument("--move", metavar="CHANNEL")
    parser.add_argument("--seconds", type=float, default=5.0)
    args = parser.parse_args()

    with zenoh.open(settings(args)) as session:
        info = ask(session, f"sinew/{args.rig}/info")
        if info["state"] == "gone":
            raise SystemExit(f"no driver of {args.rig} runs: start it with `sinew run`")
        names = [channel["name"] for channel in info["channels"]]
        print(f"{args.rig}: {len(names)} channels at {info['rate_hz']} Hz")
        cycles = Cycles(info)
        session.declare_subscriber(f"sinew/{args.rig}/cycles", cycles)
        watched = names.index(args.move) if args.move else 0
        if args.move:
            # as long as this is declared the commander is there; when it goes, what he holds is put off
            alive = session.liveliness().declare_token(f"sinew/{args.rig}/commander/{args.commander}/alive")
        began = told = time.monotonic()
        while (passed := time.monotonic() - began) < args.seconds:
            if args.move:
                stroke = 0.2 - 0.2 * math.cos(2 * math.pi * passed / 4)
                request = {"call": "set", "channel": args.move, "kind": "stroke", "value": stroke, "hold_s": 0.5}
                ask(session, f"sinew/{args.rig}/commander/{args.commander}/command", request)
            time.sleep(0.05)
            if cycles.latest is not None and time.monotonic() - told >= 0.5:
                told = time.monotonic()
                state = cycles.latest[watched]
                print(f"{names[watched]} {state['length_m'] * 1e3:.3f} mm  duty {state['duty']:.3f}  {state['temperature_c']:.1f} °C")
        print(f"{cycles.received} cycles, {cycles.lost} lost on the way")
        if args.move:
            alive.undeclare()


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""A poor line between two network namespaces, in user space: IP packets are lost, delayed, cut.

line.py NAMESPACE_A NAMESPACE_B SEED LOSS_PERCENT DELAY_MS CUT_FROM_S CUT_TO_S

Makes two TUN devices, moves one into each namespace (10.91.0.1 and 10.91.0.2) and carries what the
kernel sends into one to the other. Writes `ready` once both are up. Seconds of the cut count from
the first line on standard input. Ends with standard input.
"""

import fcntl, heapq, os, random, select, struct, subprocess, sys, time

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000


def device(name, namespace, own, other):
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH", name.encode(), IFF_TUN | IFF_NO_PI))
    run = lambda *words: subprocess.run(["ip", *words], check=True)
    run("link", "set", "dev", name, "netns", namespace)
    run("-n", namespace, "addr", "add", own, "peer", other, "dev", name)
    run("-n", namespace, "link", "set", "dev", name, "up")
    return tun


def main():
    a, b, seed, loss, delay, cut_from, cut_to = sys.argv[1:]
    dice, loss, delay = random.Random(int(seed)), float(loss) / 100, float(delay) / 1000
    cut_from, cut_to = float(cut_from), float(cut_to)
    pid = os.getpid()
    ends = [
        device(f"oba{pid}", a, "10.91.0.1", "10.91.0.2"),
        device(f"obb{pid}", b, "10.91.0.2", "10.91.0.1"),
    ]
    print("ready", flush=True)
    under_way, count, dropped, began = [], 0, 0, None
    while True:
        now = time.monotonic()
        while under_way and under_way[0][0] <= now:
            _, _, to, packet = heapq.heappop(under_way)
            os.write(ends[to], packet)
        wait = max(0.0, under_way[0][0] - now) if under_way else 1.0
        ready, _, _ = select.select([*ends, 0], [], [], wait)
        now = time.monotonic()
        if 0 in ready:
            if not os.read(0, 100):
                break
            began = now
        since = now - began if began is not None else -1.0
        for end in (0, 1):
            if ends[end] not in ready:
                continue
            packet = os.read(ends[end], 65536)
            count += 1
            if dice.random() < loss or cut_from <= since < cut_to:
                dropped += 1
            else:
                heapq.heappush(under_way, (now + delay, count, 1 - end, packet))
    print(f"{count} packets, {dropped} dropped", file=sys.stderr)


main()

#!/usr/bin/env python3
"""Simulates a picture on many machines: `scripts/simulate_farm.py TIMES.json`.

TIMES.json holds recorded seconds of tasks on one machine, as a list; without it, times are measured with the module
`turner` on a small scene. The simulation scales them so that the whole picture takes `--hours` on all machines, and draws
for each task one of the recorded times, whether its machine fails meanwhile, and whether the machine is slow.

    utilisation = useful work / (machines x time until the picture is done)

Useful work is that of the tasks that count; loading, repeated and lost work do not.
"""

import argparse
import heapq
import json
import random


def measured():
    """Seconds of 64 parts of a scene, each on one thread."""
    import time

    import turner as tr

    scene = tr.Scene(
        objects=[tr.Sphere(center=(0, 1, 0)), tr.Plane()],
        lights=[tr.EnvironmentLight()],
        integrator="path",
        film=tr.Film(width=320, height=240),
    )
    times = []
    for part in range(64):
        renderer = tr.Renderer(scene, 1024, threads=1)
        begun = time.perf_counter()
        renderer.run(part * 16 + 16, first=part * 16)
        renderer.film()
        times.append(time.perf_counter() - begun)
    return times


def simulate(times, *, machines, parts, hours, failures, stragglers, slowness, loading, merging, seed):
    """The utilisation, the hours that the picture takes, and the tasks that ran twice."""
    rng = random.Random(seed)
    mean = sum(times) / len(times)
    scale = hours * 3600 * machines / parts / mean
    slow = {m for m in range(machines) if rng.random() < stragglers}
    # (time when it is free, machine); all load the scene first.
    free = [(loading * rng.uniform(0.8, 1.5), m) for m in range(machines)]
    heapq.heapify(free)
    waiting, useful, repeated, ends = list(range(parts)), 0.0, 0, []
    running = []
    while waiting or running:
        if not waiting:
            # The tasks that are left: the last of slow machines. Nothing is started twice, as a queue does without hints.
            end, lost = heapq.heappop(running)
            if lost is not None:
                waiting.append(lost)
            continue
        now, machine = heapq.heappop(free)
        while running and running[0][0] <= now:
            _, lost = heapq.heappop(running)
            if lost is not None:
                waiting.append(lost)
        task = waiting.pop()
        work = rng.choice(times) * scale
        took = work * (slowness if machine in slow else 1.0)
        if rng.random() < failures:
            # The machine fails somewhere in the task, and is replaced after a while.
            at = now + took * rng.random()
            heapq.heappush(running, (at, task))
            heapq.heappush(free, (at + 60 + loading, machine))
            repeated += 1
            continue
        heapq.heappush(running, (now + took, None))
        heapq.heappush(free, (now + took, machine))
        useful += took
        ends.append(now + took)
    # A tree of merges, eight films each.
    depth, count = 0, parts
    while count > 1:
        count, depth = -(-count // 8), depth + 1
    total = max(ends) + depth * merging
    return useful / (machines * total), total / 3600, repeated


def main():
    """Prints the utilisation for several numbers of parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("times", nargs="?", help="recorded seconds of tasks, a JSON list")
    parser.add_argument("--machines", type=int, default=1000)
    parser.add_argument("--hours", type=float, default=10, help="of the picture on all machines together")
    parser.add_argument("--failures", type=float, default=0.02, help="of tasks")
    parser.add_argument("--stragglers", type=float, default=0.05, help="machines that are slow")
    parser.add_argument("--slowness", type=float, default=2.0, help="how much longer slow machines take")
    parser.add_argument("--loading", type=float, default=30, help="seconds to load the scene, once a machine")
    parser.add_argument("--merging", type=float, default=20, help="seconds to merge eight films")
    args = parser.parse_args()
    if args.times:
        with open(args.times, encoding="utf-8") as file:
            times = json.load(file)
    else:
        times = measured()
    spread = max(times) / (sum(times) / len(times))
    print(f"{len(times)} recorded tasks, the longest {spread:.2f} of the mean")
    for each in (1, 4, 16, 64):
        found = [
            simulate(
                times,
                machines=args.machines,
                parts=each * args.machines,
                hours=args.hours,
                failures=args.failures,
                stragglers=args.stragglers,
                slowness=args.slowness,
                loading=args.loading,
                merging=args.merging,
                seed=seed,
            )
            for seed in range(5)
        ]
        worst = min(found)
        print(f"{each:3} parts a machine: utilisation {100 * worst[0]:.1f} %, {worst[1]:.2f} hours, {worst[2]} tasks again")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Prints what peers_bench.sh has measured: python3 peers_table.py RECORDS.tsv FOLDER

RECORDS: a line for each picture: contest, renderer, family of settings, setting, run, seconds, rmse, rmse below the
lamp. FOLDER holds blocks-RENDERER-CONTEST-reference.exr, the means of 20 x 20 squares of the references.
"""

import collections
import math
import os
import statistics
import struct
import sys

BLOCKS = 20  # on each side
MEASURES = ("whole picture", "below the lamp")

Record = collections.namedtuple("Record", "contest renderer family setting run seconds errors")


def read_records(path):
    with open(path, encoding="utf-8") as file:
        for line in file:
            contest, renderer, family, setting, run, seconds, *errors = line.rstrip("\n").split("\t")
            yield Record(contest, renderer, family, setting, int(run), float(seconds), [float(e) for e in errors])


def seconds_at(points, error):
    """Log-log between the neighbours of `error` among (error, seconds), and ""; the fastest point and "at most" where
    that is good enough already; infinity where no point is."""
    points = sorted(points)
    if points[0][0] > error:
        return math.inf, ""
    fastest = min(seconds for own, seconds in points if own <= error)
    for (low, slow), (high, fast) in zip(points, points[1:]):
        if low <= error < high:
            part = math.log(error / low) / math.log(high / low)
            between = math.exp(math.log(slow) + part * math.log(fast / slow))
            return min((between, ""), (fastest, "at most "))
    return fastest, "at most "


def median_seconds(own, records, measure, family):
    """To the error that ours has in the same run."""
    found = []
    for target in own:
        points = [(r.errors[measure], r.seconds) for r in records if r.run == target.run and r.family == family]
        found.append(seconds_at(points, target.errors[measure]))
    return statistics.median(seconds for seconds, _ in found), max(bound for _, bound in found)


def print_contest(contest, records):
    print(f"\n{contest} light, medians of {len({r.run for r in records})} runs in turns")
    print(f"  {'renderer':10}{'setting':34}{'seconds':>9}{'rmse':>11}{'below lamp':>12}")
    for renderer, family, setting in dict.fromkeys((r.renderer, r.family, r.setting) for r in records):
        same = [r for r in records if (r.renderer, r.family, r.setting) == (renderer, family, setting)]
        whole, below = (statistics.median(r.errors[m] for r in same) for m in range(2))
        seconds = statistics.median(r.seconds for r in same)
        print(f"  {renderer:10}{f'{family}={setting}':34}{seconds:9.3f}{whole:11.5f}{below:12.5f}")
    for family, setting in dict.fromkeys((r.family, r.setting) for r in records if r.renderer == "triad"):
        own = [r for r in records if (r.renderer, r.family, r.setting) == ("triad", family, setting)]
        print_peers(f"triad {family}={setting}", own, [r for r in records if r.renderer != "triad"])


def print_peers(name, own, others):
    """How long the others take to the error that ours has."""
    own_s = statistics.median(r.seconds for r in own)
    print(f"  to the rmse of {name}, {own_s:.3f} s")
    for renderer in dict.fromkeys(r.renderer for r in others):
        theirs = [r for r in others if r.renderer == renderer]
        for measure, where in enumerate(MEASURES):
            families = dict.fromkeys(r.family for r in theirs)
            (seconds, bound), family = min((median_seconds(own, theirs, measure, f), f) for f in families)
            text = f"    {where}: {renderer} "
            if math.isinf(seconds):
                print(text + "does not get there with any of these settings")
                continue
            ratio = seconds / own_s
            print(f"{text}{bound}{seconds:.3f} s ({family}): {bound}{ratio:.2f} times as long")


def read_blocks(path):
    """Red, green, blue of an uncompressed float EXR of BLOCKS x BLOCKS pixels: its rows, blue first, end the file."""
    row = struct.Struct(f"<ii{3 * BLOCKS}f")
    with open(path, "rb") as file:
        data = file.read()[-BLOCKS * row.size :]
    return [value for y in range(BLOCKS) for value in row.unpack_from(data, y * row.size)[2:]]


def print_agreement(folder):
    print("\nreferences against triad's: ratio of the means; rms and largest difference of 20 x 20 squares over the mean")
    for contest in ("global", "direct"):
        own = read_blocks(os.path.join(folder, f"blocks-triad-{contest}-reference.exr"))
        mean = statistics.fmean(own)
        for renderer in ("cycles", "povray"):
            path = os.path.join(folder, f"blocks-{renderer}-{contest}-reference.exr")
            if not os.path.exists(path):
                continue
            theirs = read_blocks(path)
            differences = [a - b for a, b in zip(theirs, own)]
            rms = math.sqrt(statistics.fmean(d * d for d in differences)) / mean
            largest = max(map(abs, differences)) / mean
            print(f"  {contest} {renderer}: {statistics.fmean(theirs) / mean:.4f}, {rms:.4f}, {largest:.4f}")


def main():
    records = list(read_records(sys.argv[1]))
    for contest in dict.fromkeys(r.contest for r in records):
        print_contest(contest, [r for r in records if r.contest == contest])
    print_agreement(sys.argv[2])


main()

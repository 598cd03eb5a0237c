"""Part 2 of the lab handout: the first-order response rounded to encoder counts, sampled and differenced.

The angle is handout.py's closed form (first order, viscous friction) in 50-digit arithmetic; the counts are
round(N theta / 2 pi), the speed is (n[k] - n[k-1]) 60 / (N TS) in RPM, none at the first sample. The script
fails where a count lies so near to a half that double precision could round it the other way.

    python handout_sampling.py        writes handout/sampled_ts30.csv and handout/sampled_ts3.csv
"""

from pathlib import Path

import mpmath as mp

from handout import HANDOUT, first_order_step

COUNTS_PER_REV = 720
END_S = mp.mpf("0.3")
NEAREST_TO_A_HALF = mp.mpf("1e-6")


def sampled(ts):
    ts = mp.mpf(ts)
    times = [k * ts for k in range(int(mp.nint(END_S / ts)) + 1)]
    rows, before = [], None
    for t, (speed, angle) in zip(times, first_order_step(HANDOUT, times)):
        position = angle * COUNTS_PER_REV / (2 * mp.pi)
        count = int(mp.floor(position + mp.mpf(1) / 2))
        assert abs(position + mp.mpf(1) / 2 - mp.nint(position + mp.mpf(1) / 2)) > NEAREST_TO_A_HALF, t
        rpm = "" if before is None else mp.nstr((count - before) * 60 / (COUNTS_PER_REV * ts), 17)
        rows.append((mp.nstr(t, 17), count, rpm, mp.nstr(speed * 60 / (2 * mp.pi), 17)))
        before = count
    return rows


def main():
    for name, ts in (("sampled_ts30", "0.03"), ("sampled_ts3", "0.003")):
        path = Path(__file__).parent / "handout" / f"{name}.csv"
        with path.open("w") as out:
            out.write(f"# first order, viscous friction, TS = {ts} s, {COUNTS_PER_REV} counts a revolution; step of 4.5 V\n")
            out.write("t_s,counts,speed_rpm,true_speed_rpm\n")
            for row in sampled(ts):
                out.write(",".join(map(str, row)) + "\n")


if __name__ == "__main__":
    main()

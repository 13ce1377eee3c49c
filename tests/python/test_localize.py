"""sightline.localize: a recorded team from Python."""

import math

import pytest

import sightline as sl


def write_recording(folder):
    """One robot that drives a circle about the origin among three landmarks, without errors."""
    folder.mkdir()
    marks = [(3.0, 0.0), (0.0, 3.0), (-3.0, -1.0)]
    rate, speed, count = 0.2, 0.2, 600
    odometry, truth, seen = "", "", ""
    for k in range(count):
        t = 1000 + 0.05 * k
        psi = rate * 0.05 * k
        x, y = speed / rate * math.sin(psi), -speed / rate * math.cos(psi)
        odometry += f"{t:.3f} {speed} {rate}\n"
        truth += f"{t:.3f} {x:.6f} {y:.6f} {math.remainder(psi, math.tau):.6f}\n"
        for i, (mx, my) in enumerate(marks):
            bearing = math.remainder(math.atan2(my - y, mx - x) - psi, math.tau)
            if k % 5 == 0 and abs(bearing) < 0.8:
                seen += f"{t:.3f} {10 + i} {math.hypot(mx - x, my - y):.6f} {bearing:.6f}\n"
    (folder / "Robot1_Odometry.dat").write_text(odometry)
    (folder / "Robot1_Groundtruth.dat").write_text(truth)
    (folder / "Robot1_Measurement.dat").write_text(seen)
    (folder / "Barcodes.dat").write_text("1 5\n2 10\n3 11\n4 12\n")
    (folder / "Landmark_Groundtruth.dat").write_text(
        "".join(f"{i + 2} {x} {y} 0 0\n" for i, (x, y) in enumerate(marks)))
    return folder


def test_summary_and_files(tmp_path):
    found = sl.localize(write_recording(tmp_path / "recording"), out=tmp_path / "out", seed=2)
    assert found["rmse"] < 0.05 and found["seed"] == 2
    assert found["robots"][0]["sightings"]["accepted"] > 50
    for name in ("summary.json", "report.html", "localize.mcap"):
        assert (tmp_path / "out" / name).stat().st_size > 0


def test_refusals(tmp_path):
    place = write_recording(tmp_path / "recording")
    with pytest.raises(ValueError, match="not there, expected a folder of MRCLAM"):
        sl.localize(tmp_path / "none")
    with pytest.raises(ValueError, match="--anchor = robot7, expected one of robot1"):
        sl.localize(place, out=tmp_path / "out", anchor="robot7")
    with pytest.raises(sl.ScenarioError, match="range_noise"):
        sl.localize(place, out=tmp_path / "out", set=["range_noise=-1"])

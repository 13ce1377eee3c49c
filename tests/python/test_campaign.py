"""Campaigns from Python are those of the command line, and their tables are arrays."""

import signal
import sqlite3
import subprocess
import sys
import time

import matplotlib
import numpy as np
import pytest

import sightline as sl
from sightline import plot

matplotlib.use("Agg")

short = ["campaign.duration=3.0"]


@pytest.fixture
def drawn(scenarios):
    return sl.Scenario.read(scenarios / "cooperative_localization.toml", set=short)


def test_the_table_has_the_rows_of_the_command_line(scenarios, sightline, drawn, tmp_path):
    subprocess.run([*command(scenarios), "--runs", "12", "--seed", "5", "-o", tmp_path / "cli"], capture_output=True, check=False)
    of = sl.campaign(drawn, runs=12, seed=5, out=tmp_path / "python")
    rows = 'SELECT * FROM runs ORDER BY "index"'
    with sqlite3.connect(tmp_path / "cli" / "campaign.sqlite") as database:
        flown = database.execute(rows).fetchall()
    with sqlite3.connect(of.file) as database:
        assert database.execute(rows).fetchall() == flown and len(flown) == len(of) == 12
    assert of.runs["index"].tolist() == list(range(12)) and sum(of.outcomes.values()) == 12
    assert of.runs["min_distance"].dtype == float and set(of.about) >= {"scenario", "seed", "version"}


def command(scenarios):
    import os

    return [os.environ["SIGHTLINE_BINARY"], "campaign", scenarios / "cooperative_localization.toml", "--set", short[0]]


def test_it_goes_on_where_it_was_on_any_number_of_threads(drawn, tmp_path):
    told = []
    sl.campaign(drawn, runs=4, out=tmp_path / "a", threads=1, progress=told.append)
    longer = sl.campaign(drawn, runs=9, out=tmp_path / "a", threads=2)
    at_once = sl.campaign(drawn, runs=9, out=tmp_path / "b")
    assert told == sorted(told) and longer.file.read_bytes() == at_once.file.read_bytes()
    with pytest.raises(ValueError, match="holds 9 runs of this campaign, expected at most 3"):
        sl.campaign(drawn, runs=3, out=tmp_path / "a")
    with pytest.raises(ValueError, match="seed"):
        sl.campaign(drawn, runs=9, seed=77, out=tmp_path / "a")


def test_it_is_a_frame_a_page_and_a_picture(drawn, tmp_path):
    of = sl.campaign(drawn, runs=6, out=tmp_path)
    frame = of.frame()
    assert len(frame) == 6 and frame.index.name == "index"
    np.testing.assert_array_equal(frame["min_distance"].to_numpy(), of.runs["min_distance"])
    assert "<table>" in of._repr_html_() and of.report().stat().st_size > 5_000
    ax = plot.success(of, "min_distance", "fraction_in_view")
    assert len(ax.lines) == len(of.outcomes)


@pytest.mark.parametrize("given, sentence", [({"runs": 0}, "runs = 0, expected >= 1"), ({"threads": -1}, "threads = -1, expected")])
def test_numbers_that_cannot_be_are_refused(drawn, tmp_path, given, sentence):
    with pytest.raises(ValueError, match=sentence):
        sl.campaign(drawn, out=tmp_path / "none", **given)
    assert not (tmp_path / "none").exists()


def test_a_scenario_without_draws_or_whose_team_changes_is_refused(scenarios, tmp_path):
    with pytest.raises(ValueError, match=r"campaign is missing, expected \[campaign\]"):
        sl.campaign(scenarios / "swarm32.toml", out=tmp_path)


def test_ctrl_c_leaves_a_table_that_opens_and_goes_on(scenarios, tmp_path):
    program = (f"import sightline as sl\ns = sl.Scenario.read({str(scenarios / 'cooperative_localization.toml')!r})\nprint('flies', flush=True)\n"
               f"sl.campaign(s, runs=100000, out={str(tmp_path)!r})")
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "flies\n"
    time.sleep(2.0)
    child.send_signal(signal.SIGINT)
    _, error = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in error
    with sqlite3.connect(tmp_path / "campaign.sqlite") as database:
        (rows,) = database.execute("SELECT count(*) FROM runs").fetchone()
    assert rows > 0
    of = sl.campaign(scenarios / "cooperative_localization.toml", runs=rows + 2, out=tmp_path)
    assert len(of) == rows + 2

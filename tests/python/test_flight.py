"""Flights from Python are those of the command line."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from xml.etree import ElementTree

import numpy as np
import pytest

import sightline as sl

short = ["simulation.duration=3.0"]


def flown(scenarios, out, name="paper_7_1", set=(), **given):
    return sl.run(sl.Scenario.read(scenarios / f"{name}.toml", set=[*short, *set]), out=out, **given)


@pytest.mark.parametrize("name", ["paper_7_1", "join_and_leave", "localize", "swarm32", "rotors/cooperative_localization"])
def test_a_run_has_the_bytes_of_the_command_line(scenarios, tmp_path, name):
    sets = [word for value in short for word in ("--set", value)]
    subprocess.run([os.environ["SIGHTLINE_BINARY"], "run", scenarios / f"{name}.toml", "-o", tmp_path / "cli", "--seed", "7",
                    *sets], capture_output=True)
    flight = flown(scenarios, tmp_path / "python", name, seed=7)
    assert (flight.folder / "run.mcap").read_bytes() == (tmp_path / "cli" / "run.mcap").read_bytes()
    assert flight.summary["seed"] == 7
    judged = json.loads((tmp_path / "cli" / "summary.json").read_text())
    assert flight.summary["cost"] == judged["cost"] and flight.summary["status"] == judged["status"]


def test_the_solver_and_the_seed_stand_in_place_of_the_scenario_s(scenarios, tmp_path):
    flight = flown(scenarios, tmp_path, solver="cgmres")
    assert flight.summary["solver"] == "cgmres"
    with pytest.raises(ValueError, match="solver = newton, expected one of"):
        flown(scenarios, tmp_path, solver="newton")


def test_the_commands_of_a_log_are_replayed_bit_for_bit(scenarios, tmp_path):
    flown(scenarios, tmp_path)
    same = sl.replay(tmp_path)
    assert same["commands"] == 600 and same["differing"] == 0 and same["complete"]
    other = sl.replay(tmp_path, set=["couple[0].weight=0.1"])
    assert other["differing"] > 0
    with pytest.raises(ValueError, match="no run.mcap, expected the folder of a run"):
        sl.replay(tmp_path / "nowhere")


def test_progress_is_told_and_ends_a_flight_that_raises(scenarios, tmp_path):
    told = []
    flown(scenarios, tmp_path / "told", set=["simulation.duration=60.0"], progress=told.append)
    assert told == sorted(told)

    def enough(simulated):
        if simulated > 0.0:
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        flown(scenarios, tmp_path / "ended", set=["simulation.duration=20000.0"], progress=enough)
    log = sl.Log(tmp_path / "ended")
    assert log.complete and 0 < len(log) < 2_000_000


def test_other_threads_run_while_it_flies(scenarios, tmp_path):
    turns = 0
    thread = threading.Thread(target=flown, args=(scenarios, tmp_path), kwargs={"set": ["simulation.duration=60.0"]})
    thread.start()
    while thread.is_alive():
        turns += 1
        time.sleep(0.001)
    assert turns > 5


def test_ctrl_c_leaves_a_log_up_to_there(scenarios, tmp_path):
    program = (f"import sightline as sl\ns = sl.Scenario.read({str(scenarios / 'paper_7_1.toml')!r}, "
               f"set=['simulation.duration=20000.0'])\nprint('flies', flush=True)\nsl.run(s, out={str(tmp_path)!r})")
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "flies\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    _, error = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in error
    log = sl.Log(tmp_path)
    assert log.complete and len(log) > 10


def test_a_flight_shows_itself_and_makes_its_report(scenarios, tmp_path):
    flight = flown(scenarios, tmp_path)
    assert str(tmp_path) in repr(flight) and "<table>" in flight._repr_html_()
    page = flight.report().read_text()
    files = sl.figures(flight.folder)
    assert len(files) == page.count("<figure ")
    for file in files:
        assert ElementTree.parse(file).getroot().tag == "{http://www.w3.org/2000/svg}svg"


def test_refusals_carry_the_sentence_of_the_library(scenarios, tmp_path):
    with pytest.raises(sl.ScenarioError, match=r"paper\.toml:1: .*expected") as refused:
        sl.Scenario.parse("[horizn]\nduration = 1.0\n", "paper.toml")
    assert isinstance(refused.value, ValueError)
    with pytest.raises(ValueError, match="nowhere.toml"):
        sl.run(tmp_path / "nowhere.toml")
    with pytest.raises(ValueError, match="expected"):
        flown(scenarios, tmp_path, set=["couple[0].weight=-1"])


def test_check_and_explain_say_what_the_command_line_says(scenarios, sightline):
    file = scenarios / "cooperative_localization.toml"
    assert sl.explain(file) == sightline("explain", file)
    assert "ok\n" + str(sl.check(file)) in sightline("check", file)
    scenario = sl.Scenario.read(file)
    assert scenario.name == "cooperative_localization" and scenario.expanded == sightline("check", "--print", file)


def test_a_log_is_arrays_that_look_at_its_memory(scenarios, tmp_path):
    log = flown(scenarios, tmp_path).log
    assert list(log.bodies) == ["uav0", "uav1"] and len(log) == 300
    uav0 = log["uav0"]
    n = len(log)
    assert uav0.p.shape == (n, 3) and uav0.v.shape == (n, 3) and uav0.x.shape == (n, 7) and uav0.u.shape == (n, 4)
    assert uav0.inputs == ["u_f", "u_s", "u_z", "u_psi"]
    np.testing.assert_allclose(np.diff(log.time), 0.01, rtol=1e-9)
    np.testing.assert_array_equal(uav0.p, uav0.x[:, :3])
    np.testing.assert_allclose(np.cos(uav0.heading), uav0.x[:, 3], atol=1e-12)
    assert not uav0.p.flags.writeable and uav0.p.base is not None
    with pytest.raises(ValueError):
        uav0.p[0, 0] = 1.0
    p = uav0.p
    copied = p.copy()
    del log, uav0
    np.testing.assert_array_equal(p, copied)  # the array holds the log
    with pytest.raises(KeyError, match="expected the name of a body"):
        sl.Log(tmp_path)["uav9"]
    with pytest.raises(RuntimeError):
        sl.Log(tmp_path / "nowhere")


def records_of(log):
    """Where the records of an MCAP file stand: (kind, from, to)."""
    at = 8
    while at < len(log) - 8:
        to = at + 9 + int.from_bytes(log[at + 1:at + 9], "little")
        yield log[at], at, to
        at = to


def test_a_log_that_grows_stays_what_it_was_when_it_was_opened(scenarios, tmp_path):
    flown(scenarios, tmp_path / "whole", set=["simulation.duration=20.0"])
    whole, grows = (tmp_path / "whole" / "run.mcap").read_bytes(), tmp_path / "grows"
    grows.mkdir()
    (grows / "timing.csv").write_bytes((tmp_path / "whole" / "timing.csv").read_bytes())
    (grows / "run.mcap").write_bytes(whole[:len(whole) // 2])
    log = sl.Log(grows)
    n = len(log)
    assert 0 < n < 2000 and not log.complete
    (grows / "run.mcap").write_bytes(whole)
    for name in log.bodies:
        assert log[name].x.shape == (n, 7)
        np.testing.assert_array_equal(log[name].p, log[name].x[:, :3])


def test_a_log_without_its_beginning_is_no_flight_to_repeat(scenarios, tmp_path):
    flown(scenarios, tmp_path, set=["simulation.duration=20.0"])
    log = (tmp_path / "run.mcap").read_bytes()
    _, begin, end = next(record for record in records_of(log) if record[0] == 0x06)
    _, data_end, _ = next(record for record in records_of(log) if record[0] == 0x0F)
    no_crc = bytes(4)
    (tmp_path / "run.mcap").write_bytes(log[:begin] + log[end:data_end + 9] + no_crc + log[data_end + 13:])
    with pytest.raises(RuntimeError, match="holds no samples of the first period"):
        sl.replay(tmp_path)


def test_many_flights_leave_no_memory_behind(scenarios, tmp_path):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    def once():
        log = flown(scenarios, tmp_path, set=["simulation.duration=0.2"]).log
        return log["uav0"].p.sum()

    for _ in range(20):
        once()
    before = resident()
    for _ in range(60):
        once()
    assert resident() - before < 8_000_000

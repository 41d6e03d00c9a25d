"""Simulate, identify and diagnose from Python: no driver is needed."""

import os
import pathlib
import signal
import subprocess
import sys
import textwrap

import numpy as np
import pyarrow
import pandas
import pytest

import sinew
from conftest import bench

TIME_S = np.arange(0, 24, 0.02)
DUTY = np.select([TIME_S % 6 < 2.5, TIME_S % 6 < 3.5], [0.28 + 0.02 * (TIME_S // 6), 0.1], 0.02)


@pytest.fixture(scope="module")
def rig_text():
    return bench("wire")


@pytest.fixture(scope="module")
def measured(rig_text):
    """A recording of a wire that cools faster than its rig file says, with the noise of its sensors."""
    true = rig_text + "material = { convection_w_per_m2_k = 140.0 }\n"
    run = sinew.simulate(true, {"time_s": TIME_S, "duty": DUTY})
    random = np.random.default_rng(7)
    noisy = {"time_s": run["time_s"], "duty": run["duty"]}
    for column, noise in (("position_m", 10e-6), ("current_a", 5e-4), ("v1_v", 2e-3), ("v2_v", 2e-3), ("v3_v", 2e-3)):
        noisy[column] = run[column] + noise * random.standard_normal(len(TIME_S))
    return noisy


def test_heat_shortens_a_wire_and_the_columns_are_in_si_units(rig_text):
    run = sinew.simulate(rig_text, {"time_s": TIME_S, "duty": DUTY})
    assert run.samples == len(TIME_S) and np.array_equal(run["duty"], DUTY)
    hot, cold = run["position_m"][TIME_S < 2.5][-1], run["position_m"][0]
    assert hot < cold - 1e-3, "positive is longer"
    assert run["martensite"].min() >= 0 and run["martensite"].max() <= 1
    with pytest.raises(sinew.BadInput, match="there are: time_s"):
        run["lenght"]


def test_a_recording_may_come_in_anything_that_has_columns(rig_text, tmp_path):
    inputs = {"time_s": TIME_S, "duty": DUTY}
    expected = sinew.simulate(rig_text, inputs)
    path = tmp_path / "in.csv"
    sinew.Table(inputs).save(path)
    frame = pandas.DataFrame(inputs)
    for given in (frame, pyarrow.table(inputs), frame.to_records(index=False), path, str(path), expected):
        # a simulation has more columns than a recording can
        run = sinew.simulate(rig_text, given, ignore_columns=given is expected)
        for column in ("position_m", "temperature_c", "v3_v"):
            assert np.array_equal(run[column], expected[column]), type(given)


def test_the_command_line_says_the_same(rig_text, tmp_path):
    program = os.environ.get("SINEW_BINARY", "sinew")
    (tmp_path / "rig.toml").write_text(rig_text)
    sinew.Table({"time_s": TIME_S, "duty": DUTY}).save(tmp_path / "in.csv")
    subprocess.run([program, "simulate", "rig.toml", "in.csv", "-o", "out.csv"], cwd=tmp_path, check=True)
    theirs = pandas.read_csv(tmp_path / "out.csv")
    ours = sinew.simulate(tmp_path / "rig.toml", tmp_path / "in.csv").to_pandas()
    pandas.testing.assert_frame_equal(ours, theirs, check_exact=True)


def test_foreign_names_and_units_are_the_rig_files_business(rig_text):
    named = rig_text + '\n[recording.columns]\nduty = { column = "PWM / %", scale = 0.01 }\ntime_s = { column = "t" }\n'
    foreign = {"t": TIME_S, "PWM / %": 100 * DUTY}
    table = sinew.read_recording(foreign, named)
    assert np.allclose(table["duty"], DUTY)
    run = sinew.simulate(named, foreign)
    assert np.allclose(run["position_m"], sinew.simulate(rig_text, {"time_s": TIME_S, "duty": DUTY})["position_m"])


@pytest.mark.parametrize(
    "inputs, words",
    [
        ({"time_s": TIME_S}, "duty"),
        ({"time_s": TIME_S, "duty": 100 * DUTY}, "scale = 0.01"),
        ({"time_s": TIME_S, "duty": DUTY[:-1]}, "samples"),
        ({"time_s": TIME_S[::-1], "duty": DUTY}, "time_s"),
        ({"time_s": TIME_S, "duty": ["a"] * len(TIME_S)}, "no numbers"),
        ({"time_s": TIME_S, "duty": np.zeros((len(TIME_S), 2))}, "dimensions"),
        ({"time_s": TIME_S, "duty": DUTY, "speed": DUTY}, "ignore_columns=True"),
        ({}, "no columns"),
        (3.0, "float"),
        ("nowhere.csv", "nowhere.csv"),
    ],
)
def test_what_cannot_be_trusted_is_refused_with_its_place_and_the_remedy(rig_text, inputs, words):
    with pytest.raises(sinew.BadInput) as raised:
        sinew.simulate(rig_text, inputs)
    assert words in str(raised.value) and raised.value.remedy, raised.value


def test_mistakes_of_a_rig_file_are_told_with_their_lines(rig_text):
    with pytest.raises(sinew.BadInput, match="rig:7: .*did you mean diameter_mm"):
        sinew.simulate(rig_text.replace("diameter_mm", "diametre_mm"), {"time_s": TIME_S, "duty": DUTY})
    with pytest.raises(sinew.BadInput, match="nowhere.toml"):
        sinew.simulate(pathlib.Path("nowhere.toml"), {"time_s": TIME_S, "duty": DUTY})
    with pytest.raises(sinew.BadInput, match="choose one with channel=: left, right"):
        sinew.simulate(bench("left", "right"), {"time_s": TIME_S, "duty": DUTY})
    with pytest.raises(sinew.BadInput, match='did you mean "left"'):
        sinew.simulate(bench("left", "right"), {"time_s": TIME_S, "duty": DUTY}, channel="lefft")


def test_a_parameter_that_is_off_is_found_within_its_interval(rig_text, measured, tmp_path):
    told = []
    found = sinew.identify(rig_text, measured, progress=lambda stage, share: told.append((stage, share)))
    convection = found.parameters["convection_w_per_m2_k"]
    assert convection.low < 140.0 < convection.high and convection.given != pytest.approx(140.0, rel=0.05)
    assert found.fitted["position_m"].chi < 1.3 < found.as_given["position_m"].chi
    assert told and all(isinstance(stage, str) and 0 <= share <= 1 for stage, share in told)
    found.save(tmp_path / "fitted.toml")
    again = sinew.simulate(tmp_path / "fitted.toml", {"time_s": TIME_S, "duty": DUTY})
    error = again["position_m"] - measured["position_m"]
    assert np.sqrt(np.mean(error**2)) < 2 * 10e-6
    assert found.to_pandas().loc["convection_w_per_m2_k", "value"] == convection.value
    assert "convection_w_per_m2_k" in found._repr_html_()


def test_the_same_recording_twice_is_refused(rig_text, measured):
    with pytest.raises(sinew.BadInput, match="same recording"):
        sinew.identify(rig_text, [measured, measured])
    with pytest.raises(sinew.BadInput, match="same recording"):
        sinew.diagnose(rig_text, measured, holdout=measured)


def test_a_diagnosis_is_an_answer_with_its_report(rig_text, measured, tmp_path):
    answer = sinew.diagnose(rig_text, pandas.DataFrame(measured), seed=2)
    assert answer.verdict == "parameters_off", answer.summary
    assert answer.effects == [] and answer.chi_improved < 1.2 < answer.chi_as_given
    assert answer.answer["seed"] == 2 and answer.answer["schema"].startswith("sinew.diagnosis/")
    assert "<html" in answer.report_html and answer.picture_svg.startswith("<svg") and "srcdoc" in answer._repr_html_()
    answer.save(tmp_path / "answer")
    answer.save(tmp_path / "answer")
    (tmp_path / "answer" / "thesis.doc").write_text("mine")
    with pytest.raises(sinew.BadInput, match="thesis.doc"):
        answer.save(tmp_path / "answer")
    assert sinew.simulate(tmp_path / "answer" / "improved.toml", measured).samples == len(TIME_S)


def test_what_a_progress_function_raises_ends_the_work(rig_text, measured):
    def enough(stage, share):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        sinew.diagnose(rig_text, measured, progress=enough)


def test_an_interrupt_ends_a_diagnosis(tmp_path, rig_text, measured):
    (tmp_path / "rig.toml").write_text(rig_text)
    sinew.Table(measured).save(tmp_path / "run.csv")
    text = """
        import sinew
        tell = lambda stage, share: print(stage, flush=True)
        sinew.diagnose("rig.toml", "run.csv", progress=tell)
        print("the end", flush=True)
    """
    program = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(text)],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert program.stdout.readline().strip() not in ("", "the end")
    program.send_signal(signal.SIGINT)
    said, error = program.communicate(timeout=120)
    assert "KeyboardInterrupt" in error and "the end" not in said, (said, error)
    assert "panicked" not in error


def test_a_session_of_a_driver_is_arrays_and_a_recording_of_each_channel(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text(bench("left", "right"))
    program = os.environ.get("SINEW_BINARY", "sinew")
    with sinew.run(path) as rig:
        command = [program, "record", tmp_path / "walk.mcap", "--rig", rig.name, "--for", "1"]
        recorder = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        rig["left"].set("duty", 0.1, hold=5.0)
        assert recorder.wait() == 0
    record = sinew.read_session(tmp_path / "walk.mcap")
    assert record.channels == ("left", "right") and record.lost == 0 and record.about["rate_hz"] == 500.0
    assert np.all(np.diff(record.cycle.astype(int)) == 1) and record["left"]["duty"].max() == pytest.approx(0.1)
    half = sinew.read_session(tmp_path / "walk.mcap", to_s=record.time_s[-1] / 2)
    assert 0 < len(half) < len(record)
    table = sinew.read_recording(tmp_path / "walk.mcap", path, channel="left")
    assert {"time_s", "duty", "position_m"} <= set(table)
    assert "left" in record._repr_html_() and "duty" in table._repr_html_()

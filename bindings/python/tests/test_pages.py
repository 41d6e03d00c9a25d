"""What the guide and the notebooks print runs as it is printed."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

import pytest

HERE = pathlib.Path(__file__).parent
GUIDE = HERE.parents[2] / "docs" / "python.md"
NOTEBOOKS = sorted((HERE.parent / "examples").glob("*.ipynb"))


def block(number: int) -> str:
    """The guide's Python, block by block."""
    return re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)[number]


def test_the_quick_start_moves_a_wire():
    text = block(0)
    assert len(text.strip().splitlines()) <= 10
    # its hexapod has a runtime folder of its own, so that it does not meet another one
    with tempfile.TemporaryDirectory(prefix="so-") as folder:
        environment = {**os.environ, "SINEW_RUNTIME_DIR": folder, "SINEW_STATE_DIR": folder}
        command = [sys.executable, "-c", text]
        said = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert said.returncode == 0, said.stderr
    assert re.match(r"<sinew.Channel front_left_tibia: length, \d+\.\d+ mm, \d+ °C> \d", said.stdout), said.stdout


def test_the_analysis_in_the_guide_runs(tmp_path):
    from conftest import bench
    from test_analysis import DUTY, TIME_S

    import numpy as np
    import sinew

    rig = bench("wire")
    (tmp_path / "rig.toml").write_text(rig)
    random = np.random.default_rng(1)
    for day, duty in (("monday", DUTY), ("tuesday", np.roll(DUTY, 300))):
        run = sinew.simulate(rig, {"time_s": TIME_S, "duty": duty})
        noisy = run["position_m"] + 15e-6 * random.standard_normal(TIME_S.size)
        sinew.Table({"time_s": TIME_S, "duty": duty, "position_m": noisy}).save(tmp_path / f"{day}.csv")
    program = "import sinew\n" + block(1)
    said = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert said.returncode == 0, said.stderr
    assert said.stdout.startswith("agrees None []"), said.stdout
    assert sorted(os.listdir(tmp_path / "answer"))[:3] == ["diagnosis.json", "improved.toml", "picture.svg"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(path, 4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "outputs are not kept in the repository"
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs), "a picture"
    said = "".join(output.get("text", "") for output in outputs)
    expected = {"move_record_plot": "error in the last quarter", "why_does_it_differ": "physics_missing in the mechanical equation"}
    assert expected[path.stem] in said, said

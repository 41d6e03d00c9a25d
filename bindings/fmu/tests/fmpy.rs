//! The FMU in FMPy, an independent simulator of FMUs: its description is valid, and what comes out is what the model itself says.
//! Skipped where Python or FMPy is missing.

use std::path::PathBuf;
use std::process::Command;

use sinew_fmu::package;
use sinew_physics::{Inputs, Wire};
use sinew_rig::Rig;

const PROGRAM: &str = r#"
import sys
import numpy as np
from fmpy import read_model_description, simulate_fmu, extract, instantiate_fmu
from fmpy.validation import validate_fmu

path = sys.argv[1]
problems = validate_fmu(path)
assert not problems, problems
names = ["position_m", "temperature_c", "force_n", "martensite"]
out = simulate_fmu(path, start_time=0.0, stop_time=1.0, output_interval=0.01, input=None, output=names,
                   start_values={"duty": 0.35, "ambient_c": 30.0, "material.convection_w_per_m2_k": 100.0})
print("heated", *(repr(float(out[name][-1])) for name in names), len(out))

# by hand: a fork of the state goes the same way twice, and mistakes are said and leave the instance usable
description = read_model_description(path)
said = []
fmu = instantiate_fmu(extract(path), description, "CoSimulation",
                      debug_logging=True, logger=lambda *words: said.append(words[-1]))
of = {v.name: v.valueReference for v in description.modelVariables}
fmu.enterInitializationMode(startTime=0.0)
fmu.setFloat64([of["duty"]], [0.35])
fmu.exitInitializationMode()
fmu.doStep(0.0, 0.5)
state = fmu.getFMUState()
ends = []
for _ in range(2):
    fmu.setFMUState(state)
    fmu.doStep(0.5, 0.25)
    ends.append(fmu.getFloat64([of["position_m"]])[0])
assert ends[0] == ends[1], ends
for wrong in (lambda: fmu.setFloat64([of["position_m"]], [0.0]), lambda: fmu.doStep(9.0, 0.1),
              lambda: fmu.getFloat64([4321]), lambda: fmu.setFloat64([of["material.density_kg_per_m3"]], [1.0])):
    try:
        wrong()
    except Exception:
        continue
    raise SystemExit("it was taken")
fmu.doStep(0.75, 0.25)
fmu.freeFMUState(state)
fmu.reset()
fmu.terminate()
fmu.freeInstance()
print("done")
"#;

#[test]
fn fmpy_finds_it_valid_and_gets_what_the_model_says() {
    let has_it = Command::new("python3").args(["-c", "import fmpy"]).output().is_ok_and(|ran| ran.status.success());
    if !has_it {
        eprintln!("skipped: python3 with fmpy is needed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coxa.fmu");
    let rig = Rig::hexapod();
    package::write(&rig, 0, &library(), &path).unwrap();
    let ran = Command::new("python3").args(["-c", PROGRAM]).arg(&path).output().unwrap();
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(ran.status.success() && said.ends_with("done\n"), "{said}{}", String::from_utf8_lossy(&ran.stderr));

    // The same by the model: 1 s of 35 % in air of 30 °C.
    let mut rig = rig;
    rig.set_parameter(0, "convection_w_per_m2_k", 100.0).unwrap();
    let model = &rig.channels[0].model;
    let inputs = Inputs { drive: 0.35, ambient_c: 30.0, ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(model, &inputs).unwrap();
    (0..100).for_each(|_| wire.step(&inputs, 0.01));
    let expected = wire.outputs();
    let heated = said.lines().find(|line| line.starts_with("heated ")).expect("the line of the heated wire");
    let found: Vec<f64> = heated.split(' ').skip(1).map(|number| number.parse().unwrap()).collect();
    let expected = [expected.position_m, expected.temperature_c, expected.force_n, expected.martensite, 101.0];
    // how a span is cut into steps is FMPy's rounding
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found} {expected}: {heated}");
    }
    assert_eq!(found.len(), 5);
}

/// The library as this test was built with it.
fn library() -> PathBuf {
    let name = format!("{}sinew_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let exe = std::env::current_exe().unwrap();
    let folders = exe.ancestors().skip(1).take(2).map(|folder| folder.join(&name));
    folders.into_iter().find(|path| path.is_file()).expect("cargo leaves the library beside the test or above it")
}

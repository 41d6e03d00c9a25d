//! Every recording that lies beside the project passes the gates without a word. Skipped where they are not.

use std::path::{Path, PathBuf};

use sinew_diagnosis::check;
use sinew_recording::{Options, read};
use sinew_rig::Rig;

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn good_recordings_pass() {
    for kind in ["real", "concealed"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(kind);
        if !folder.is_dir() {
            eprintln!("skipped: no {}", folder.display());
            continue;
        }
        for rig_folder in entries(&folder).into_iter().filter(|p| p.join("rig.toml").is_file()) {
            let rig = Rig::load(&rig_folder.join("rig.toml")).unwrap_or_else(|e| panic!("{e}"));
            let channel = &rig.channels[0];
            for path in entries(&rig_folder) {
                let name = path.to_string_lossy();
                if name.ends_with(".csv") || name.ends_with(".csv.gz") {
                    let options = Options { model: Some(&channel.model), ..Options::default() };
                    let recording = read(&path, &options).unwrap_or_else(|e| panic!("{e}"));
                    let warnings = check(&recording, channel).unwrap_or_else(|e| panic!("{e}"));
                    assert_eq!(warnings, [], "{name}");
                }
            }
        }
    }
}

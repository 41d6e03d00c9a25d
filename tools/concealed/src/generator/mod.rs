//! The first generator of concealed cases. It shares no code with the simulator that the diagnosis fits with: another form of
//! the equations, another integrator, another hand on every sensor. A test keeps it so.

pub mod bench;
pub mod case;
pub mod laws;
pub mod levels;
pub mod magnitudes;
pub mod plan;
pub mod programme;
mod refit;
pub mod signals;
pub mod truth;
mod wire;
pub mod world;

#[cfg(test)]
mod tests {
    /// Nothing of the project's own simulator, rig file or diagnosis may be used by the generator.
    #[test]
    fn no_code_is_shared() {
        let own = concat!("sinew", "_");
        let mut folders = ["src/generator", "src/second"]
            .map(|folder| std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder))
            .to_vec();
        let mut files = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder of the generator") {
                let path = entry.expect("an entry").path();
                if path.is_dir() { folders.push(path) } else { files.push(path) }
            }
        }
        assert!(files.len() > 10, "{files:?}");
        let files = files.iter().filter(|path| path.extension().is_some_and(|e| e == "rs"));
        for path in files {
            let text = std::fs::read_to_string(path).expect("a source file");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            assert!(!code.contains(own), "{} uses the project's own code", path.display());
        }
    }
}

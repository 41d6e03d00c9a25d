//! The generator of concealed cases. It shares no code with the simulator that the diagnosis fits with: another form of
//! the equations, another integrator, another hand on every sensor. A test keeps it so.

pub mod bench;
pub mod case;
pub mod magnitudes;
pub mod plan;
mod programme;
mod refit;
mod signals;
pub mod truth;
mod wire;

#[cfg(test)]
mod tests {
    /// Nothing of the project's own simulator, rig file or diagnosis may be used by the generator.
    #[test]
    fn no_code_is_shared() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/generator");
        let own = concat!("sinew", "_");
        for entry in std::fs::read_dir(folder).expect("the generator's folder") {
            let path = entry.expect("an entry").path();
            let text = std::fs::read_to_string(&path).expect("a source file");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            assert!(!code.contains(own), "{} uses the project's own code", path.display());
        }
    }
}

//! Physics of a laboratory's own, as a file of candidates: mechanisms outside the catalogue, of which one is true.

/// Names of mechanisms outside the catalogue, with the law that describes each.
const LAWS: [(&str, &str); 4] = [
    ("drag with the square of speed", "own.drag"),
    ("spring that hardens with the cube", "own.hardening"),
    ("loss that depends on position", "own.tube"),
    ("the wire's own plume", "own.plume"),
];

/// The mechanisms that a law describes.
pub fn described() -> impl Iterator<Item = &'static str> {
    LAWS.iter().map(|(name, _)| *name)
}

/// The law of a mechanism.
pub fn id_of(name: &str) -> Option<String> {
    LAWS.iter().find(|(n, _)| *n == name).map(|(_, id)| id.to_string())
}

/// The file: all of them, each a candidate in every case.
pub const CANDIDATES: &str = include_str!("laws.toml");

//! A figure as a PNG, rendered from its SVG with a bundled font.

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use crate::Error;
use crate::figure::Figure;

/// The letters of a PNG, so that it looks the same on every machine. `font/README.md` says which, and how it was made.
const FONT: &[u8] = include_bytes!("../font/DejaVuSans-subset.ttf");
/// Pixels of a PNG per pixel of the drawing: sharp on paper and on dense screens.
const SCALE: f32 = 2.0;

impl Figure {
    /// The same as a PNG, twice as many pixels as the SVG has.
    ///
    /// # Errors
    /// [`Error::Picture`] in the renderer's words.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        let failed = |reason: String| Error::Picture { reason };
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(FONT.to_vec());
        fonts.set_sans_serif_family("DejaVu Sans");
        let options =
            usvg::Options { font_family: "DejaVu Sans".into(), fontdb: Arc::new(fonts), ..usvg::Options::default() };
        let tree = usvg::Tree::from_str(&self.svg(), &options).map_err(|e| failed(e.to_string()))?;
        let size = tree.size().to_int_size().scale_by(SCALE).ok_or_else(|| failed("it is too large".into()))?;
        let mut pixels =
            tiny_skia::Pixmap::new(size.width(), size.height()).ok_or_else(|| failed("it is too large".into()))?;
        resvg::render(&tree, tiny_skia::Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
        pixels.encode_png().map_err(|e| failed(e.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tests::figure;

    #[test]
    fn a_png_has_letters_and_lines() {
        let png = figure().png().unwrap();
        assert!(png.starts_with(b"\x89PNG"));
        let picture = tiny_skia::Pixmap::decode_png(&png).unwrap();
        let count = |what: fn(u8, u8, u8) -> bool| {
            picture.pixels().iter().filter(|p| what(p.red(), p.green(), p.blue())).count()
        };
        assert!(count(|r, g, b| (r, g, b) == (0x00, 0x72, 0xB4)) > 500, "the curve in its colour");
        assert!(count(|r, g, b| r < 0x30 && g < 0x40 && b < 0x50) > 300, "the title's letters");
    }
}

//! A gallery: one figure of each kind, as SVG and as PNG, for a look at the visual language.
//!
//! `cargo run --release -p plot --example gallery -- FOLDER` writes them; text is set in the fonts found below
//! /usr/share/fonts.
//!
//! Stands on: `plot`, resvg for the PNGs. Never knows: a recording; every curve here is made up.

mod drawn;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use resvg::{tiny_skia, usvg};

/// Dots in a millimetre of the PNGs.
const DOTS_PER_MM: f32 = 10.0;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("gallery"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let options = with_fonts();
    for (name, svg) in drawn::all()? {
        fs::write(folder.join(format!("{name}.svg")), &svg)?;
        let dots = write_png(&svg, &options, &folder.join(format!("{name}.png")))?;
        println!("{name:12} {:7} bytes, {} × {} dots", svg.len(), dots.0, dots.1);
    }
    println!("in {}", folder.display());
    Ok(())
}

fn write_png(svg: &str, options: &usvg::Options, path: &Path) -> Result<(u32, u32), Box<dyn Error>> {
    let tree = usvg::Tree::from_str(svg, options)?;
    let zoom = DOTS_PER_MM * 25.4 / options.dpi;
    let size = tree.size().to_int_size().scale_by(zoom).ok_or("the picture has no size")?;
    let mut dots = tiny_skia::Pixmap::new(size.width(), size.height()).ok_or("the picture has no size")?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(zoom, zoom), &mut dots.as_mut());
    fs::write(path, dots.encode_png()?)?;
    Ok((size.width(), size.height()))
}

/// Options with every font below /usr/share/fonts; sans-serif is DejaVu Sans.
fn with_fonts() -> usvg::Options<'static> {
    let mut options = usvg::Options::default();
    let mut open = vec![PathBuf::from("/usr/share/fonts")];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()) {
            match entry.extension().and_then(|e| e.to_str()) {
                _ if entry.is_dir() => open.push(entry),
                Some("ttf" | "otf") => {
                    if let Ok(bytes) = fs::read(&entry) {
                        options.fontdb_mut().load_font_data(bytes);
                    }
                }
                _ => {}
            }
        }
    }
    options.fontdb_mut().set_sans_serif_family("DejaVu Sans");
    options
}

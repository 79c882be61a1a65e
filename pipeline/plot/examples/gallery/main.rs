//! A gallery: one figure of each kind as SVG, to be opened in a browser.
//!
//! `cargo run --release -p plot --example gallery -- FOLDER` writes them.

mod drawn;

use std::error::Error;
use std::fs;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("gallery"), PathBuf::from);
    fs::create_dir_all(&folder)?;
    for (name, svg) in drawn::all()? {
        fs::write(folder.join(format!("{name}.svg")), &svg)?;
        println!("{name:12} {:7} bytes", svg.len());
    }
    println!("in {}", folder.display());
    Ok(())
}

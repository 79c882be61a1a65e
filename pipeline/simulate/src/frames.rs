//! Frames: the deformed body as a series of `.vtu` files, and the `.pvd` list that ParaView opens.
//!
//! Points are those at rest; warp them by `displacement_m`. Arrays are little-endian base64 with a header of four bytes. The
//! list is written anew after each frame, so that it is whole whenever the program ends.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fem::RegionProperties;
use mesh::Solid;

use super::cannot_write;
use crate::body::Body;
use crate::stress::element_stresses;
use diagnostics::{Diagnostic, Result};

/// One state of a body.
pub(super) struct Frame<'a> {
    /// 3 a node, m.
    pub displacement: &'a [f64],
    /// 3 a node, m/s.
    pub velocity: Option<&'a [f64]>,
    /// Mode of a critical point, 3 a node.
    pub mode: Option<&'a [f64]>,
    /// By region.
    pub properties: &'a [RegionProperties],
}

/// The frames so far.
pub(super) struct Frames {
    folder: PathBuf,
    list: PathBuf,
    written: Vec<(f64, String)>,
}

impl Frames {
    /// Begins a series in `folder`, from which the frames of an earlier run are taken away.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the folder cannot be changed.
    pub(crate) fn begin_folder(folder: &Path, stem: &str) -> Result<Self> {
        let own_list = format!("{stem}.pvd");
        let entries: Vec<_> = std::fs::read_dir(folder).map_err(|e| cannot_write(folder, &e))?.flatten().collect();
        for entry in &entries {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.ends_with(".pvd") && name != own_list {
                return Err(others_results(folder, &name));
            }
        }
        for entry in entries {
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_numbered =
                ["frame_", "critical_"].iter().any(|word| name.starts_with(word)) && name.ends_with(".vtu");
            if name == "last_converged.vtu" || is_numbered {
                std::fs::remove_file(entry.path()).map_err(|e| cannot_write(&entry.path(), &e))?;
            }
        }
        let frames = Self { folder: folder.to_owned(), list: folder.join(own_list), written: Vec::new() };
        frames.write_list()?;
        Ok(frames)
    }

    /// The name of the next frame.
    pub(crate) fn next_name(&self) -> String {
        format!("frame_{:04}.vtu", self.written.len())
    }

    /// The path of another file beside the frames.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a frame at a level or time (s), and the list; returns where it lies.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a file cannot be written.
    pub(crate) fn write_frame(&mut self, name: &str, at: f64, body: &Body, frame: &Frame) -> Result<PathBuf> {
        let path = self.folder.join(name);
        std::fs::write(&path, vtu_text(body, frame)).map_err(|e| cannot_write(&path, &e))?;
        self.written.push((at, name.to_owned()));
        self.write_list()?;
        Ok(path)
    }

    fn write_list(&self) -> Result<()> {
        let mut text =
            String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\"><Collection>\n");
        for (at, name) in &self.written {
            let _ = writeln!(text, "<DataSet timestep=\"{at}\" part=\"0\" file=\"{name}\"/>");
        }
        text += "</Collection></VTKFile>\n";
        std::fs::write(&self.list, text).map_err(|e| cannot_write(&self.list, &e))
    }
}

/// A folder with the frames of another case.
fn others_results(folder: &Path, list: &str) -> Diagnostic {
    Diagnostic::file(
        folder,
        format!("the folder holds the results of another case, {list}"),
        "frames of two cases in one folder have the same names",
        "name another folder with --out, or remove this one",
    )
}

/// The elements by their nodes and VTK's numbers of their kinds.
fn write_cells(text: &mut String, solid: &Solid) {
    let listed: Vec<(u8, Vec<u32>)> =
        (0..solid.len()).map(|element| mesh::vtu::vtk_cell(solid.element(element))).collect();
    write_integers(
        text,
        "connectivity",
        &listed.iter().flat_map(|cell| &cell.1).map(|&node| node as i32).collect::<Vec<_>>(),
    );
    let ends = listed.iter().scan(0, |end, (_, nodes)| {
        *end += nodes.len() as i32;
        Some(*end)
    });
    write_integers(text, "offsets", &ends.collect::<Vec<_>>());
    let types: Vec<u8> = listed.iter().map(|cell| cell.0).collect();
    DataArray { kind: "UInt8", name: "types", components: 1 }.write_array(text, &types);
}

fn vtu_text(body: &Body, frame: &Frame) -> String {
    let solid = body.solid;
    let (points, cells) = (solid.nodes().len(), solid.len());
    let mut text = String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ");
    text += "byte_order=\"LittleEndian\" header_type=\"UInt32\"><UnstructuredGrid>\n";
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    text += "<Points>\n";
    write_reals(&mut text, "position_m", 3, &solid.nodes().concat());
    text += "</Points>\n<Cells>\n";
    write_cells(&mut text, solid);
    text += "</Cells>\n<PointData Vectors=\"displacement_m\">\n";
    write_reals(&mut text, "displacement_m", 3, frame.displacement);
    if let Some(velocity) = frame.velocity {
        write_reals(&mut text, "velocity_m_per_s", 3, velocity);
    }
    if let Some(mode) = frame.mode {
        write_reals(&mut text, "mode", 3, mode);
    }
    text += "</PointData>\n<CellData Scalars=\"von_mises_pa\">\n";
    let stress = element_stresses(solid, frame.displacement, frame.properties);
    write_integers(
        &mut text,
        "region",
        &solid.regions().iter().map(|&r| body.regions[usize::from(r)].tag as i32).collect::<Vec<_>>(),
    );
    write_reals(&mut text, "von_mises_pa", 1, &stress.iter().map(|at| at.von_mises).collect::<Vec<_>>());
    write_reals(
        &mut text,
        "energy_density_j_per_m3",
        1,
        &stress.iter().map(|at| at.energy_density).collect::<Vec<_>>(),
    );
    text + "</CellData>\n</Piece></UnstructuredGrid></VTKFile>\n"
}

fn write_reals(text: &mut String, name: &str, components: usize, values: &[f64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    DataArray { kind: "Float64", name, components }.write_array(text, &bytes);
}

fn write_integers(text: &mut String, name: &str, values: &[i32]) {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    DataArray { kind: "Int32", name, components: 1 }.write_array(text, &bytes);
}

/// Header of a VTK data array.
struct DataArray<'a> {
    /// Its number type.
    kind: &'a str,
    name: &'a str,
    /// Numbers a point or cell.
    components: usize,
}

impl DataArray<'_> {
    fn write_array(&self, text: &mut String, bytes: &[u8]) {
        let Self { kind, name, components } = self;
        let mut payload = (bytes.len() as u32).to_le_bytes().to_vec();
        payload.extend(bytes);
        let _ = write!(
            text,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
        );
        let _ = writeln!(text, "{}</DataArray>", STANDARD.encode(payload));
    }
}

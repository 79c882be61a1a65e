//! `study mesh`: a body, inserts and cavities in STL files to a mesh file, with a report.
//!
//! No project and no case is needed. Every file is written whole under another name and then renamed, so that a run which is stopped leaves none
//! that another program takes for a mesh.

mod measured;
pub mod options;
mod picture;

use std::path::{Path, PathBuf};
use std::time::Instant;

use diagnostics::{Diagnostic, Result, output};
use mesh::foreign::{write_gmsh, write_medit};
use mesh::{Assembly, Chosen, Detail, Measures, MeshError, QuadraticMesh, Settings, Surface, mesh_assembly, stl, vtu};

use measured::Measured;
use options::MeshSurfaces;
use picture::{refusal_picture, section_picture};

/// What was made.
pub struct Meshed {
    /// The report, and where the files lie.
    pub report: String,
}

/// Meshes the surfaces and writes what is asked for; `quiet` leaves the progress out.
///
/// # Errors
/// A [`Diagnostic`] that names the file, the part and the place; before anything is made, when that would take too many elements.
pub fn run(options: &MeshSurfaces, quiet: bool) -> Result<Meshed> {
    let kind = options.out.as_deref().map(MeshFile::of).transpose()?;
    let surfaces = Surfaces::read(options)?;
    let assembly = surfaces.assembly();
    let began = Instant::now();
    let watch = |step: &str| {
        if !quiet {
            output::note(format_args!("{:7.1} s  {step}", began.elapsed().as_secs_f64()));
        }
    };
    let detail = Detail { envelope: options.envelope, smallest: options.smallest, layers: options.layers };
    let set = Settings { method: options.method.into(), use_symmetry: false, detail, ..Settings::new(options.edge) };
    let chosen = mesh_assembly(&assembly, &set, &watch).map_err(|error| refusal(error, options, &surfaces))?;
    let seconds = began.elapsed().as_secs_f64();
    let linear = chosen.solid.clone().into_corners();
    let measures = Measures::new(&linear, &assembly, options.edge);
    if let (Some(kind), Some(path)) = (kind, &options.out) {
        write_whole(path, kind.file_text(&chosen.solid, &surfaces.region_names())?.as_bytes())?;
    }
    if let Some(path) = &options.repair_to {
        write_whole(path, &stl::write(&mesh_skin(&chosen), options.unit.metres(), "repaired by study mesh"))?;
    }
    if let Some(path) = &options.picture {
        write_whole(path, section_picture(&linear).as_bytes())?;
    }
    let measured = Measured { chosen: &chosen, measures: &measures, options, chambers: linear.chambers(), seconds };
    Ok(Meshed { report: measured.to_string() + &written_files(options) })
}

/// Why surfaces are refused; where a picture is asked for and the error names a place, it is drawn.
fn refusal(error: MeshError, options: &MeshSurfaces, surfaces: &Surfaces) -> Diagnostic {
    if let (Some(path), Some(place)) = (&options.picture, error.place()) {
        match write_whole(path, refusal_picture(&surfaces.all(), place).as_bytes()) {
            Ok(()) => output::note(format_args!("picture     the place → {}", path.display())),
            Err(unwritten) => return unwritten,
        }
    }
    Diagnostic::from(error).of(surface_names(options))
}

/// The surfaces of all files.
struct Surfaces {
    body: Surface,
    inserts: Vec<Surface>,
    cavities: Vec<Surface>,
}

impl Surfaces {
    fn read(options: &MeshSurfaces) -> Result<Self> {
        let read = |path: &PathBuf| simulate::read_surface(path, options.unit);
        let mut solids = options.surfaces.iter().map(read).collect::<Result<Vec<Surface>>>()?.into_iter();
        Ok(Self {
            body: solids.next().unwrap_or_default(),
            inserts: solids.collect(),
            cavities: options.cavity.iter().map(read).collect::<Result<_>>()?,
        })
    }

    fn all(&self) -> Vec<&Surface> {
        std::iter::once(&self.body).chain(&self.inserts).chain(&self.cavities).collect()
    }

    fn assembly(&self) -> Assembly<'_> {
        let (inserts, cavities) = (self.inserts.iter().collect(), self.cavities.iter().collect());
        Assembly { body: &self.body, inserts, cavities }
    }

    /// As a case names the regions of surfaces where there is one insert at most.
    fn region_names(&self) -> Vec<String> {
        let insert =
            |number: usize| if self.inserts.len() == 1 { "spine".to_owned() } else { format!("insert_{number}") };
        std::iter::once("body".to_owned()).chain((1..=self.inserts.len()).map(insert)).collect()
    }
}

/// Formats in which a mesh is written.
#[derive(Clone, Copy)]
enum MeshFile {
    Gmsh,
    Vtu,
    Medit,
}

impl MeshFile {
    fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().map(|word| word.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "msh" => Ok(Self::Gmsh),
            "vtu" => Ok(Self::Vtu),
            "mesh" => Ok(Self::Medit),
            _ => Err(Diagnostic::new(
                format!("a mesh cannot be written as .{ending}"),
                "meshes are written as .msh (gmsh 2.2), .vtu and .mesh (MEDIT)",
                "name a file with one of these endings after --out",
            )),
        }
    }

    fn file_text(self, mesh: &QuadraticMesh, regions: &[String]) -> Result<String> {
        let text = match self {
            Self::Gmsh => write_gmsh(mesh, regions),
            Self::Medit => write_medit(mesh),
            Self::Vtu => Some(vtu::write(mesh)),
        };
        text.ok_or_else(|| Diagnostic::new("hexahedra cannot be written", "the format takes tetrahedra", "take .vtu"))
    }
}

/// The mesh's own surface, chambers included: closed, within the envelope of what was read.
fn mesh_skin(chosen: &Chosen) -> Surface {
    let mesh = &chosen.solid;
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    let mut surface = Surface::default();
    for face in &mesh.skin {
        for triangle in face.corner_triangles() {
            surface.faces.push(triangle.map(|node| {
                let slot = &mut number[node as usize];
                if *slot == u32::MAX {
                    *slot = surface.points.len() as u32;
                    surface.points.push(mesh.nodes[node as usize]);
                }
                *slot
            }));
        }
    }
    surface
}

/// Writes a file under another name and renames it when it is whole.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let done = std::fs::write(&partial, bytes).and_then(|()| std::fs::rename(&partial, path));
    done.map_err(|error| {
        let _ = std::fs::remove_file(&partial);
        Diagnostic::io(path, error, "choose another place for the file")
    })
}

fn surface_names(options: &MeshSurfaces) -> String {
    let paths: Vec<String> = options.surfaces.iter().chain(&options.cavity).map(|p| p.display().to_string()).collect();
    paths.join(" with ")
}

fn written_files(options: &MeshSurfaces) -> String {
    let files = [("mesh", &options.out), ("surface", &options.repair_to), ("picture", &options.picture)];
    let line = |(what, path): (&str, &Option<PathBuf>)| Some(format!("{what:<12}{}\n", path.as_ref()?.display()));
    files.into_iter().filter_map(line).collect()
}

//! VTK's legacy files (`.vtk`) of an unstructured grid, text or binary, of versions 2 to 5.
//!
//! Keywords stand at the beginning of lines, each followed by the numbers that it announces; binary ones are big-endian. From version 5 on
//! cells are offsets and connectivity, before that each has the number of its nodes before them.

use super::raw_mesh::{MeshFileError, RawMesh};
use super::tokens::{Tokens, short};
use super::vtk_cells::{TAGS, add_cell};

const AGAIN: &str = "save the mesh as .vtu, or as .vtk of an unstructured grid";

/// Reads a legacy `.vtk`.
///
/// # Errors
/// [`MeshFileError`], with the line.
pub fn vtk(bytes: &[u8]) -> Result<RawMesh, MeshFileError> {
    let mut file = File::open(bytes)?;
    while let Some(word) = file.tokens.next() {
        match word.to_ascii_uppercase().as_slice() {
            b"DATASET" => file.dataset()?,
            b"POINTS" => file.points()?,
            b"CELLS" => file.cells()?,
            b"CELL_TYPES" => {
                let count = file.count("the number of cells")?;
                file.types = file.numbers(count, "int")?;
            }
            b"CELL_DATA" => (file.tuples, file.of_cells) = (file.count("the number of cells")?, true),
            b"POINT_DATA" => (file.tuples, file.of_cells) = (file.count("the number of points")?, false),
            b"SCALARS" => file.scalars()?,
            b"FIELD" => file.field()?,
            b"VECTORS" | b"NORMALS" => file.vectors()?,
            b"METADATA" => file.skip_metadata(),
            other => {
                let what = format!("`{}` is no keyword that is read", short(&String::from_utf8_lossy(other)));
                return Err(file.tokens.error(what, "points, cells, their types and data are", AGAIN));
            }
        }
    }
    file.mesh()
}

/// A file that is being read.
struct File<'a> {
    tokens: Tokens<'a>,
    length: usize,
    binary: bool,
    points: Vec<f64>,
    /// Where the nodes of each cell begin, and where those of the last end.
    offsets: Vec<f64>,
    connectivity: Vec<f64>,
    types: Vec<f64>,
    /// Arrays of cells that may hold a region.
    tags: Vec<(String, Vec<f64>)>,
    tuples: usize,
    of_cells: bool,
}

impl<'a> File<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, MeshFileError> {
        let mut tokens = Tokens::new(bytes, "", None);
        if !tokens.rest_of_line().starts_with(b"# vtk DataFile") {
            return Err(tokens.error("the file does not begin with `# vtk DataFile`", "legacy files of VTK do", AGAIN));
        }
        tokens.rest_of_line();
        let binary = match tokens.word("ASCII or BINARY")?.to_ascii_uppercase().as_str() {
            "ASCII" => false,
            "BINARY" => true,
            other => return Err(tokens.error(format!("the file is {other}"), "it is ASCII or BINARY", AGAIN)),
        };
        let empty = Vec::new;
        let (points, offsets, connectivity, types) = (empty(), empty(), empty(), empty());
        let (tags, length) = (Vec::new(), bytes.len());
        Ok(Self { tokens, length, binary, points, offsets, connectivity, types, tags, tuples: 0, of_cells: false })
    }

    /// Information about an array, up to the next empty line.
    fn skip_metadata(&mut self) {
        self.tokens.rest_of_line();
        while !self.tokens.rest_of_line().trim_ascii().is_empty() {}
    }

    fn dataset(&mut self) -> Result<(), MeshFileError> {
        let kind = self.tokens.word("the kind of the data")?;
        match kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
            true => Ok(()),
            false => Err(self.tokens.error(
                format!("the file holds {}", short(kind)),
                "a solid is an UNSTRUCTURED_GRID",
                AGAIN,
            )),
        }
    }

    /// A count, which a number of at least a byte each must bear out.
    fn count(&mut self, what: &str) -> Result<usize, MeshFileError> {
        let count: usize = self.tokens.number(what)?;
        if count > self.length {
            let why = format!("the file has {} bytes", self.length);
            return Err(self.tokens.error(
                format!("{what} is {count}"),
                why,
                "save the mesh again; the file was cut or edited",
            ));
        }
        Ok(count)
    }

    fn points(&mut self) -> Result<(), MeshFileError> {
        let count = self.count("the number of points")?;
        let kind = self.tokens.word("the type of points")?;
        self.points = self.numbers(3 * count, kind)?;
        Ok(())
    }

    fn cells(&mut self) -> Result<(), MeshFileError> {
        let cells = self.count("the number of cells")?;
        let size = self.count("the number of numbers")?;
        let before = self.tokens.clone();
        if self.tokens.next().is_some_and(|word| word.eq_ignore_ascii_case(b"OFFSETS")) {
            let kind = self.tokens.word("the type of offsets")?;
            self.offsets = self.numbers(cells, kind)?;
            self.tokens.word("CONNECTIVITY")?;
            let kind = self.tokens.word("the type of connectivity")?;
            self.connectivity = self.numbers(size, kind)?;
            return Ok(());
        }
        self.tokens = before;
        let all = self.numbers(size, "int")?;
        self.offsets = vec![0.0];
        let mut at = 0;
        while let Some(count) = all.get(at).map(|count| *count as usize).filter(|_| self.offsets.len() <= cells) {
            self.connectivity.extend(all.iter().skip(at + 1).take(count));
            self.offsets.push(self.connectivity.len() as f64);
            at += 1 + count;
        }
        Ok(())
    }

    fn scalars(&mut self) -> Result<(), MeshFileError> {
        let name = self.tokens.word("the name of scalars")?.to_owned();
        let kind = self.tokens.word("the type of scalars")?;
        let parts = self.tokens.peek().and_then(|word| std::str::from_utf8(word).ok()?.parse::<usize>().ok());
        let parts = parts.filter(|parts| *parts <= 4);
        if parts.is_some() {
            self.tokens.next();
        }
        let before = self.tokens.clone();
        match self.tokens.next() {
            Some(word) if word.eq_ignore_ascii_case(b"LOOKUP_TABLE") => drop(self.tokens.word("the name of a table")?),
            _ => self.tokens = before,
        }
        self.array(name, parts.unwrap_or(1) * self.tuples, kind)
    }

    fn vectors(&mut self) -> Result<(), MeshFileError> {
        let name = self.tokens.word("the name of vectors")?.to_owned();
        let kind = self.tokens.word("the type of vectors")?;
        self.array(name, 3 * self.tuples, kind)
    }

    fn field(&mut self) -> Result<(), MeshFileError> {
        self.tokens.word("the name of a field")?;
        for _ in 0..self.count("the number of arrays")? {
            let mut name = self.tokens.word("the name of an array")?;
            if name.eq_ignore_ascii_case("METADATA") {
                self.skip_metadata();
                name = self.tokens.word("the name of an array")?;
            }
            let (parts, tuples) = (self.count("the components of an array")?, self.count("the length of an array")?);
            let kind = self.tokens.word("the type of an array")?;
            self.array(name.to_owned(), parts.saturating_mul(tuples), kind)?;
        }
        Ok(())
    }

    fn array(&mut self, name: String, count: usize, kind: &str) -> Result<(), MeshFileError> {
        let values = self.numbers(count, kind)?;
        if self.of_cells {
            self.tags.push((name.to_lowercase(), values));
        }
        Ok(())
    }

    fn numbers(&mut self, count: usize, kind: &str) -> Result<Vec<f64>, MeshFileError> {
        let kind = kind.to_ascii_lowercase();
        if count > self.length {
            let why = format!("the file has {} bytes", self.length);
            return Err(self.tokens.error(format!("{count} numbers are announced"), why, AGAIN));
        }
        if self.binary {
            self.tokens.rest_of_line();
        }
        (0..count).map(|_| if self.binary { self.binary(&kind) } else { self.tokens.number("a number") }).collect()
    }

    fn binary(&mut self, kind: &str) -> Result<f64, MeshFileError> {
        let what = "a number";
        Ok(match kind {
            "double" => f64::from_be_bytes(self.tokens.take(what)?),
            "float" => f32::from_be_bytes(self.tokens.take(what)?).into(),
            "int" | "vtkidtype" => i32::from_be_bytes(self.tokens.take(what)?).into(),
            "unsigned_int" => u32::from_be_bytes(self.tokens.take(what)?).into(),
            "long" | "vtktypeint64" | "unsigned_long" => i64::from_be_bytes(self.tokens.take(what)?) as f64,
            "short" => i16::from_be_bytes(self.tokens.take(what)?).into(),
            "unsigned_char" | "char" => u8::from_be_bytes(self.tokens.take(what)?).into(),
            other => {
                return Err(self.tokens.error(
                    format!("numbers are of type {}", short(other)),
                    "VTK has others",
                    AGAIN,
                ));
            }
        })
    }

    fn mesh(self) -> Result<RawMesh, MeshFileError> {
        let mut raw = RawMesh::default();
        let (points, _) = self.points.as_chunks::<3>();
        points.iter().for_each(|at| raw.node(raw.nodes.len() as u64, *at));
        let cells = self.offsets.len().saturating_sub(1);
        let tags = TAGS.iter().find_map(|tag| self.tags.iter().find(|(name, _)| name == tag)).map(|(_, tags)| tags);
        if self.types.len() != cells || tags.is_some_and(|tags| tags.len() != cells) {
            let what = format!("there are {cells} cells, {} types and {:?} tags", self.types.len(), tags.map(Vec::len));
            return Err(self.tokens.error(what, "each cell has one of each", AGAIN));
        }
        for cell in 0..cells {
            let [begin, end] = [self.offsets[cell] as usize, self.offsets[cell + 1] as usize];
            let nodes = self.connectivity.get(begin..end).unwrap_or_default();
            let tag = tags.map_or(0, |tags| tags[cell] as i64);
            add_cell(&mut raw, 0, (self.types[cell], nodes), tag)?;
        }
        Ok(raw)
    }
}

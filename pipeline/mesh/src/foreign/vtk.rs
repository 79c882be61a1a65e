//! VTK's legacy files (`.vtk`) of an unstructured grid, text or binary, of versions 2 to 5.
//!
//! Keywords stand at the beginning of lines, each followed by the numbers that it announces; binary ones are big-endian. From version 5 on
//! cells are offsets and connectivity, before that each has the number of its nodes before them.

use super::raw_mesh::{MeshFileError, RawMesh};
use super::tokens::{Tokens, shortened};
use super::vtk_cells::{TAGS, add_cell};

const AGAIN: &str = "save the mesh as .vtu, or as .vtk of an unstructured grid";

/// Reads a legacy `.vtk`.
///
/// # Errors
/// [`MeshFileError`], with the line.
pub fn vtk(bytes: &[u8]) -> Result<RawMesh, MeshFileError> {
    let mut file = File::open_file(bytes)?;
    while let Some(word) = file.tokens.next() {
        match word.to_ascii_uppercase().as_slice() {
            b"DATASET" => file.read_dataset()?,
            b"POINTS" => file.read_points()?,
            b"CELLS" => file.read_cells()?,
            b"CELL_TYPES" => {
                let count = file.read_count("the number of cells")?;
                file.types = file.read_numbers(count, "int")?;
            }
            b"CELL_DATA" => (file.tuples, file.of_cells) = (file.read_count("the number of cells")?, true),
            b"POINT_DATA" => (file.tuples, file.of_cells) = (file.read_count("the number of points")?, false),
            b"SCALARS" => file.read_scalars()?,
            b"FIELD" => file.read_field()?,
            b"VECTORS" | b"NORMALS" => file.read_vectors()?,
            b"METADATA" => file.skip_metadata(),
            other => {
                let message = format!("`{}` is no keyword that is read", shortened(&String::from_utf8_lossy(other)));
                return Err(file.tokens.error(message, "points, cells, their types and data are", AGAIN));
            }
        }
    }
    file.build_mesh()
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
    fn open_file(bytes: &'a [u8]) -> Result<Self, MeshFileError> {
        let mut tokens = Tokens::new(bytes, "", None);
        if !tokens.rest_of_line().starts_with(b"# vtk DataFile") {
            return Err(tokens.error("the file does not begin with `# vtk DataFile`", "legacy files of VTK do", AGAIN));
        }
        tokens.rest_of_line();
        let binary = match tokens.next_word("ASCII or BINARY")?.to_ascii_uppercase().as_str() {
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

    fn read_dataset(&mut self) -> Result<(), MeshFileError> {
        let kind = self.tokens.next_word("the kind of the data")?;
        match kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
            true => Ok(()),
            false => Err(self.tokens.error(
                format!("the file holds {}", shortened(kind)),
                "a solid is an UNSTRUCTURED_GRID",
                AGAIN,
            )),
        }
    }

    /// A count, which a number of at least a byte each must bear out.
    fn read_count(&mut self, quantity: &str) -> Result<usize, MeshFileError> {
        let count: usize = self.tokens.next_number(quantity)?;
        if count > self.length {
            let why = format!("the file has {} bytes", self.length);
            return Err(self.tokens.error(
                format!("{quantity} is {count}"),
                why,
                "save the mesh again; the file was cut or edited",
            ));
        }
        Ok(count)
    }

    fn read_points(&mut self) -> Result<(), MeshFileError> {
        let count = self.read_count("the number of points")?;
        let kind = self.tokens.next_word("the type of points")?;
        self.points = self.read_numbers(3 * count, kind)?;
        Ok(())
    }

    fn read_cells(&mut self) -> Result<(), MeshFileError> {
        let cells = self.read_count("the number of cells")?;
        let size = self.read_count("the number of numbers")?;
        let unread = self.tokens.clone();
        if self.tokens.next().is_some_and(|word| word.eq_ignore_ascii_case(b"OFFSETS")) {
            let kind = self.tokens.next_word("the type of offsets")?;
            self.offsets = self.read_numbers(cells, kind)?;
            self.tokens.next_word("CONNECTIVITY")?;
            let kind = self.tokens.next_word("the type of connectivity")?;
            self.connectivity = self.read_numbers(size, kind)?;
            return Ok(());
        }
        self.tokens = unread;
        let numbers = self.read_numbers(size, "int")?;
        self.offsets = vec![0.0];
        let mut position = 0;
        while let Some(count) =
            numbers.get(position).map(|count| *count as usize).filter(|_| self.offsets.len() <= cells)
        {
            self.connectivity.extend(numbers.iter().skip(position + 1).take(count));
            self.offsets.push(self.connectivity.len() as f64);
            position += 1 + count;
        }
        Ok(())
    }

    fn read_scalars(&mut self) -> Result<(), MeshFileError> {
        let name = self.tokens.next_word("the name of scalars")?.to_owned();
        let kind = self.tokens.next_word("the type of scalars")?;
        let parts = self.tokens.peek().and_then(|word| std::str::from_utf8(word).ok()?.parse::<usize>().ok());
        let parts = parts.filter(|parts| *parts <= 4);
        if parts.is_some() {
            self.tokens.next();
        }
        let unread = self.tokens.clone();
        match self.tokens.next() {
            Some(word) if word.eq_ignore_ascii_case(b"LOOKUP_TABLE") => {
                self.tokens.next_word("the name of a table")?;
            }
            _ => self.tokens = unread,
        }
        self.read_array(name, parts.unwrap_or(1) * self.tuples, kind)
    }

    fn read_vectors(&mut self) -> Result<(), MeshFileError> {
        let name = self.tokens.next_word("the name of vectors")?.to_owned();
        let kind = self.tokens.next_word("the type of vectors")?;
        self.read_array(name, 3 * self.tuples, kind)
    }

    fn read_field(&mut self) -> Result<(), MeshFileError> {
        self.tokens.next_word("the name of a field")?;
        for _ in 0..self.read_count("the number of arrays")? {
            let mut name = self.tokens.next_word("the name of an array")?;
            if name.eq_ignore_ascii_case("METADATA") {
                self.skip_metadata();
                name = self.tokens.next_word("the name of an array")?;
            }
            let (parts, tuples) =
                (self.read_count("the components of an array")?, self.read_count("the length of an array")?);
            let kind = self.tokens.next_word("the type of an array")?;
            self.read_array(name.to_owned(), parts.saturating_mul(tuples), kind)?;
        }
        Ok(())
    }

    fn read_array(&mut self, name: String, count: usize, kind: &str) -> Result<(), MeshFileError> {
        let values = self.read_numbers(count, kind)?;
        if self.of_cells {
            self.tags.push((name.to_lowercase(), values));
        }
        Ok(())
    }

    fn read_numbers(&mut self, count: usize, kind: &str) -> Result<Vec<f64>, MeshFileError> {
        let kind = kind.to_ascii_lowercase();
        if count > self.length {
            let why = format!("the file has {} bytes", self.length);
            return Err(self.tokens.error(format!("{count} numbers are announced"), why, AGAIN));
        }
        if self.binary {
            self.tokens.rest_of_line();
        }
        (0..count)
            .map(|_| if self.binary { self.read_binary(&kind) } else { self.tokens.next_number("a number") })
            .collect()
    }

    fn read_binary(&mut self, kind: &str) -> Result<f64, MeshFileError> {
        let quantity = "a number";
        Ok(match kind {
            "double" => f64::from_be_bytes(self.tokens.take_bytes(quantity)?),
            "float" => f32::from_be_bytes(self.tokens.take_bytes(quantity)?).into(),
            "int" | "vtkidtype" | "vtktypeint32" => i32::from_be_bytes(self.tokens.take_bytes(quantity)?).into(),
            "unsigned_int" => u32::from_be_bytes(self.tokens.take_bytes(quantity)?).into(),
            "long" | "vtktypeint64" | "unsigned_long" => i64::from_be_bytes(self.tokens.take_bytes(quantity)?) as f64,
            "short" => i16::from_be_bytes(self.tokens.take_bytes(quantity)?).into(),
            "unsigned_char" | "char" => u8::from_be_bytes(self.tokens.take_bytes(quantity)?).into(),
            other => {
                return Err(self.tokens.error(
                    format!("numbers are of type {}", shortened(other)),
                    "VTK has others",
                    AGAIN,
                ));
            }
        })
    }

    fn build_mesh(self) -> Result<RawMesh, MeshFileError> {
        let mut raw = RawMesh::default();
        let (points, _) = self.points.as_chunks::<3>();
        points.iter().for_each(|point| raw.add_node(raw.nodes.len() as u64, *point));
        let cells = self.offsets.len().saturating_sub(1);
        let tags = TAGS.iter().find_map(|tag| self.tags.iter().find(|(name, _)| name == tag)).map(|(_, tags)| tags);
        if self.types.len() != cells || tags.is_some_and(|tags| tags.len() != cells) {
            let message =
                format!("there are {cells} cells, {} types and {:?} tags", self.types.len(), tags.map(Vec::len));
            return Err(self.tokens.error(message, "each cell has one of each", AGAIN));
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

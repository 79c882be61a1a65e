//! A parametric soft fish tail: its own mesh, and its solids as closed surfaces, as a CAD program would export them.
//!
//! x runs along the tail from the clamp to the fin's tip, y sideways (the sheet's normal), z upwards; the tail is
//! symmetric about z = 0. A silicone body holds one row of chambers on each side of a stiff sheet; ribs separate the
//! chambers, a channel through the ribs joins those of one side, and the sheet has a slot at each rib that silicone
//! fills. Behind the body the sheet continues as the caudal fin.
//!
//! ```
//! use tail_cad::{Resolution, Tail};
//!
//! let tail = Tail::nine_chambers();
//! let mesh = tail.mesh(&Resolution::even(&tail, 4e-3))?;
//! assert!(mesh.half && mesh.chambers() == 2);
//! assert!(mesh.nonconformity().is_none());
//! # Ok::<(), tail_cad::TailError>(())
//! ```
//!
//! Depends on `si` and on `mesh`, whose stacks it fills.

mod hexahedra;
mod layers;
mod outline;
mod plan;
mod solids;
mod stations;

use mesh::TetMesh;
use si::{Metre, Point2};

/// Outer size of the body at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Distance from the clamp, m.
    pub x: Metre,
    /// Half the height (in z) there, m.
    pub half_height: Metre,
    /// Half the width (in y) at mid height there, m.
    pub half_width: Metre,
}

/// The parameters of a tail.
#[derive(Debug, Clone, PartialEq)]
pub struct Tail {
    /// The body's outer size, from x = 0 to the body's end.
    pub body: Vec<Station>,
    /// Half the fin's height behind `fin_start`: (x, half height), m, the last one 0.
    pub fin: Vec<(Metre, Metre)>,
    /// Where the sheet's edge leaves the chambers' upper edge and begins to spread into the fin, m.
    pub fin_start: Metre,
    /// Width of the back's flat strip as a fraction of the width at mid height.
    pub back_share: f64,
    /// Power of the section's profile: half width = mid width · (1 − (1 − back_share) · |z / half height|^power).
    pub section_power: f64,
    /// Chambers on each side.
    pub chambers: usize,
    /// Where the first chamber begins, m.
    pub chambers_start: Metre,
    /// Where the last chamber ends, m.
    pub chambers_end: Metre,
    /// How much longer the first chamber of a side is than the others, m.
    pub first_longer: Metre,
    /// Thickness of the ribs between chambers, along x, m.
    pub rib: Metre,
    /// Thickness of the outer wall, along y, on the −y and on the +y side, m.
    pub wall: [Metre; 2],
    /// Silicone between a chamber and the sheet, m.
    pub inner_wall: Metre,
    /// Silicone between the chambers' upper edge and the back, along z, m.
    pub top_wall: Metre,
    /// Half the height of the channel through the ribs, m.
    pub channel_half_height: Metre,
    /// Depth of the channel outwards from the chambers' inner face, m.
    pub channel_depth: Metre,
    /// Thickness of the sheet, m.
    pub sheet: Metre,
    /// By how much the sheet lies off the middle, towards +y, m; less than the silicone between a chamber and the sheet.
    pub sheet_offset: Metre,
    /// Half the height of the slot in the sheet at each rib, as a fraction of the body's half height there.
    pub slot_share: f64,
    /// Where the silicone does not adhere to the sheet; in the tail's own meshes alone.
    pub unbonded: Option<Unbonded>,
}

/// A stretch along which silicone and sheet are separated by a film, which the mesh has as the region [`FILM`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unbonded {
    /// The side of the sheet: 0 is −y, 1 is +y.
    pub side: u16,
    /// It begins with the first of these chambers and ends with the last, ribs between them included.
    pub chambers: [usize; 2],
    /// Thickness of the film, which takes the place of silicone, m.
    pub film: Metre,
}

/// The region of the film along an [`Unbonded`] stretch.
pub const FILM: u16 = 2;

/// The resolution of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Length of edges where no feature needs a smaller one, m.
    pub edge: Metre,
    /// Elements along each chamber.
    pub per_chamber: usize,
    /// Elements along each rib.
    pub per_rib: usize,
}

impl Resolution {
    /// Edges of one length, along chambers and ribs too.
    pub fn even(tail: &Tail, edge: Metre) -> Self {
        let pieces = |length: Metre| (length / edge).round().max(1.0) as usize;
        Self { edge, per_chamber: pieces(tail.chamber_length()), per_rib: pieces(tail.rib) }
    }
}

/// Parameters of which no tail can be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TailError {
    /// A part below its least size.
    #[error(
        "{part} is {size_mm:.3} mm at x = {x_mm:.2} mm\n  why: it must be more than {least_mm:.3} mm to keep the parts separate\n  do:  {action}"
    )]
    TooSmall {
        /// Which part.
        part: &'static str,
        /// Its size, mm.
        size_mm: f64,
        /// The least size, mm.
        least_mm: f64,
        /// Where, mm.
        x_mm: f64,
        /// What to do.
        action: &'static str,
    },
    /// Layers that cross.
    #[error(
        "the layers of the tail cross each other\n  why: layer {lower} lies below layer {upper} in one place and above it in another\n  do:  make the walls thinner or the body wider"
    )]
    CrossingLayers {
        /// A layer.
        lower: u32,
        /// Another layer.
        upper: u32,
    },
    /// Layers that rows and levels do not divide.
    #[error(transparent)]
    Hexahedra(#[from] mesh::MeshError),
}

/// Stations of the tail that was measured: place along it, height and width, mm.
const MEASURED_STATIONS: [(f64, f64, f64); 10] = [
    (0.0, 49.0, 40.22),
    (8.68, 48.54, 39.25),
    (18.23, 46.96, 35.50),
    (26.76, 45.17, 32.72),
    (35.90, 41.28, 29.25),
    (45.78, 37.05, 26.65),
    (57.08, 30.51, 23.62),
    (66.36, 23.03, 19.83),
    (72.0, 18.6, 15.0),
    (80.0, 13.6, 6.0),
];

impl Tail {
    /// A tail of 109.49 mm with nine chambers a side; outer shape measured on a lab's own tail, inside proposed.
    pub fn nine_chambers() -> Self {
        let mm = |x: f64, height: f64, width: f64| Station {
            x: x * 1e-3,
            half_height: height * 0.5e-3,
            half_width: width * 0.5e-3,
        };
        let fin = [(75.65, 33.27), (84.53, 52.06), (90.22, 59.32), (109.49, 0.0)];
        Self {
            body: MEASURED_STATIONS.map(|(x, h, w)| mm(x, h, w)).to_vec(),
            fin: fin.map(|(x, h)| (x * 1e-3, h * 0.5e-3)).to_vec(),
            fin_start: 71e-3,
            back_share: 0.4,
            section_power: 2.4,
            chambers: 9,
            chambers_start: 8e-3,
            chambers_end: 71e-3,
            first_longer: 0.0,
            rib: 2.5e-3,
            wall: [2e-3; 2],
            inner_wall: 0.6e-3,
            top_wall: 2.75e-3,
            channel_half_height: 2e-3,
            channel_depth: 2e-3,
            sheet: 0.5e-3,
            sheet_offset: 0.0,
            slot_share: 0.4,
            unbonded: None,
        }
    }

    /// The same tail with twelve narrower chambers a side.
    pub fn twelve_chambers() -> Self {
        Self { chambers: 12, rib: 2e-3, ..Self::nine_chambers() }
    }

    /// The tail's own mesh: a plan of lines across the tail, filled with the layers as they are defined.
    ///
    /// Only z ≥ 0 is meshed. Chamber 0 lies at y < 0, chamber 1 at y > 0.
    ///
    /// # Errors
    /// [`TailError`] when a part is below its least size.
    pub fn mesh(&self, resolution: &Resolution) -> Result<TetMesh, TailError> {
        self.check_sizes()?;
        let plan = plan::Plan::new(self, resolution);
        layers::fill_plan(self, &plan, resolution.edge, true)
    }

    /// The same body in 20-node hexahedra, graded towards thin walls.
    ///
    /// # Errors
    /// [`TailError`] when a part is below its least size.
    pub fn hexahedra(&self, grading: &mesh::Grading) -> Result<mesh::QuadraticMesh, TailError> {
        self.check_sizes()?;
        hexahedra::half_hexahedra(self, grading)
    }

    /// Body and spine as closed surfaces, both halves, with triangles of about `fineness` (m).
    ///
    /// The two come from different divisions, so their triangles do not match where they touch, as in a CAD export;
    /// planes and straight edges are shared exactly, curved edges to a few micrometres.
    ///
    /// # Errors
    /// [`TailError`] when a part is below its least size.
    pub fn solids(&self, fineness: Metre) -> Result<(mesh::Surface, mesh::Surface), TailError> {
        self.check_sizes()?;
        solids::tail_solids(self, fineness)
    }

    /// Length of a chamber along x, m; the first is longer by `first_longer`.
    pub(crate) fn chamber_length(&self) -> Metre {
        let n = self.chambers as f64;
        (self.chambers_end - self.chambers_start - self.first_longer - (n - 1.0) * self.rib) / n
    }

    /// Where chamber `index` begins and ends, m.
    pub fn chamber(&self, index: usize) -> Point2 {
        let end =
            |i: usize| self.chambers_start + self.first_longer + (i + 1) as f64 * (self.chamber_length() + self.rib);
        let start = if index == 0 { self.chambers_start } else { end(index - 1) };
        [start, end(index) - self.rib]
    }

    /// Where the silicone does not adhere to the sheet begins and ends, m; none where it adheres everywhere.
    pub fn unbonded_stretch(&self) -> Option<Point2> {
        let [first, last] = self.unbonded?.chambers;
        Some([self.chamber(first)[0], self.chamber(last)[1]])
    }

    /// Where rib `index`, which follows the chamber of the same index, begins and ends, m.
    pub(crate) fn rib_at(&self, index: usize) -> Point2 {
        [self.chamber(index)[1], self.chamber(index + 1)[0]]
    }

    /// Refuses parameters that make a part smaller than its least size, with the first place.
    fn check_sizes(&self) -> Result<(), TailError> {
        let length = self.chamber_length();
        let film = self.unbonded.map_or(0.0, |unbonded| unbonded.film);
        let silicone = self.inner_wall - self.sheet_offset.abs() - film;
        require("the silicone between a chamber and the sheet", [silicone, 0.1e-3], 0.0, "lower sheet_offset")?;
        require("a chamber's length", [length, 0.5e-3], self.chambers_start, "take fewer chambers or thinner ribs")?;
        for chamber in 0..self.chambers {
            let x = self.chamber(chamber)[1];
            let z = self.chamber_half_height(x);
            let depth = |side: usize| self.half_width(x, z) - self.wall[side] - self.inner_face();
            let channel = z - self.channel_half_height;
            require("the chamber above the channel", [channel, 0.2e-3], x, "end the chambers further forward")?;
            for side in 0..2 {
                let beyond_channel = depth(side) - if chamber + 1 < self.chambers { self.channel_depth } else { 0.0 };
                require("the chamber's depth beyond the channel", [beyond_channel, 0.2e-3], x, "take a thinner wall")?;
            }
        }
        let slots = (1..self.chambers).map(|i| (self.rib_at(i - 1)[0], self.slot_half_height(i - 1)));
        for (x, slot) in slots {
            require("the slot above the channel", [slot - self.channel_half_height, 0.2e-3], x, "raise slot_share")?;
            let sheet = self.sheet_half_height(x + self.rib) - slot;
            require("the sheet above the slot", [sheet, 0.2e-3], x, "lower slot_share")?;
        }
        Ok(())
    }
}

/// Checks that a part at `x` (m) is larger than its least size (m).
fn require(part: &'static str, [size, least]: [Metre; 2], x: Metre, action: &'static str) -> Result<(), TailError> {
    if size > least {
        return Ok(());
    }
    Err(TailError::TooSmall { part, size_mm: size * 1e3, least_mm: least * 1e3, x_mm: x * 1e3, action })
}

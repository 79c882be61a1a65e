//! The card of a specimen (`specimen.toml`): what the laboratory knows before anything is computed.
//!
//! All numbers are SI; pixels are pixels of the video. The CAD frame is the frame of the STL files: x along the tail
//! from the clamp to the fin's tip, y sideways, z up towards the camera.
//!
//! Stands on: `si`. Never knows: what a pipeline makes of it.

mod check;
mod fixture;
mod marks;
mod read;
mod trial;
mod write;

use serde::Deserialize;
use si::{KilogramPerCubicMetre, Metre, Pascal, Point2, Point3, Second};

pub use check::is_name;
pub use fixture::{Fixture, FixtureOf};
pub use marks::{Axes, Order, Search, Sought, Tracks};
pub use read::{parse, read};
pub use trial::{Experiment, Medium, Role, Side, Split, Trial};
pub use write::write;

/// Everything that a specimen's card says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// The specimen's name, equal to its folder's.
    pub name: String,
    /// Who recorded it.
    pub origin: Origin,
    /// The length that errors are divided by, m.
    pub length: Metre,
    /// The two solids.
    pub solid: Solids,
    /// Where the holder grips.
    pub clamp: Clamp,
    /// The air chambers, one entry each connected cavity.
    pub chamber: Vec<Chamber>,
    /// The tracked marks on the back, from the head to the fin.
    pub marker: Vec<Marker>,
    /// Where the markers are looked for, when they are not clicked.
    #[serde(default)]
    pub search: Option<Search>,
    /// The camera and its calibration.
    pub camera: Camera,
    /// The water that the camera looks through, where a trial is in water.
    #[serde(default)]
    pub water: Option<Water>,
    /// The lamp that both clocks see.
    pub led: Led,
    /// The recordings.
    pub trial: Vec<Trial>,
    /// Tracks of markers that were made elsewhere; a film is tracked here when the card names none for its trial.
    #[serde(default)]
    pub tracks: Vec<Tracks>,
    /// Recordings of the load cell's fixture alone; none when the card is silent.
    #[serde(default)]
    pub fixture: Vec<Fixture>,
}

/// Who recorded a specimen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum Origin {
    /// Computed by the virtual bench; nothing in it was measured.
    #[serde(rename = "virtual bench")]
    VirtualBench,
    /// Measured.
    #[serde(rename = "laboratory")]
    Laboratory,
}

impl Origin {
    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::VirtualBench => crate::VIRTUAL_BENCH,
            Self::Laboratory => "laboratory",
        }
    }
}

/// The unit of the coordinates in the STL files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Millimetres, as most CAD programs write.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    Inch,
}

impl LengthUnit {
    /// One of it in metres.
    pub fn metres(self) -> Metre {
        match self {
            Self::Mm => 1e-3,
            Self::Cm => 1e-2,
            Self::M => 1.0,
            Self::Inch => 0.0254,
        }
    }

    /// The word on the card.
    pub fn word(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::Inch => "inch",
        }
    }
}

/// `[solid]`: the unit of both STL files, and the two solids.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solids {
    /// Unit of the STL files.
    pub unit: LengthUnit,
    /// The soft body with its chambers.
    pub body: Solid,
    /// The stiff sheet.
    pub spine: Solid,
}

/// `[solid.body]`, `[solid.spine]`: a surface and what it is made of, as the data sheet has it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// STL file, relative to the card.
    pub file: String,
    /// Name of the constitutive model, e.g. `neo_hookean`.
    pub material: String,
    /// Nominal Young's modulus, Pa: the first guess of an identification.
    pub youngs_modulus: Pascal,
    /// Poisson's ratio, no unit.
    pub poissons_ratio: f64,
    /// Density, kg/m³.
    pub density: KilogramPerCubicMetre,
    /// Lowest and highest Young's modulus that could be true, Pa: the box an identification searches.
    pub plausible: [Pascal; 2],
}

/// `[clamp]`: which part of the specimen is held.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// Everything at or before this x (m, CAD frame) is held by the holder.
    pub below_x: Metre,
}

/// `[[chamber]]`: one connected cavity.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chamber {
    /// Its name.
    pub name: String,
    /// A point inside it, m, CAD frame.
    pub at: Point3,
    /// The columns of the pressure logs that belong to it.
    pub log: Side,
}

/// `[[marker]]`: one dark mark on the back.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// Where it was painted, m, CAD frame.
    pub at: Point3,
    /// Where it was clicked in the first frame of every trial, px (u to the right, v down, centre of the first pixel 0, 0); none
    /// where [`Search`] finds it.
    #[serde(default)]
    pub clicked: Option<Point2>,
    /// Its diameter, m.
    pub diameter: Metre,
}

/// `[camera]`: the calibration recording.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Video of a checkerboard in several poses, with the same camera and settings as the trials; relative to the card.
    pub calibration: String,
    /// One frame in so many is worth looking at.
    pub frame_every: usize,
    /// How its lens bends rays; as an ordinary one when the card is silent.
    #[serde(default)]
    pub lens: LensKind,
    /// A lens that is known already: OpenCV's YAML, relative to the card. The calibration then only has to show the board on
    /// its plane.
    #[serde(default)]
    pub coefficients: Option<String>,
    /// From the time of the first row of a frame to that of the last, s; the frame's time is its middle row's. 0 when the
    /// card is silent: all rows at once.
    #[serde(default)]
    pub readout: Second,
    /// The checkerboard.
    pub board: Board,
    /// The plane in which the board lay flat at the end.
    pub plane: Plane,
}

/// How a lens bends rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LensKind {
    /// Brown and Conrady's, of ordinary lenses.
    #[default]
    BrownConrady,
    /// Equidistant, of fisheyes.
    Fisheye,
}

/// What is printed on a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardKind {
    /// Black and white squares.
    #[default]
    Checkerboard,
    /// Dark dots in a square grid; the first is the one of its two ends that lies nearer the picture's upper left corner.
    Dots,
}

/// `[camera.board]`: what is shown to the camera. With dots, `columns`, `rows` and `square` are their number each way and the
/// distance between their middles, and what is said of the inner corner (0, 0) holds for the first dot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// What is printed on it; a checkerboard when the card is silent.
    #[serde(default)]
    pub kind: BoardKind,
    /// Squares along the first axis; odd where `rows` is even, or the other way round, so that the board has one way up.
    pub columns: usize,
    /// Squares along the second axis.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
}

/// `[camera.plane]`: when and where the board lay on the plane that ties pixels to the CAD frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// First and last second of the calibration video in which the board lies still on the plane.
    pub seconds: [f64; 2],
    /// Where its inner corner (0, 0) lies, m, x and y of the CAD frame.
    pub origin: Point2,
    /// Unit vector, in x and y of the CAD frame, along which the columns count up. Rows count up a quarter turn
    /// anticlockwise of it, seen from the camera: along (cos a, sin a), the rows run along (−sin a, cos a).
    pub along: Point2,
    /// z of the plane, m, CAD frame.
    pub height: Metre,
    /// Pitch of bright lines on it along x and y of the CAD frame, one of each through its origin, m: by them it is found where
    /// the camera stands in each film.
    pub grid: Option<Metre>,
}

/// `[water]`: the still surface above the specimen, in the trials whose medium is water.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// z of the surface, m, CAD frame.
    pub surface: Metre,
    /// Refractive index, no unit: 1.333 for fresh water at 20 °C.
    pub index: f64,
}

/// `[led]`: the lamp that lights when a trial starts and goes out when it ends.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Led {
    /// Its centre in the picture, px.
    pub centre: Point2,
    /// Its radius in the picture, px.
    pub radius: f64,
}

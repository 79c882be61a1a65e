//! Loads of a case: chambers, dead loads, attached masses.

use super::{Axis, Block, History, Plane};
use serde::Deserialize;
use si::{Kilogram, Pascal, Point3};

/// `[[chamber]]`: a cavity and the pressure in it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chamber {
    /// The prefix of its columns.
    pub name: Option<String>,
    /// A point inside it, m.
    pub inside: Option<Point3>,
    /// Its number, along x, then y, then z of the centroids.
    pub number: Option<usize>,
    /// Pa above ambient; of a sealed chamber, what its gas would have at rest volume.
    #[serde(default)]
    pub pressure: History,
    /// Pa; ambient pressure around a chamber whose gas is closed in.
    pub sealed_in: Option<Pascal>,
}

/// `[[load]]`: a force that keeps its size and direction.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// At the node nearest to this point, m.
    pub near: Option<Point3>,
    /// On the faces of the outer skin in a plane.
    pub plane: Option<Plane>,
    /// On the faces of the outer skin, or along its edges, in a box.
    #[serde(rename = "box")]
    pub block: Option<Block>,
    /// N, at a point.
    pub force: Option<Point3>,
    /// N/m, along edges.
    pub line_force: Option<Point3>,
    /// Pa as a vector, over faces.
    pub traction: Option<Point3>,
    /// On the walls of the chamber around this point, m.
    pub inside: Option<Point3>,
    /// Pa, normal to the faces at rest: it keeps that direction and those areas, unlike the pressure of a [`Chamber`].
    pub pressure: Option<Pascal>,
    /// A CSV file of forces on nodes, relative to the case.
    pub table: Option<String>,
}

/// `[[mass]]`: a mass attached to the body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// At the node nearest to this point, m.
    pub near: Option<Point3>,
    /// On the faces of the outer skin in a plane.
    pub plane: Option<Plane>,
    /// On the faces of the outer skin in a box.
    #[serde(rename = "box")]
    pub block: Option<Block>,
    /// kg, at a point.
    pub mass: Option<Kilogram>,
    /// It hangs on a thread along this axis: its inertia acts along it alone.
    pub hangs: Option<Axis>,
    /// kg/m², over faces.
    pub area_density: Option<f64>,
}

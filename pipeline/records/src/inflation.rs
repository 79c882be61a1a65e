//! Inflation: the skin of the identified model at rising pressures on one side, and the displacement of its walls.

use serde::{Deserialize, Serialize};
use si::{Pascal, Point3, vec3};

use super::Mesh;
use crate::subject::Specimen;
use mesh::wall::{self, Walls};
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// The shapes of a specimen under pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct Inflation {
    /// The nodes of the skin, by their number in the mesh.
    pub nodes: Vec<u32>,
    /// The shapes, from the lowest pressure up.
    pub shapes: Vec<Shape>,
    /// The shape under the pressure of the film's frame, where there is one.
    pub filmed: Option<usize>,
    /// The highest requested pressure, Pa: the last shape has less where no equilibrium was found.
    pub asked_pa: Pascal,
    /// Walls of the film's silhouette at the pressure of its frame.
    pub film: Option<Walls>,
}

/// One shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Pressures in the order of the card's chambers, Pa.
    pub pressures_pa: Vec<Pascal>,
    /// Displacement of each of the nodes, m.
    pub moved: Vec<Point3>,
    /// Displacement of its walls.
    pub walls: Walls,
    /// Their displacement in its silhouette, as the film's camera sees it; none where there is no film of a silhouette.
    pub silhouette: Option<Walls>,
    /// Rotation of its end in the plane, rad.
    pub rotation: f64,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    pressures_pa: Vec<Vec<Pascal>>,
    walls: Vec<(Walls, Option<Walls>)>,
    rotations_rad: Vec<f64>,
    filmed: Option<usize>,
    asked_pa: Pascal,
    film: Option<Walls>,
}

impl Inflation {
    /// The mesh's nodes with the skin moved as in a shape; nodes inside stay.
    pub fn moved(&self, mesh: &Mesh, shape: &Shape) -> Vec<Point3> {
        let mut nodes = mesh.solid.nodes.clone();
        // length: the nodes and every shape's displacements are columns of one table
        for (&node, &displacement) in self.nodes.iter().zip(&shape.moved) {
            nodes[node as usize] = vec3::add(nodes[node as usize], displacement);
        }
        nodes
    }

    /// The pressure at which the slack wall buckles, Pa; none where it hardly dents.
    pub fn buckling_pressure(&self) -> Option<Pascal> {
        wall::buckling_pressure_of(self.shapes.iter().map(|shape| (shape.pressure(), shape.walls)))
    }
}

impl Shape {
    /// The highest of its pressures, Pa.
    pub fn pressure(&self) -> Pascal {
        self.pressures_pa.iter().copied().fold(0.0, f64::max)
    }
}

impl Record for Inflation {
    type Of = Specimen;
    const STAGE: &'static str = "inflate";

    fn is_made_for(specimen: &Specimen) -> bool {
        specimen.highest_staircase().is_some()
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let columns = self.shapes.iter().enumerate().fold(
            Columns::default().counts("node", self.nodes.clone()),
            |columns, (i, shape)| {
                let axis = |k: usize| shape.moved.iter().map(|u| u[k]).collect();
                columns
                    .numbers(&format!("x{i}_m"), axis(0))
                    .numbers(&format!("y{i}_m"), axis(1))
                    .numbers(&format!("z{i}_m"), axis(2))
            },
        );
        let scalars = Scalars {
            pressures_pa: self.shapes.iter().map(|s| s.pressures_pa.clone()).collect(),
            walls: self.shapes.iter().map(|s| (s.walls, s.silhouette)).collect(),
            rotations_rad: self.shapes.iter().map(|s| s.rotation).collect(),
            filmed: self.filmed,
            asked_pa: self.asked_pa,
            film: self.film,
        };
        RecordFiles::default().table("shapes.parquet", &columns)?.scalars("inflation.json", &scalars)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Scalars = files.read_scalars("inflation.json")?;
        let columns = files.read_table("shapes.parquet")?;
        let displacements = |i: usize| -> Result<Vec<Point3>, RecordError> {
            let axis = |k: &str| columns.f64(&format!("{k}{i}_m"));
            let (x, y, z) = (axis("x")?, axis("y")?, axis("z")?);
            // length: columns of one table are equally long
            Ok(x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect())
        };
        let count = scalars.pressures_pa.len();
        if scalars.walls.len() != count
            || scalars.rotations_rad.len() != count
            || scalars.filmed.is_some_and(|i| i >= count)
        {
            return Err(super::inconsistent_file(
                "inflation.json",
                "pressures, walls and rotations are not of the same shapes",
            ));
        }
        let levels = scalars.pressures_pa.into_iter().zip(scalars.walls).zip(scalars.rotations_rad).enumerate();
        let shape = |(i, ((pressures_pa, (walls, silhouette)), rotation))| {
            Ok(Shape { pressures_pa, moved: displacements(i)?, walls, silhouette, rotation })
        };
        Ok(Self {
            nodes: columns.u32("node")?,
            shapes: levels.map(shape).collect::<Result<_, RecordError>>()?,
            filmed: scalars.filmed,
            asked_pa: scalars.asked_pa,
            film: scalars.film,
        })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |quantity: &str| format!("inflate.{subject}.{quantity}");
        let Some(shape) = self.filmed.map_or(self.shapes.last(), |i| self.shapes.get(i)) else { return Vec::new() };
        let mut metrics = vec![
            Metric::new(id("pressure_mbar"), shape.pressure() / si::MILLIBAR, "mbar"),
            Metric::new(id("dent_mm"), shape.walls.dent_m / si::MILLIMETRE, "mm"),
            Metric::new(id("bulge_mm"), shape.walls.bulge_m / si::MILLIMETRE, "mm"),
            Metric::new(id("angle_deg"), shape.rotation.abs().to_degrees(), "degrees"),
        ];
        if let (Some(silhouette), Some(film)) = (shape.silhouette, self.film) {
            let mm = |quantity: &str, length: f64| Metric::new(id(quantity), length / si::MILLIMETRE, "mm");
            metrics.push(mm("silhouette_dent_mm", silhouette.dent_m));
            metrics.push(mm("silhouette_dent_error_mm", (silhouette.dent_m - film.dent_m).abs()));
            metrics.push(mm("silhouette_bulge_error_mm", (silhouette.bulge_m - film.bulge_m).abs()));
        }
        let last =
            self.shapes.last().map(|s| Metric::new(id("highest_angle_deg"), s.rotation.abs().to_degrees(), "degrees"));
        metrics.extend(last);
        let critical = self.buckling_pressure().map(|p| Metric::new(id("critical_mbar"), p / si::MILLIBAR, "mbar"));
        metrics.extend(critical);
        metrics
    }

    fn summary(&self) -> String {
        let Some(last) = self.shapes.last() else { return "no shape".into() };
        let (count, top, dent) = (self.shapes.len(), last.pressure() / si::MILLIBAR, last.walls.dent_m);
        let (dent, angle) = (dent / si::MILLIMETRE, last.rotation.abs().to_degrees());
        let buckled = self.buckling_pressure().map(|p| format!(", which buckles near {:.0} mbar", p / si::MILLIBAR));
        let buckled = buckled.unwrap_or_default();
        format!(
            "{count} shapes up to {top:.0} mbar, the end turned by {angle:.1}°, dent of the other wall {dent:.2} mm{buckled}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_survive_their_record() {
        let walls = Walls { dent_m: 1e-3, dent_at: [0.02, -0.01, 0.0], bulge_m: 2e-3 };
        let shape = |p: f64| {
            let displacements = vec![[p * 1e-6, 0.0, 1e-3]; 2];
            Shape { pressures_pa: vec![p, 0.0], moved: displacements, walls, silhouette: Some(walls), rotation: 0.2 }
        };
        let (shapes, film) = (vec![shape(1e4), shape(2e4)], Some(walls));
        let inflation = Inflation { nodes: vec![3, 8], shapes, filmed: Some(1), asked_pa: 3e4, film };
        assert_eq!(Inflation::from_files(&inflation.to_files().unwrap()).unwrap(), inflation);
    }
}

//! A body in space for the page: its surfaces, and where their points are at each pressure, as few bytes.
//!
//! Stands on: the mesh and inflation records, the surfaces of solids. Never knows: how a browser draws it.

use std::collections::{BTreeMap, BTreeSet};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use si::{MILLIBAR, Point3, vec3};

use crate::figures::solid::{Bounds, Surfaces};
use crate::records::{Inflation, Mesh};

/// A body and its shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// The specimen's name.
    pub name: String,
    /// Whether it is the upper half of a symmetric body.
    pub half: bool,
    /// Pressure of each shape, mbar; the first is rest.
    pub levels: Vec<f64>,
    /// Where its points are in each shape, m: shapes × points.
    pub points: Vec<Vec<Point3>>,
    /// Its surfaces, by index of points.
    pub surfaces: Vec<(Bounds, Vec<[u32; 3]>)>,
}

/// More faces than this are too slow to draw one by one: then curved faces are drawn flat.
const MOST_FACES: usize = 24_000;
/// Steps of a coordinate, to either side.
const STEPS: f64 = 32_000.0;

impl Body {
    /// A specimen's skin at rest and in every shape.
    pub fn new(name: &str, mesh: &Mesh, inflation: &Inflation) -> Self {
        let fine = Surfaces::fine(&mesh.solid);
        let faces =
            if fine.values().map(Vec::len).sum::<usize>() > MOST_FACES { Surfaces::coarse(&mesh.solid) } else { fine };
        let known: BTreeSet<u32> = inflation.nodes.iter().copied().collect();
        let moves = |f: &&[u32; 3]| f.iter().all(|n| known.contains(n));
        let faces: Vec<(Bounds, Vec<[u32; 3]>)> =
            faces.iter().map(|(on, all)| (*on, all.iter().filter(moves).copied().collect())).collect();
        let used: BTreeSet<u32> = faces.iter().flat_map(|(_, all)| all.iter().flatten().copied()).collect();
        let place: BTreeMap<u32, u32> = used.iter().enumerate().map(|(i, &n)| (n, i as u32)).collect();
        let numbered = |all: Vec<[u32; 3]>| all.into_iter().map(|f| f.map(|n| place[&n])).collect();
        let pick = |nodes: &[Point3]| used.iter().map(|&n| nodes[n as usize]).collect::<Vec<Point3>>();
        let shapes = inflation.shapes.iter().map(|s| pick(&inflation.moved(mesh, s)));
        Self {
            name: name.into(),
            half: mesh.solid.half,
            levels: std::iter::once(0.0).chain(inflation.shapes.iter().map(|s| s.pressure() / MILLIBAR)).collect(),
            points: std::iter::once(pick(&mesh.solid.nodes)).chain(shapes).collect(),
            surfaces: faces.into_iter().map(|(on, all)| (on, numbered(all))).collect(),
        }
    }

    /// As JSON, points as 16-bit and faces as 32-bit whole numbers in base64, little end first.
    pub fn json(&self) -> String {
        let far = self.points.iter().flatten().flatten().fold(0.0, |far: f64, v| far.max(v.abs()));
        let scale = far.max(f64::MIN_POSITIVE) / STEPS;
        let at = self.points.iter().flatten().flatten().flat_map(|v| ((v / scale).round() as i16).to_le_bytes());
        let faces = self.surfaces.iter().flat_map(|(_, all)| all.iter().flatten()).flat_map(|n| n.to_le_bytes());
        let group = |(on, all): &(Bounds, Vec<[u32; 3]>)| {
            let (colour, inside) = (on.colour(), on.is_cut() || matches!(on, Bounds::Chamber(_)));
            json!({ "colour": [colour.0, colour.1, colour.2], "inside": inside, "count": all.len() })
        };
        let rest = self.points.first().map_or(&[][..], Vec::as_slice);
        let last = self.points.last().map_or(&[][..], Vec::as_slice);
        let ends = |k: usize| {
            let all = rest.iter().chain(last).map(move |p| p[k]);
            [f64::min, f64::max].map(|pick| all.clone().reduce(pick).unwrap_or(0.0))
        };
        let ([left, right], [low, high]) = (ends(0), ends(1));
        let moved = |shape: &Vec<Point3>| {
            shape.iter().zip(rest).map(|(a, b)| vec3::norm(vec3::sub(*a, *b))).fold(0.0, f64::max)
        };
        let value = json!({
            "name": self.name,
            "half": self.half,
            "levels": self.levels.iter().map(|p| (p * 10.0).round() / 10.0).collect::<Vec<_>>(),
            "count": rest.len(),
            "scale": scale,
            "middle": [0.5 * (left + right), 0.5 * (low + high)],
            "reach": right - left,
            "most": self.points.last().map_or(0.0, moved),
            "groups": self.surfaces.iter().map(group).collect::<Vec<_>>(),
            "at": STANDARD.encode(at.collect::<Vec<u8>>()),
            "faces": STANDARD.encode(faces.collect::<Vec<u8>>()),
        });
        value.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_read_back_to_a_thirty_thousandth_of_the_largest() {
        let points = vec![vec![[0.1, -0.02, 0.03], [0.0, 0.0125, 0.0]], vec![[0.09, 0.01, 0.03], [0.0, 0.0126, 0.001]]];
        let surfaces = vec![(Bounds::Body, vec![[0, 1, 0]])];
        let body = Body { name: "a".into(), half: true, levels: vec![0.0, 250.0], points: points.clone(), surfaces };
        let json: serde_json::Value = serde_json::from_str(&body.json()).unwrap();
        let bytes = STANDARD.decode(json["at"].as_str().unwrap()).unwrap();
        let scale = json["scale"].as_f64().unwrap();
        let read = bytes.chunks_exact(2).map(|b| scale * f64::from(i16::from_le_bytes([b[0], b[1]])));
        let written = points.iter().flatten().flatten();
        // half a step of 0.1 m / 32000
        assert!(read.zip(written).all(|(a, b)| (a - b).abs() < 1.6e-6));
        assert_eq!(json["groups"][0]["count"], 1);
        assert_eq!(STANDARD.decode(json["faces"].as_str().unwrap()).unwrap().len(), 12);
    }
}

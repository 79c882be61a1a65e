//! A body in space for the page: its surfaces, and the positions of their points at each pressure, in compact form.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plot::Colour;
use serde_json::json;
use si::{Point3, vec3};

/// A body and its shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Whether it is the upper half of a symmetric body.
    pub half: bool,
    /// Load of each shape, in the unit of the slider; the first is rest.
    pub levels: Vec<f64>,
    /// Positions of its points in each shape, m: shapes × points.
    pub points: Vec<Vec<Point3>>,
    /// Its surfaces.
    pub surfaces: Vec<Surface>,
}

/// Triangles of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Their colour.
    pub colour: Colour,
    /// Whether they are visible only where the body is cut open.
    pub inside: bool,
    /// By index of points.
    pub faces: Vec<[u32; 3]>,
}

/// Steps of a coordinate, to either side.
const STEPS: f64 = 32_000.0;

impl Body {
    /// As JSON, points as 16-bit and faces as 32-bit whole numbers in base64, little end first.
    pub fn json(&self) -> String {
        let greatest = self.points.iter().flatten().flatten().fold(0.0, |greatest: f64, v| greatest.max(v.abs()));
        let scale = greatest.max(f64::MIN_POSITIVE) / STEPS;
        let coordinates =
            self.points.iter().flatten().flatten().flat_map(|v| ((v / scale).round() as i16).to_le_bytes());
        let faces =
            self.surfaces.iter().flat_map(|surface| surface.faces.iter().flatten()).flat_map(|n| n.to_le_bytes());
        let group = |surface: &Surface| {
            let colour = surface.colour;
            json!({ "colour": [colour.0, colour.1, colour.2], "inside": surface.inside, "count": surface.faces.len() })
        };
        let rest_shape = self.points.first().map_or(&[][..], Vec::as_slice);
        let last = self.points.last().map_or(&[][..], Vec::as_slice);
        let ends = |k: usize| {
            let extremes = rest_shape.iter().chain(last).map(move |p| p[k]);
            [f64::min, f64::max].map(|extremum| extremes.clone().reduce(extremum).unwrap_or(0.0))
        };
        let ([left, right], [low, high]) = (ends(0), ends(1));
        let displacement = |shape: &Vec<Point3>| {
            shape.iter().zip(rest_shape).map(|(a, b)| vec3::norm(vec3::sub(*a, *b))).fold(0.0, f64::max)
        };
        let value = json!({
            "name": self.name,
            "half": self.half,
            "levels": self.levels.iter().map(|p| (p * 10.0).round() / 10.0).collect::<Vec<_>>(),
            "count": rest_shape.len(),
            "scale": scale,
            "middle": [0.5 * (left + right), 0.5 * (low + high)],
            "reach": right - left,
            "most": self.points.last().map_or(0.0, displacement),
            "groups": self.surfaces.iter().map(group).collect::<Vec<_>>(),
            "at": STANDARD.encode(coordinates.collect::<Vec<u8>>()),
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
        let surfaces = vec![Surface { colour: plot::palette::BODY, inside: false, faces: vec![[0, 1, 0]] }];
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

//! Chambers: the cavities of the surfaces that are chambers, and their numbers.

use super::patches::Part;
use crate::Shell;
use crate::frame::Frame;
use si::{CubicMetre, Metre};
use std::cmp::Ordering;

/// The cavities of both parts, in the order of their numbers.
pub(crate) struct Chambers {
    /// Number of each shell of each part; none for a shell that is no chamber.
    pub of_shell: [Vec<Option<u16>>; 2],
    /// Volume of each chamber, m³.
    pub volumes: Vec<CubicMetre>,
}

impl Chambers {
    /// Numbers all cavities: first those below the sheet's centroid, then those above, each along x, y, z.
    ///
    /// A cavity of the body that has the volume and centroid of a shell of the spine holds the spine and is no chamber. In a half model
    /// cavities whose centroid lies further than `below` (m) under z = 0 are mirror images and have no number.
    pub fn new(parts: &[Part; 2], frame: Frame, below: Option<Metre>) -> Self {
        let middle = parts[1].shells.first().map_or(0.0, |s| s.centroid[frame.normal]);
        let mut cavities = Vec::new();
        for (p, part) in parts.iter().enumerate() {
            let meshed = |s: &Shell| below.is_none_or(|tolerance| s.centroid[2] >= -tolerance);
            let hollow =
                |(_, s): &(usize, &Shell)| s.volume < 0.0 && meshed(s) && !(p == 0 && holds_spine(s, &parts[1]));
            cavities.extend(part.shells.iter().enumerate().filter(hollow).map(|(i, shell)| (shell, p, i)));
        }
        cavities.sort_by(|a, b| {
            let above = |s: &Shell| s.centroid[frame.normal] > middle;
            above(a.0).cmp(&above(b.0)).then(centroid_order(a.0, b.0))
        });
        let mut of_shell = [0, 1].map(|p: usize| vec![None; parts[p].shells.len()]);
        cavities.iter().enumerate().for_each(|(k, (_, p, s))| of_shell[*p][*s] = Some(k as u16));
        Self { of_shell, volumes: cavities.iter().map(|c| -c.0.volume).collect() }
    }
}

fn centroid_order(a: &Shell, b: &Shell) -> Ordering {
    let axes = a.centroid.iter().zip(&b.centroid).map(|(x, y)| x.total_cmp(y));
    axes.fold(Ordering::Equal, Ordering::then)
}

fn holds_spine(cavity: &Shell, spine: &Part) -> bool {
    let size = cavity.volume.abs().cbrt();
    // To a hundredth: both surfaces are triangulated for themselves, and chords of their round parts differ.
    let same = |s: &Shell| {
        let distance = (0..3).map(|k| (s.centroid[k] - cavity.centroid[k]).abs()).fold(0.0, f64::max);
        (s.volume + cavity.volume).abs() < 0.01 * s.volume.abs() && distance < 0.01 * size
    };
    spine.shells.iter().any(same)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};

    #[test]
    fn chambers_below_the_sheet_come_first_and_the_spines_cavity_is_none() {
        let (sheet_low, sheet_high) = ([0.01, -0.001, -0.01], [0.05, 0.001, 0.01]);
        let body = block([0.0, -0.01, -0.02], [0.06, 0.01, 0.02]);
        let body = with_cavity(body, [0.01, 0.003, -0.01], [0.02, 0.006, 0.01]);
        let body = with_cavity(body, sheet_low, sheet_high);
        let body = with_cavity(body, [0.03, -0.006, -0.01], [0.04, -0.003, 0.01]);
        let spine = block(sheet_low, sheet_high);
        let parts = [Part::new(&body).unwrap(), Part::new(&spine).unwrap()];
        let chambers = Chambers::new(&parts, Frame { normal: 1 }, None);
        assert_eq!(chambers.of_shell, [vec![None, Some(1), None, Some(0)], vec![None]]);
        assert_eq!(chambers.volumes.len(), 2);
    }

    #[test]
    fn a_half_model_has_no_chamber_below_its_plane() {
        let body = block([0.0, -0.01, -0.02], [0.06, 0.01, 0.02]);
        let body = with_cavity(body, [0.01, -0.005, -0.015], [0.05, 0.005, -0.01]);
        let body = with_cavity(body, [0.01, -0.005, -0.005], [0.05, 0.005, 0.005]);
        let body = with_cavity(body, [0.01, -0.005, 0.01], [0.05, 0.005, 0.015]);
        let none = crate::Surface::default();
        let parts = [Part::new(&body).unwrap(), Part::without_surface(&none)];
        let chambers = Chambers::new(&parts, Frame { normal: 1 }, Some(1e-6));
        assert_eq!(chambers.of_shell[0], [None, None, Some(0), Some(1)]);
        let set = crate::Settings::new(0.005);
        let (half, report) = crate::mesh_without_sheet(&body, &set).unwrap();
        assert!(half.half && half.chambers() == 2);
        let volumes: Vec<f64> = report.chambers.iter().map(|c| c.volume).collect();
        assert!((volumes[0] / 4e-6 - 1.0).abs() < 1e-6 && (volumes[1] / 2e-6 - 1.0).abs() < 1e-6, "{volumes:?}");
    }
}

//! Frame: the axis that is normal to the sheet, so that one mesher serves all three.
//!
//! A plan point is (p, q) and a height h, with p, q, h cyclic in x, y, z: a counterclockwise triangle in (p, q) has
//! its normal along +h. For a sheet in the x–z plane h = y, p = z, q = x.

use si::{Metre, Point2, Point3};

/// The axis of the heights: 0, 1 or 2 for x, y or z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Index of the axis.
    pub normal: usize,
}

impl Frame {
    /// Plan point and height of a point in space, m.
    pub fn split(self, point: Point3) -> (Point2, Metre) {
        ([point[(self.normal + 1) % 3], point[(self.normal + 2) % 3]], point[self.normal])
    }

    /// The point in space, m.
    pub fn join(self, plan: Point2, height: Metre) -> Point3 {
        let mut point = [0.0; 3];
        point[self.normal] = height;
        point[(self.normal + 1) % 3] = plan[0];
        point[(self.normal + 2) % 3] = plan[1];
        point
    }

    /// Index in a plan point of the space axis `axis`; none for the normal itself.
    pub(crate) fn plan_axis(self, axis: usize) -> Option<usize> {
        (0..2).find(|k| (self.normal + 1 + k) % 3 == axis)
    }
}

/// Twice the signed area of a plan triangle, m²; positive when counterclockwise.
pub fn doubled_area(a: Point2, b: Point2, c: Point2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splitting_and_joining_gives_the_point_back_for_every_axis() {
        for normal in 0..3 {
            let frame = Frame { normal };
            let (plan, height) = frame.split([1.0, 2.0, 3.0]);
            assert_eq!(frame.join(plan, height), [1.0, 2.0, 3.0]);
            assert_eq!(frame.plan_axis(normal), None);
        }
        assert_eq!(Frame { normal: 1 }.split([1.0, 2.0, 3.0]), ([3.0, 1.0], 2.0));
    }
}

//! Outline: extents of the tail's outer surface, sheet and chambers, and points for drawings and markers.

use super::Tail;
use super::stations::Curve;
use si::{Metre, Point3};

impl Tail {
    /// Where the body ends, m.
    pub fn body_end(&self) -> Metre {
        self.body.last().map_or(0.0, |s| s.x)
    }

    /// Where the fin ends, m.
    pub fn length(&self) -> Metre {
        self.fin.last().map_or(self.body_end(), |f| f.0)
    }

    /// Half the body's height at `x`, m; held beyond the body's ends.
    pub fn half_height(&self, x: Metre) -> Metre {
        Curve::new(self.body.iter().map(|s| (s.x, s.half_height)).collect()).value(x)
    }

    /// Half the body's width at `x` and height `z`, m; held above the back.
    pub fn half_width(&self, x: Metre, z: Metre) -> Metre {
        let middle = Curve::new(self.body.iter().map(|s| (s.x, s.half_width)).collect()).value(x);
        let relative_height = (z.abs() / self.half_height(x)).min(1.0);
        middle * (1.0 - (1.0 - self.back_share) * relative_height.powf(self.section_power))
    }

    /// The point of the back above the sheet at `x`: a place for a marker, m.
    pub fn back_point(&self, x: Metre) -> Point3 {
        [x, 0.0, self.half_height(x)]
    }

    /// Half the height of the chambers at `x`, m.
    pub(crate) fn chamber_half_height(&self, x: Metre) -> Metre {
        self.half_height(x) - self.top_wall
    }

    /// Half the height of the sheet at `x`, m: the chambers' in front, the fin's behind.
    pub fn sheet_half_height(&self, x: Metre) -> Metre {
        if x <= self.fin_start {
            return self.chamber_half_height(x);
        }
        let start = (self.fin_start, self.chamber_half_height(self.fin_start));
        Curve::new([start].into_iter().chain(self.fin.iter().copied()).collect()).value(x)
    }

    /// Half the height of the slot at rib `rib`, m; one height a slot, so that it is a box.
    pub(crate) fn slot_half_height(&self, rib: usize) -> Metre {
        let [from, to] = self.rib_at(rib);
        self.slot_share * self.half_height((from + to) / 2.0)
    }

    /// Distance of the chambers' inner face from the sheet's middle plane, m.
    pub fn inner_face(&self) -> Metre {
        self.sheet / 2.0 + self.inner_wall
    }

    /// Where the sheet's edge comes out of the body's back, m.
    pub(crate) fn fin_root(&self) -> Metre {
        let buried = |x: Metre| self.sheet_half_height(x) < self.half_height(x);
        let (mut low, mut high) = (self.fin_start, self.body_end());
        if buried(high) {
            return high;
        }
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if buried(middle) { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_meets_the_measured_stations() {
        let tail = Tail::nine_chambers();
        assert!((tail.half_height(26.76e-3) - 22.585e-3).abs() < 1e-12);
        assert!((tail.half_width(45.78e-3, 0.0) - 13.325e-3).abs() < 1e-12);
        assert!((tail.sheet_half_height(84.53e-3) - 26.03e-3).abs() < 1e-12);
        assert!(tail.sheet_half_height(tail.length()).abs() < 1e-15);
        assert!((tail.half_width(0.0, tail.half_height(0.0)) - 0.4 * 20.11e-3).abs() < 1e-12);
    }

    #[test]
    fn the_sheet_comes_out_of_the_back_before_the_body_ends() {
        let tail = Tail::nine_chambers();
        let root = tail.fin_root();
        assert!(root > tail.fin_start && root < tail.body_end());
        assert!((tail.sheet_half_height(root) - tail.half_height(root)).abs() < 1e-9);
    }
}

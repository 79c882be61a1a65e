//! Ranks: a topological order of all sheets by "lies below".

use std::collections::{BTreeMap, BTreeSet};

/// A sheet that lies below another in one place and above it in another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cycle {
    /// Lies below in the first place.
    pub lower: u32,
    /// Lies above there.
    pub upper: u32,
}

/// The relation "lies below" and the mean heights of the sheets.
#[derive(Debug, Default)]
pub(crate) struct Order {
    below: BTreeSet<(u32, u32)>,
    heights: BTreeMap<u32, (f64, usize)>,
}

impl Order {
    /// Notes that `lower` lies below `upper`.
    pub(crate) fn note_below(&mut self, lower: u32, upper: u32) {
        self.below.insert((lower, upper));
    }

    /// Notes one height of a sheet, m.
    pub(crate) fn note_height(&mut self, sheet: u32, height: f64) {
        let (sum, count) = self.heights.entry(sheet).or_default();
        *sum += height;
        *count += 1;
    }

    fn mean_height(&self, sheet: u32) -> f64 {
        self.heights.get(&sheet).map_or(f64::NEG_INFINITY, |(sum, count)| sum / *count as f64)
    }

    /// A rank for each sheet, in the unit of heights: its mean height, raised until it is above all that lie below.
    ///
    /// Conformity only requires a total order. Ranks close to the mean heights let neighbouring lines advance at the same
    /// rate, which keeps the tetrahedra well shaped.
    ///
    /// # Errors
    /// [`Cycle`] when no order exists.
    pub(crate) fn sheet_ranks(&self, sheets: usize, gap: f64) -> Result<Vec<f64>, Cycle> {
        let mut waiting = vec![0usize; sheets];
        self.below.iter().for_each(|&(_, upper)| waiting[upper as usize] += 1);
        let mut ranks: Vec<f64> = (0..sheets as u32).map(|s| self.mean_height(s)).collect();
        let mut ready: Vec<u32> = (0..sheets as u32).filter(|&s| waiting[s as usize] == 0).collect();
        let mut done = 0;
        while let Some(lower) = ready.pop() {
            done += 1;
            for &(_, upper) in self.below.range((lower, 0)..=(lower, u32::MAX)) {
                let upper_index = upper as usize;
                // The greatest of all below: which sheet becomes ready first makes no difference.
                ranks[upper_index] = ranks[upper_index].max(ranks[lower as usize] + gap);
                waiting[upper_index] -= 1;
                if waiting[upper_index] == 0 {
                    ready.push(upper);
                }
            }
        }
        if done == sheets { Ok(ranks) } else { Err(self.find_cycle(&waiting)) }
    }

    fn find_cycle(&self, waiting: &[usize]) -> Cycle {
        let stuck = |&&(a, b): &&(u32, u32)| waiting[a as usize] > 0 && waiting[b as usize] > 0;
        let both_ways = |&&(a, b): &&(u32, u32)| self.below.contains(&(b, a));
        let mut pairs = self.below.iter().filter(stuck);
        let first = pairs.clone().find(both_ways).or_else(|| pairs.next());
        let &(lower, upper) = first.expect("a sheet waits only for another one that waits");
        Cycle { lower, upper }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_follow_mean_heights_where_the_order_allows_it() {
        let mut order = Order::default();
        [(0, 1.0), (1, 5.0), (2, 3.0)].iter().for_each(|&(s, h)| order.note_height(s, h));
        order.note_below(0, 1);
        order.note_below(1, 2);
        assert_eq!(order.sheet_ranks(3, 0.5), Ok(vec![1.0, 5.0, 5.5]));
    }

    #[test]
    fn sheets_that_lie_below_each_other_are_refused() {
        let mut order = Order::default();
        order.note_below(0, 1);
        order.note_below(1, 0);
        assert_eq!(order.sheet_ranks(2, 0.1), Err(Cycle { lower: 0, upper: 1 }));
    }
}

//! Pictorial structures [felzenszwalb2005]: parts joined to a tree take the places of least total cost.
//!
//! The least cost over all assignments is exact and takes n m² evaluations for n parts and m places, by dynamic programming from the
//! leaves to the root; on a row of markers the tree is the row, and this is Viterbi's algorithm. The Hungarian method, which finds
//! the best assignment of costs that each belong to one part, cannot weigh how two neighbours move: of equal markers that all move by
//! their spacing it assigns each to the place that its neighbour left.

use si::Point2;

use super::distance;

/// A tree over parts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpanningTree {
    /// Parents before children.
    order: Vec<usize>,
    /// `None` for the root, the first part.
    parents: Vec<Option<usize>>,
}

/// Two parts that the tree joins, child and parent, or their places.
pub(super) type Pair = [usize; 2];

/// What an assignment costs, no unit; infinite where it is impossible.
pub(super) trait Cost {
    /// Number of places.
    fn place_count(&self) -> usize;
    /// Of a part at a place, or at none.
    fn part_cost(&self, part: usize, place: Option<usize>) -> f64;
    /// Of two parts that the tree joins, each at its place.
    fn pair_cost(&self, parts: Pair, places: Pair) -> f64;
}

impl SpanningTree {
    /// The tree of least total length over some points, by Prim's algorithm.
    pub(super) fn of_least_length(points: &[Point2]) -> Self {
        // of each part that is not in the tree yet: its distance from the tree, and from which part
        let mut open: Vec<(usize, f64, Option<usize>)> = (0..points.len()).map(|k| (k, f64::INFINITY, None)).collect();
        let (mut order, mut parents) = (Vec::new(), vec![None; points.len()]);
        while let Some(k) = (0..open.len()).min_by(|a, b| open[*a].1.total_cmp(&open[*b].1)) {
            let (part, _, parent) = open.remove(k);
            parents[part] = parent;
            order.push(part);
            for (other, nearest, from) in &mut open {
                let away = distance(points[*other], points[part]);
                if away < *nearest {
                    (*nearest, *from) = (away, Some(part));
                }
            }
        }
        Self { order, parents }
    }

    /// The pairs that it joins, as (child, parent).
    pub(super) fn joined_pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        self.parents.iter().enumerate().filter_map(|(part, parent)| Some([part, (*parent)?]))
    }

    /// The assignment of least total cost: the place of each part, or none.
    pub(super) fn cheapest_assignment(&self, cost: &impl Cost) -> Vec<Option<usize>> {
        let choices: Vec<Option<usize>> = (0..cost.place_count()).map(Some).chain([None]).collect();
        let parts = self.parents.len();
        // cost of each part's branch by the part's own choice; the part's best choice by its parent's
        let own_costs = |part: usize| choices.iter().map(|&c| cost.part_cost(part, c)).collect();
        let mut branch: Vec<Vec<f64>> = (0..parts).map(own_costs).collect();
        let mut best: Vec<Vec<usize>> = vec![vec![choices.len() - 1; choices.len()]; parts];
        for &part in self.order.iter().rev() {
            let Some(parent) = self.parents[part] else { continue };
            for (k, &parent_choice) in choices.iter().enumerate() {
                let joined = |c: usize| {
                    let pair =
                        choices[c].zip(parent_choice).map_or(0.0, |(a, b)| cost.pair_cost([part, parent], [a, b]));
                    branch[part][c] + pair
                };
                let (choice, least) = least_value(choices.len(), joined);
                best[part][k] = choice;
                branch[parent][k] += least;
            }
        }
        let mut chosen = vec![choices.len() - 1; parts];
        for &part in &self.order {
            let choice = self.parents[part].map(|parent| best[part][chosen[parent]]);
            chosen[part] = choice.unwrap_or_else(|| least_value(choices.len(), |c| branch[part][c]).0);
        }
        chosen.into_iter().map(|c| choices[c]).collect()
    }
}

/// The first of the least values of a function of 0 to `count` − 1, with that value.
fn least_value(count: usize, value: impl Fn(usize) -> f64) -> (usize, f64) {
    (0..count).map(|c| (c, value(c))).fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Costs from tables, and of a bent spring between two parts.
    struct Table {
        parts: Vec<Vec<f64>>,
        none: f64,
        spring: fn([usize; 2], [usize; 2]) -> f64,
    }

    impl Cost for Table {
        fn place_count(&self) -> usize {
            self.parts[0].len()
        }
        fn part_cost(&self, part: usize, place: Option<usize>) -> f64 {
            place.map_or(self.none, |place| self.parts[part][place])
        }
        fn pair_cost(&self, parts: [usize; 2], places: [usize; 2]) -> f64 {
            (self.spring)(parts, places)
        }
    }

    fn row(count: usize) -> SpanningTree {
        let points: Vec<Point2> = (0..count).map(|k| [10.0 * k as f64, 0.0]).collect();
        SpanningTree::of_least_length(&points)
    }

    fn total(tree: &SpanningTree, cost: &Table, chosen: &[Option<usize>]) -> f64 {
        let parts: f64 = chosen.iter().enumerate().map(|(part, c)| cost.part_cost(part, *c)).sum();
        let placed = tree.joined_pairs().filter_map(|pair| Some((pair, [chosen[pair[0]]?, chosen[pair[1]]?])));
        parts + placed.map(|(parts, places)| cost.pair_cost(parts, places)).sum::<f64>()
    }

    #[test]
    fn a_row_in_any_order_of_clicks_is_joined_from_neighbour_to_neighbour() {
        let tree = SpanningTree::of_least_length(&[[30.0, 0.0], [0.0, 0.0], [20.0, 1.0], [10.0, 0.0]]);
        assert_eq!(tree.joined_pairs().collect::<Vec<_>>(), [[1, 3], [2, 0], [3, 2]]);
        assert_eq!(
            SpanningTree::of_least_length(&[]).cheapest_assignment(&Table {
                parts: vec![vec![]],
                none: 0.0,
                spring: |_, _| 0.0
            }),
            []
        );
    }

    #[test]
    fn parts_that_move_alike_leave_the_places_that_are_nearest_to_each() {
        // place k lies where part k was; all moved on by one, and the last place is new
        let away = |part: usize| (0..4).map(|place| 0.1 * (place as f64 - part as f64).powi(2)).collect();
        let spring = |[a, b]: [usize; 2], [p, q]: [usize; 2]| {
            let stretch = (p as f64 - q as f64) - (a as f64 - b as f64);
            stretch * stretch
        };
        let mut cost = Table { parts: (0..3).map(away).collect(), none: 1.0, spring };
        cost.parts.iter_mut().for_each(|costs| costs[0] = f64::INFINITY);
        assert_eq!(row(3).cheapest_assignment(&cost), [Some(1), Some(2), Some(3)]);
        // where a missing part costs less than the motion of all, the first is missing and the others stay
        assert_eq!(row(3).cheapest_assignment(&Table { none: 0.2, ..cost }), [None, Some(1), Some(2)]);
    }

    #[test]
    fn the_assignment_costs_no_more_than_any_other() {
        let mut seed = 7_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        let spring = |[a, b]: [usize; 2], [p, q]: [usize; 2]| ((7 * a + 5 * b + 3 * p + 11 * q) % 13) as f64 / 9.0;
        for _ in 0..20 {
            let points: Vec<Point2> = (0..4).map(|_| [random(), random()]).collect();
            let parts = (0..4).map(|_| (0..3).map(|_| random()).collect()).collect();
            let (tree, cost) = (SpanningTree::of_least_length(&points), Table { parts, none: 0.9, spring });
            let best = total(&tree, &cost, &tree.cheapest_assignment(&cost));
            let choice = |code: usize, part: u32| Some(code / 4_usize.pow(part) % 4).filter(|c| *c < 3);
            let each = (0..256).map(|code| total(&tree, &cost, &[0, 1, 2, 3].map(|part| choice(code, part))));
            let least = each.fold(f64::INFINITY, f64::min);
            assert!((best - least).abs() < 1e-12, "{best} {least}");
        }
    }
}

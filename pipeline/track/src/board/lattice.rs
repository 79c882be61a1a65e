//! Assembly of corners into a grid: each new neighbour is searched where the last step predicts it.

use si::Point2;
use std::collections::{BTreeMap, VecDeque};

/// Places of a grid by their column and row, both from any number.
// Ordered by place, so that lines are trimmed and shifts are tried in the same order in every run; a hash map would
// choose another among equals.
type Grid = BTreeMap<(i32, i32), Point2>;

/// A neighbour may lie this share of the step away from where it is expected: tilt and distortion change a step by less.
const ASTRAY: f64 = 0.3;
/// A place on a grid: column and row.
pub(super) type Place = (i32, i32);
/// Starts that are tried, strongest corner first.
const STARTS: usize = 40;
/// Of them when the size of a grid is asked for: each grows a whole grid. And corners among which it is: the strongest, as those of a board are.
const SIZED_FROM: usize = 6;
const SIZED_AMONG: usize = 500;
/// The four ways to a neighbour.
const WAYS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The grid of `across` × `down` places among `corners` (strongest first), row by row as [`ordered_points`] says.
///
/// # Errors
/// The number of places in the largest grid, when none has the right size.
pub(super) fn find(corners: &[Point2], across: usize, down: usize) -> Result<Vec<Point2>, usize> {
    let mut largest = 0;
    for start in 0..corners.len().min(STARTS) {
        let Some(steps) = first_steps(corners, start) else { continue };
        let grid = trim_outer_lines(grow_grid(corners, start, steps), across.min(down));
        if let Some(found) = ordered_points(&grid, across, down) {
            return Ok(found);
        }
        largest = largest.max(grid.len());
    }
    Err(largest)
}

/// A grid and its places, row by row as [`ordered_points`] says.
pub(super) struct Complete {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) places: Vec<Point2>,
}

/// The largest complete grid among `corners`, strongest first; none of less than 3 × 2.
pub(super) fn largest_grid(corners: &[Point2]) -> Option<Complete> {
    let corners = &corners[..corners.len().min(SIZED_AMONG)];
    let complete_grid = |(start, steps): (usize, [Point2; 2])| {
        let grid = trim_outer_lines(grow_grid(corners, start, steps), 4);
        let (across, down) = grid_spans(&grid)?;
        let (columns, rows) = (across.len().max(down.len()), across.len().min(down.len()));
        let places = ordered_points(&grid, columns, rows).filter(|_| rows >= 2 && columns >= 3)?;
        Some(Complete { columns, rows, places })
    };
    // a corner on the board's edge has no neighbours to start with
    let starts = (0..corners.len()).filter_map(|start| Some((start, first_steps(corners, start)?)));
    starts.take(SIZED_FROM).filter_map(complete_grid).max_by_key(|grid| grid.places.len())
}

/// The largest grid among `corners`, whatever its outline: columns and rows from any number, the second axis anticlockwise of the first as seen.
pub(super) fn largest_outline(corners: &[Point2]) -> Vec<(Place, Point2)> {
    let corners = &corners[..corners.len().min(SIZED_AMONG)];
    let starts = (0..corners.len()).filter_map(|start| Some((start, anticlockwise_steps(corners, start)?)));
    let grids = starts.take(SIZED_FROM).map(|(start, steps)| grow_grid(corners, start, steps));
    grids.max_by_key(Grid::len).unwrap_or_default().into_iter().collect()
}

/// The places of a grid in the order of `cells` (columns and rows from any number, the second axis anticlockwise of the first as seen),
/// where exactly one quarter turn and shift puts all of them on the grid.
///
/// # Errors
/// The number of places in the largest grid, when none holds the cells.
pub(super) fn find_cells(corners: &[Point2], cells: &[(i32, i32)]) -> Result<Vec<Point2>, usize> {
    let mut largest = 0;
    for start in 0..corners.len().min(STARTS) {
        let Some(steps) = anticlockwise_steps(corners, start) else { continue };
        let grid = grow_grid(corners, start, steps);
        if let Some(places) = match_cells(&grid, cells) {
            return Ok(places);
        }
        largest = largest.max(grid.len());
    }
    Err(largest)
}

/// The grid's places at the cells, turned and shifted; none where none or several of these fit.
fn match_cells(grid: &Grid, cells: &[(i32, i32)]) -> Option<Vec<Point2>> {
    let turns: [fn(Place) -> Place; 4] = [|(u, v)| (u, v), |(u, v)| (-v, u), |(u, v)| (-u, -v), |(u, v)| (v, -u)];
    let mut fits = turns.iter().flat_map(|turn| {
        let turned: Vec<(i32, i32)> = cells.iter().map(|cell| turn(*cell)).collect();
        let points_shifted_to = move |to: &(i32, i32)| {
            let shift = (to.0 - turned[0].0, to.1 - turned[0].1);
            turned.iter().map(|(u, v)| grid.get(&(u + shift.0, v + shift.1)).copied()).collect::<Option<Vec<Point2>>>()
        };
        grid.keys().filter_map(points_shifted_to)
    });
    let first = fits.next()?;
    fits.next().is_none().then_some(first)
}

/// The first steps, the second anticlockwise of the first as seen.
fn anticlockwise_steps(corners: &[Point2], start: usize) -> Option<[Point2; 2]> {
    let [first, second] = first_steps(corners, start)?;
    let is_clockwise = first[0] * second[1] - first[1] * second[0] > 0.0;
    Some(if is_clockwise { [second, first] } else { [first, second] })
}

/// Steps to two neighbours of a corner that stand across each other, each with a neighbour opposite, nearest first.
fn first_steps(corners: &[Point2], start: usize) -> Option<[Point2; 2]> {
    let mut neighbour_steps: Vec<Point2> = corners.iter().map(|c| minus(*c, corners[start])).collect();
    neighbour_steps.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
    let neighbour_steps = &neighbour_steps[1..neighbour_steps.len().min(13)];
    let paired =
        |&&step: &&Point2| neighbour_steps.iter().any(|&other| length(plus(step, other)) < ASTRAY * length(step));
    let first = *neighbour_steps.iter().find(paired)?;
    let is_transverse = |&&step: &&Point2| {
        let sine = (first[0] * step[1] - first[1] * step[0]) / (length(first) * length(step));
        sine.abs() > 0.5 && length(step) < 2.5 * length(first)
    };
    let second = *neighbour_steps.iter().filter(is_transverse).find(paired)?;
    Some([first, second])
}

/// Grows a grid from one corner, ring by ring.
fn grow_grid(corners: &[Point2], start: usize, steps: [Point2; 2]) -> Grid {
    let mut grid = Grid::from([((0, 0), corners[start])]);
    let mut used = vec![false; corners.len()];
    used[start] = true;
    let mut queue = VecDeque::from([(0, 0)]);
    while let Some(cell) = queue.pop_front() {
        for way in WAYS {
            let next = (cell.0 + way.0, cell.1 + way.1);
            if grid.contains_key(&next) {
                continue;
            }
            let step = step_from(&grid, cell, way, steps);
            let expected = plus(grid[&cell], step);
            let distance = |i: usize| length(minus(corners[i], expected));
            let nearest = (0..corners.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            if let Some(i) = nearest.filter(|&i| !used[i] && distance(i) < ASTRAY * length(step)) {
                used[i] = true;
                grid.insert(next, corners[i]);
                queue.push_back(next);
            }
        }
    }
    grid
}

/// The step expected from a cell: the last step on the same line, or of a line beside it, or the first steps.
fn step_from(grid: &Grid, (i, j): (i32, i32), (di, dj): (i32, i32), first: [Point2; 2]) -> Point2 {
    let known_step = |cell: (i32, i32)| Some(minus(*grid.get(&(cell.0 + di, cell.1 + dj))?, *grid.get(&cell)?));
    let previous_step = known_step((i - di, j - dj));
    let lateral_step = || known_step((i + dj, j + di)).or_else(|| known_step((i - dj, j - di)));
    previous_step.or_else(lateral_step).unwrap_or_else(|| {
        let [a, b] = first;
        let (u, v) = (f64::from(di), f64::from(dj));
        [u * a[0] + v * b[0], u * a[1] + v * b[1]]
    })
}

/// The grid without outer lines of strays: corners of the surroundings that happened to lie where a neighbour would.
///
/// A line goes when fewer than half of the places are taken that a line of the board's shorter side, `least`, would have.
fn trim_outer_lines(mut grid: Grid, least: usize) -> Grid {
    loop {
        let Some((columns, rows)) = grid_spans(&grid) else { return grid };
        let outer = [(true, columns.start), (true, columns.end - 1), (false, rows.start), (false, rows.end - 1)];
        let is_on_line = |k: &(i32, i32), (column, number): (bool, i32)| number == if column { k.0 } else { k.1 };
        let few = |line: &(bool, i32)| 2 * grid.keys().filter(|k| is_on_line(k, *line)).count() < least;
        let Some(line) = outer.into_iter().find(few) else { return grid };
        grid.retain(|k, _| !is_on_line(k, line));
    }
}

/// Numbers from first to one past the last.
type Span = std::ops::Range<i32>;

/// The places of a grid row by row, `across` × `down` of them, when it is exactly that large and has no hole.
///
/// Columns and rows are exchanged where needed, so that the first axis is the one of `across`; turning from it to the
/// second is anticlockwise as one sees it (in the picture y runs down). None when the size differs.
fn ordered_points(grid: &Grid, across: usize, down: usize) -> Option<Vec<Point2>> {
    let (columns, rows) = grid_spans(grid)?;
    if grid.len() != across * down {
        return None;
    }
    let swapped = match (columns.len(), rows.len()) {
        size if size == (across, down) => false,
        size if size == (down, across) => true,
        _ => return None,
    };
    let cell = |i: usize, j: usize| {
        let (i, j) = (i as i32, j as i32);
        let key = if swapped { (columns.start + j, rows.start + i) } else { (columns.start + i, rows.start + j) };
        grid.get(&key).copied()
    };
    let (u, v) = (minus(cell(1, 0)?, cell(0, 0)?), minus(cell(0, 1)?, cell(0, 0)?));
    let clockwise = u[0] * v[1] - u[1] * v[0] > 0.0;
    let row = |j: usize| if clockwise { down - 1 - j } else { j };
    (0..down).flat_map(|j| (0..across).map(move |i| (i, j))).map(|(i, j)| cell(i, row(j))).collect()
}

/// Columns and rows that a grid reaches over.
fn grid_spans(grid: &Grid) -> Option<(Span, Span)> {
    let range = |axis: fn(&(i32, i32)) -> i32| Some(grid.keys().map(axis).min()?..grid.keys().map(axis).max()? + 1);
    Some((range(|k| k.0)?, range(|k| k.1)?))
}

fn plus(a: Point2, b: Point2) -> Point2 {
    [a[0] + b[0], a[1] + b[1]]
}

fn minus(a: Point2, b: Point2) -> Point2 {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(a: Point2) -> f64 {
    a[0].hypot(a[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 7 × 4 in perspective, seen from above: columns to the right, rows upwards.
    fn tilted(i: usize, j: usize) -> Point2 {
        let (x, y) = (i as f64, j as f64);
        let w = 1.0 + 0.03 * x - 0.02 * y;
        [100.0 + (40.0 * x + 6.0 * y) / w, 300.0 + (5.0 * x - 38.0 * y) / w]
    }

    #[test]
    fn a_grid_among_strays_is_put_in_order() {
        let mut corners: Vec<Point2> = (0..28).map(|k| tilted((k * 5 % 28) % 7, (k * 5 % 28) / 7)).collect();
        corners.extend([[500.0, 20.0], [130.0, 330.0], [80.0, 100.0]]);
        let found = find(&corners, 7, 4).unwrap();
        let expected: Vec<_> = (0..28).map(|k| tilted(k % 7, k / 7)).collect();
        let turned: Vec<_> = expected.iter().rev().copied().collect();
        assert!(found == expected || found == turned);
    }

    #[test]
    fn cells_are_placed_by_the_one_turn_that_fits_them() {
        // an L of 3 and 2, its first axis to the left in the picture
        let corners: Vec<Point2> = [[100.0, 50.0], [60.0, 50.0], [20.0, 50.0], [100.0, 90.0]].to_vec();
        let cells = [(0, 0), (1, 0), (2, 0), (0, 1)];
        let grid =
            Grid::from([((0, 0), corners[0]), ((0, 1), corners[1]), ((0, 2), corners[2]), ((-1, 0), corners[3])]);
        assert_eq!(match_cells(&grid, &cells), Some(corners));
        // two cells fit in many ways
        assert_eq!(match_cells(&grid, &cells[..2]), None);
    }

    #[test]
    fn strays_where_a_neighbour_would_be_are_trimmed() {
        let mut corners: Vec<Point2> = (0..28).map(|k| tilted(k % 7, k / 7)).collect();
        corners.extend([tilted(7, 2), tilted(8, 2), [57.0, 298.0]]);
        assert!(find(&corners, 7, 4).is_ok());
    }

    #[test]
    fn a_grid_with_a_hole_or_of_another_size_is_refused_with_its_size() {
        let corners: Vec<Point2> = (0..28).map(|k| tilted(k % 7, k / 7)).collect();
        assert_eq!(find(&corners, 6, 4), Err(28));
        let holed: Vec<_> = corners.iter().enumerate().filter(|(k, _)| *k != 9).map(|(_, c)| *c).collect();
        assert_eq!(find(&holed, 7, 4), Err(27));
        let complete = largest_grid(&corners).unwrap();
        assert_eq!((complete.columns, complete.rows, complete.places.len()), (7, 4, 28));
        assert!(largest_grid(&holed).is_none() && largest_grid(&corners[..2]).is_none());
    }
}

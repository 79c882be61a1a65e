//! Dark patches of a picture: connected pixels that are darker than the mean around them.

use crate::Gray;

/// The pixels of a patch, columns and rows.
pub(super) type Patch = Vec<[usize; 2]>;

/// Darker than the mean around it by this many grey levels, a pixel belongs to a patch.
const DARKER: f64 = 15.0;

/// The dark patches in reading order; `half` is half the side of the square around a pixel that the mean is of, px.
pub(super) fn dark_patches(picture: &Gray, half: usize) -> impl Iterator<Item = Patch> + use<> {
    let (mut dark, width) = (dark_pixels(picture, half), picture.width);
    let starts: Vec<usize> = (0..dark.len()).filter(|&i| dark[i]).collect();
    starts.into_iter().map(move |start| take_patch(&mut dark, width, start)).filter(|patch| !patch.is_empty())
}

/// Whether each pixel is darker than the mean around it.
fn dark_pixels(picture: &Gray, half: usize) -> Vec<bool> {
    let (width, height) = (picture.width, picture.height);
    let mut sums = vec![0_u64; (width + 1) * (height + 1)];
    for y in 0..height {
        let mut row = 0;
        for x in 0..width {
            row += u64::from(picture.pixels[y * width + x]);
            sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
        }
    }
    let window = |v: usize, size: usize| (v.saturating_sub(half), (v + half + 1).min(size));
    let is_darker = |i: usize| {
        let ((left, right), (top, bottom)) = (window(i % width, width), window(i / width, height));
        let sum_to = |x: usize, y: usize| sums[y * (width + 1) + x];
        let sum = sum_to(right, bottom) + sum_to(left, top) - sum_to(left, bottom) - sum_to(right, top);
        // The mean around the pixel and not one level for the picture, under which the board's corner in the shade
        // would be dark as a whole.
        f64::from(picture.pixels[i]) < sum as f64 / ((right - left) * (bottom - top)) as f64 - DARKER
    };
    (0..width * height).map(is_darker).collect()
}

/// The dark pixels connected to `start` by their sides, removed from `dark`.
fn take_patch(dark: &mut [bool], width: usize, start: usize) -> Patch {
    // A stack of its own: recursion over a dark background of millions of pixels would exceed the thread's.
    let (mut pixels, mut open) = (Vec::new(), vec![start]);
    while let Some(i) = open.pop() {
        if !std::mem::take(&mut dark[i]) {
            continue;
        }
        let x = i % width;
        pixels.push([x, i / width]);
        open.extend((x > 0).then(|| i - 1));
        open.extend((x + 1 < width).then_some(i + 1));
        open.extend(i.checked_sub(width));
        open.extend(Some(i + width).filter(|below| *below < dark.len()));
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_what_is_connected_by_sides_and_is_taken_once() {
        // X.XX
        // XX..
        // ..XX, whose last row touches the second at a corner alone
        let rows = ["X.XX", "XX..", "..XX"];
        let mut dark: Vec<bool> = rows.iter().flat_map(|row| row.chars().map(|c| c == 'X')).collect();
        let mut first = take_patch(&mut dark, 4, 5);
        first.sort_unstable();
        assert_eq!(first, [[0, 0], [0, 1], [1, 1]]);
        assert!(take_patch(&mut dark, 4, 0).is_empty());
        assert_eq!((take_patch(&mut dark, 4, 2).len(), take_patch(&mut dark, 4, 11).len()), (2, 2));
        assert!(dark.iter().all(|dark| !dark));
    }

    #[test]
    fn a_pixel_is_dark_against_the_mean_of_its_surroundings() {
        // squares of 7 × 7 px around each pixel; at the left edge they have four columns
        let at = |level: f64, x: usize, y: usize| {
            let picture = Gray::from_fn(40, 30, |u, v| if (u, v) == (x, y) { level } else { 100.0 });
            let dark = dark_pixels(&picture, 3);
            assert!(dark.iter().enumerate().all(|(i, dark)| !dark || i == y * 40 + x));
            dark[y * 40 + x]
        };
        // level + 15 < mean of 49 pixels with it, or of 28: darker by 15.3 and by 15.6
        assert!(at(84.0, 20, 15) && !at(85.0, 20, 15));
        assert!(at(84.0, 0, 15) && !at(85.0, 0, 15) && at(80.0, 39, 29));
        let left_half = dark_pixels(&Gray::from_fn(40, 30, |u, _| if u < 20 { 60.0 } else { 100.0 }), 3);
        let row: Vec<usize> = (0..40).filter(|u| left_half[15 * 40 + u]).collect();
        // beside the step, at 19, 4 · 60 + 3 · 100 over 7 is 77.1, at 18 it is 71.4
        assert_eq!(row, [19]);
    }
}

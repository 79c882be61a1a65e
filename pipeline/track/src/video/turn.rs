//! Rotation of a film by quarter turns, for cameras that were held on their side.

use crate::Gray;

/// Clockwise turns of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quarter {
    /// As it is coded.
    #[default]
    None,
    /// A quarter clockwise.
    Right,
    /// Upside down.
    Half,
    /// A quarter anticlockwise.
    Left,
}

impl Quarter {
    /// From the matrix of a track: the first two rows' first two numbers, in any one scale. None when it is no quarter turn.
    pub(crate) fn of_matrix(a: i32, b: i32, c: i32, d: i32) -> Option<Self> {
        match (a.signum(), b.signum(), c.signum(), d.signum()) {
            (1, 0, 0, 1) => Some(Self::None),
            (0, 1, -1, 0) => Some(Self::Right),
            (-1, 0, 0, -1) => Some(Self::Half),
            (0, -1, 1, 0) => Some(Self::Left),
            _ => None,
        }
    }

    /// Width and height of a turned picture.
    pub fn size(self, (width, height): (usize, usize)) -> (usize, usize) {
        match self {
            Self::None | Self::Half => (width, height),
            Self::Right | Self::Left => (height, width),
        }
    }

    /// The turned picture.
    pub(crate) fn turn_picture(self, picture: Gray) -> Gray {
        let (w, h) = (picture.width, picture.height);
        let (width, height) = self.size((w, h));
        let source_pixel = |x: usize, y: usize| match self {
            Self::None => (x, y),
            Self::Right => (y, h - 1 - x),
            Self::Half => (w - 1 - x, h - 1 - y),
            Self::Left => (w - 1 - y, x),
        };
        if self == Self::None {
            return picture;
        }
        let places = (0..width * height).map(|i| source_pixel(i % width, i / width));
        let pixels = places.map(|(x, y)| picture.pixels[y * w + x]).collect();
        Gray { width, height, pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_quarters_are_a_whole_and_a_right_one_brings_the_left_column_up() {
        let picture = Gray::from_fn(5, 3, |x, y| (10 * x + y) as f64);
        let mut turned = picture.clone();
        (0..4).for_each(|_| turned = Quarter::Right.turn_picture(turned.clone()));
        assert_eq!(turned, picture);
        let right = Quarter::Right.turn_picture(picture.clone());
        assert_eq!((right.width, right.height), (3, 5));
        assert_eq!(right.pixel_level(2, 0), picture.pixel_level(0, 0));
        assert_eq!(Quarter::Left.turn_picture(right), picture);
        assert_eq!(Quarter::Half.turn_picture(Quarter::Half.turn_picture(picture.clone())), picture);
    }
}

//! Positions of the markers in the first frame: clicked, or detected in the card's region and named by their order.

use lab::card::{Detector, Order, Search};
use si::Point2;
use track::Gray;
use track::klt;

use super::Card;
use diagnostics::{Diagnostic, Result};

/// Initial positions in the `first` frame of `film`, px, in the order of the card; none when tracks are imported.
///
/// # Errors
/// A [`Diagnostic`] with the region as a picture, when the number of markers found in it differs from the card's.
pub(crate) fn initial_positions(card: &Card, first: &Gray, set: &klt::Settings, film: &str) -> Result<Vec<Point2>> {
    if card.elsewhere.is_some() {
        return Ok(Vec::new());
    }
    let Some(search) = &card.search else {
        return Ok(card.markers.iter().filter_map(|m| m.clicked).collect());
    };
    let find = match search.by {
        Detector::Spots => klt::find_blobs,
        Detector::Corners => klt::find_corners,
    };
    let detected = find(first, search.region, usize::MAX, set);
    if detected.len() == card.markers.len() {
        return Ok(in_card_order(detected, search.order));
    }
    let diagnostic = another_number(card, search, &detected, film);
    let [left, top, right, bottom] = search.region.map(|c| c as usize);
    match first.crop(left, top, right - left, bottom - top).to_png() {
        Ok(png) => Err(diagnostic.showing(png)),
        Err(_) => Err(diagnostic),
    }
}

/// The positions in the card's order; the sort is stable.
fn in_card_order(mut places: Vec<Point2>, order: Order) -> Vec<Point2> {
    let coordinate = |[x, y]: &Point2| match order {
        Order::Rightwards => *x,
        Order::Leftwards => -x,
        Order::Downwards => *y,
        Order::Upwards => -y,
    };
    places.sort_by(|a, b| coordinate(a).total_cmp(&coordinate(b)));
    places
}

fn another_number(card: &Card, search: &Search, detected: &[Point2], film: &str) -> Diagnostic {
    let (frame, names) = (card.first_frame, card.markers.len());
    let pixels: Vec<String> = detected.iter().map(|[x, y]| format!("({x:.0}, {y:.0})")).collect();
    let places = if pixels.is_empty() { String::new() } else { format!(": {}", pixels.join(" ")) };
    Diagnostic::new(
        format!("{film} shows {} markers in frame {frame}{places}; the card has {names}", detected.len()),
        format!("{} were searched in [search] region = {:?} px of the card", search.by.word(), search.region),
        "narrow or widen the region, try by = \"spots\" or \"corners\", or click the markers (clicked = [u, v])",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_is_named_along_the_direction_of_the_card() {
        let places = vec![[3.0, 9.0], [1.0, 8.0], [2.0, 7.0]];
        let first = |order| in_card_order(places.clone(), order)[0];
        assert_eq!(first(Order::Rightwards), [1.0, 8.0]);
        assert_eq!(first(Order::Leftwards), [3.0, 9.0]);
        assert_eq!(first(Order::Downwards), [2.0, 7.0]);
        assert_eq!(first(Order::Upwards), [3.0, 9.0]);
    }
}

//! Where the markers are in the first frame: clicked, or found in the card's region and named by their order.
//!
//! Stands on: track. Never knows: the frames after.

use lab::card::{Order, Search, Sought};
use si::Point2;
use track::Gray;
use track::klt;

use crate::fault::{Fault, Outcome};
use crate::subject::Trial;

/// Where to begin in the `first` frame of `film`, px, in the order of the card; nowhere when the tracks were made elsewhere.
///
/// # Errors
/// A [`Fault`] with the region as a picture, when another number of markers is found in it than stands on the card.
pub fn starts(of: &Trial, first: &Gray, set: &klt::Settings, film: &str) -> Outcome<Vec<Point2>> {
    if of.made_elsewhere().is_some() {
        return Ok(Vec::new());
    }
    let Some(search) = &of.card.search else {
        return Ok(of.card.marker.iter().filter_map(|m| m.clicked).collect());
    };
    let find = match search.by {
        Sought::Spots => klt::find,
        Sought::Corners => klt::corners,
    };
    let found = find(first, search.region, usize::MAX, set);
    if found.len() == of.card.marker.len() {
        return Ok(ordered(found, search.order));
    }
    let fault = another_number(of, search, &found, film);
    let [left, top, right, bottom] = search.region.map(|c| c as usize);
    match first.crop(left, top, right - left, bottom - top).to_png() {
        Ok(png) => Err(fault.showing(png)),
        Err(_) => Err(fault),
    }
}

/// The places as they follow each other on the card; equal ones stay as they came.
fn ordered(mut places: Vec<Point2>, order: Order) -> Vec<Point2> {
    let along = |[x, y]: &Point2| match order {
        Order::Rightwards => *x,
        Order::Leftwards => -x,
        Order::Downwards => *y,
        Order::Upwards => -y,
    };
    places.sort_by(|a, b| along(a).total_cmp(&along(b)));
    places
}

fn another_number(of: &Trial, search: &Search, found: &[Point2], film: &str) -> Fault {
    let (frame, names) = (of.trial.first_frame, of.card.marker.len());
    let at: Vec<String> = found.iter().map(|[x, y]| format!("({x:.0}, {y:.0})")).collect();
    let places = if at.is_empty() { String::new() } else { format!(": {}", at.join(" ")) };
    Fault::new(
        format!("{film} shows {} markers in frame {frame}{places}; the card has {names}", found.len()),
        format!("it was looked for {} in [search] region = {:?} px of the card", search.by.word(), search.region),
        "narrow or widen the region, try by = \"spots\" or \"corners\", or click the markers (clicked = [u, v])",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_found_is_named_along_the_direction_of_the_card() {
        let places = vec![[3.0, 9.0], [1.0, 8.0], [2.0, 7.0]];
        let first = |order| ordered(places.clone(), order)[0];
        assert_eq!(first(Order::Rightwards), [1.0, 8.0]);
        assert_eq!(first(Order::Leftwards), [3.0, 9.0]);
        assert_eq!(first(Order::Downwards), [2.0, 7.0]);
        assert_eq!(first(Order::Upwards), [3.0, 9.0]);
    }
}

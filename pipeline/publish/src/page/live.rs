//! Tails that move on the page: the reduced model of each, stepped by the reader's browser, beside a recorded trial.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use si::{Metre, Pascal, Point2, Second};

/// A tail that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveTail {
    /// Its name.
    pub name: String,
    /// m.
    pub length: Metre,
    /// Highest pressure of the trial, Pa: the end of the slider.
    pub highest: Pascal,
    /// The marker whose path is drawn.
    pub marker: String,
    /// The file of [`twin::file::bytes`].
    pub arrays: Vec<u8>,
    /// Recorded motion to compare with.
    pub trial: LiveTrial,
}

/// A recorded trial.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveTrial {
    /// Of each frame, s.
    pub time: Vec<Second>,
    /// Displacement of the marker, m: frames × 2.
    pub measured: Vec<Point2>,
    /// Measured pressures, Pa: chambers × frames.
    pub pressures: Vec<Vec<Pascal>>,
}

impl LiveTail {
    /// As JSON; micrometres and pascals are whole numbers.
    fn tail_json(&self) -> String {
        let LiveTrial { time, measured, pressures } = &self.trial;
        let start = time.first().copied().unwrap_or_default();
        let rounded = |x: f64| x.round() as i64;
        let value = json!({
            "name": self.name,
            "length": self.length,
            "highest": self.highest,
            "marker": self.marker,
            "arrays": STANDARD.encode(&self.arrays),
            "time": time.iter().map(|t| ((t - start) * 1e5).round() / 1e5).collect::<Vec<f64>>(),
            "measured": measured.iter().map(|at| at.map(|x| rounded(1e6 * x))).collect::<Vec<_>>(),
            "pressures": pressures.iter().map(|chamber_pressures| chamber_pressures.iter().map(|p| rounded(*p)).collect()).collect::<Vec<Vec<i64>>>(),
        });
        value.to_string()
    }
}

/// The section of the page; it says what is missing where there is no tail.
pub(super) fn live_section(tails: &[LiveTail]) -> String {
    let content = match tails.is_empty() {
        true => "<p>No motion was validated yet: <code>study run validate</code>.</p>\n".to_owned(),
        false => format!("{CANVAS}\n{PANEL}"),
    };
    let data: Vec<String> = tails.iter().map(LiveTail::tail_json).collect();
    // `<` is escaped, so that no text can end the script
    let data = format!("[{}]", data.join(",")).replace('<', "\\u003c");
    super::html_section("live", "The reduced tail, live", &content)
        + &format!("<script type=\"application/json\" id=\"tails\">{data}</script>\n")
}

const CANVAS: &str = "<canvas id=\"live-tail\" role=\"img\" aria-label=\"the tail from above as it moves, and the path of its marker beside it\"></canvas>";

const PANEL: &str = "<div class=\"panel\"><select id=\"live-name\" aria-label=\"specimen\"></select><button id=\"live-play\">play</button>\
<label>highest pressure <input type=\"range\" id=\"live-amplitude\" min=\"0\" max=\"1\" step=\"0.01\" value=\"0.8\"> \
<output id=\"live-pressure\" for=\"live-amplitude\"></output></label>\
<label>frequency <input type=\"range\" id=\"live-frequency\" min=\"0.5\" max=\"5\" step=\"0.1\" value=\"2\"> \
<output id=\"live-hertz\" for=\"live-frequency\"></output></label>\
<label><input type=\"checkbox\" id=\"live-recorded\"> pressures of a recorded trial</label><output id=\"live-said\"></output></div>\n\
<p class=\"story\">The identified, hyper-reduced and relaxing tail seen from above, stepped 240 times a second by this browser. Blue: path of the marker \
in the model; orange: its recorded path, under the recorded pressures.</p>\n";

#[cfg(test)]
mod tests {
    use super::*;

    fn tail() -> LiveTail {
        let trial = LiveTrial {
            time: vec![2.0, 2.5],
            measured: vec![[0.0, 1e-3], [-2.5e-4, 2e-3]],
            pressures: vec![vec![0.0, 1e4], vec![5.4, 0.0]],
        };
        let (name, marker) = ("a<b".into(), "m6".into());
        LiveTail { name, length: 0.1, highest: 1e4, marker, arrays: vec![1, 2, 3], trial }
    }

    #[test]
    fn a_tail_reads_back_with_its_trial() {
        let read: serde_json::Value = serde_json::from_str(&tail().tail_json()).unwrap();
        assert_eq!(STANDARD.decode(read["arrays"].as_str().unwrap()).unwrap(), [1, 2, 3]);
        assert_eq!(
            (&read["time"][1], &read["measured"][1][0], &read["pressures"][1][0]),
            (&json!(0.5), &json!(-250), &json!(5))
        );
    }

    #[test]
    fn the_section_has_its_controls_or_says_what_is_missing() {
        let html = live_section(&[tail()]);
        assert!(
            html.contains("live-amplitude")
                && html.contains("aria-label=\"the tail from above")
                && html.contains("a\\u003cb"),
            "{html}"
        );
        assert!(live_section(&[]).contains("study run validate"));
    }
}

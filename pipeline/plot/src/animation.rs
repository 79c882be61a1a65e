//! A figure that moves: frames of one size, of which each is shown for a while, as SVG with declarative animation (SMIL).
//!
//! A frame is a group whose visibility is switched at times, so that any figure can be one; shapes are not interpolated, and nothing runs but the
//! viewer's own clock. A program that shows no animation shows the first frame.

use crate::PlotError;
use crate::figure::{Animation, Figure};
use std::fmt::Write;

impl Animation {
    /// The frames as one SVG text.
    ///
    /// # Errors
    /// As [`Figure::svg`] of a frame.
    pub(crate) fn svg(&self) -> Result<String, PlotError> {
        let frames: Vec<String> = self.frames.iter().map(Figure::svg).collect::<Result<_, _>>()?;
        let (head, _) = frames.first().map_or(("", ""), |first| split_head(first));
        let mut text = head.to_owned();
        for (index, frame) in frames.iter().enumerate() {
            let is_first = self.order.first() == Some(&index);
            let at_first = if is_first { "visible" } else { "hidden" };
            let body = split_head(frame).1.trim_end().trim_end_matches("</svg>");
            // writing into a string cannot fail
            let _ = writeln!(text, "<g visibility=\"{at_first}\">\n{}{body}</g>", self.switching(index));
        }
        Ok(text + "</svg>\n")
    }

    /// The element that shows a frame when it is its turn.
    fn switching(&self, index: usize) -> String {
        let state = |frame: usize| if frame == index { "visible" } else { "hidden" };
        let runs: Vec<&[usize]> = self.order.chunk_by(|a, b| (*a == index) == (*b == index)).collect();
        let begins = runs.iter().scan(0, |begin, run| {
            let time = *begin as f64 / self.order.len() as f64;
            *begin += run.len();
            Some(format!("{time:.4}"))
        });
        let times: Vec<String> = begins.collect();
        let states: Vec<&str> = runs.iter().map(|run| state(run[0])).collect();
        format!(
            "<animate attributeName=\"visibility\" calcMode=\"discrete\" dur=\"{}s\" repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{}\"/>\n",
            self.seconds,
            times.join(";"),
            states.join(";")
        )
    }
}

/// The root element with the ground, and what follows.
fn split_head(svg: &str) -> (&str, &str) {
    let end = svg.match_indices('\n').nth(1).map_or(0, |(place, _)| place + 1);
    svg.split_at(end)
}

#[cfg(test)]
mod tests {
    use crate::{Axes, Axis, Figure, Mark, Panel, palette};

    fn frame(y: f64) -> Figure {
        let axes = Axes::new(Axis::linear("x", "mm").range(0.0, 1.0), Axis::linear("y", "mm").range(0.0, 1.0));
        let line = Mark::line(vec![[0.0, y], [1.0, y]], palette::PRESSURE);
        Figure::new(88.0).row(40.0, [Panel::Axes(axes.with(line))])
    }

    #[test]
    fn each_frame_is_visible_in_its_turns_and_the_first_without_animation() {
        let svg = Figure::animated(vec![frame(0.2), frame(0.8)], vec![0, 1, 1, 0], 2.0).svg().unwrap();
        assert_eq!((svg.matches("<svg").count(), svg.matches("</svg>").count(), svg.matches("<g ").count()), (1, 1, 2));
        assert_eq!((svg.matches("<g visibility=\"visible\"").count(), svg.matches("dur=\"2s\"").count()), (1, 2));
        assert!(svg.contains("keyTimes=\"0.0000;0.2500;0.7500\" values=\"visible;hidden;visible\""), "{svg}");
        assert!(svg.contains("keyTimes=\"0.0000;0.2500;0.7500\" values=\"hidden;visible;hidden\""), "{svg}");
    }
}

//! What is refused of imported tracks.

/// Von Neumann's ratio that is refused, halved: that of a beat of five frames. Of values in random order it is 1.
pub(super) const DISORDER: f64 = 0.75;

/// A track that no marker of a body has.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ImportedError {
    /// A step that is too long.
    #[error(
        "marker `{marker}` moves by {measured:.4} {unit} before frame {frame}\n  why: the limit is {limit:.4} {unit} a frame ({source_of_limit})\n  do:  look at that frame: correct the point, names that were exchanged, or the order of frames, and export again"
    )]
    Step {
        /// Its name.
        marker: String,
        /// The frame of the longer step.
        frame: usize,
        /// Its length a frame.
        measured: f64,
        /// The limit.
        limit: f64,
        /// Their unit.
        unit: &'static str,
        /// Where the limit comes from.
        source_of_limit: &'static str,
    },
    /// A distance that changes too much.
    #[error(
        "the distance of markers `{marker}` and `{other}` changes by {measured:.2} of it before frame {frame}\n  why: the limit is {limit:.2} ({source_of_limit}); they sit on one body\n  do:  look at that frame: correct the point, or names that were exchanged, and export again"
    )]
    NeighbourDistance {
        /// Its name.
        marker: String,
        /// The name of its neighbour.
        other: String,
        /// The frame after the change.
        frame: usize,
        /// The change, as a share.
        measured: f64,
        /// The limit.
        limit: f64,
        /// Where the limit comes from.
        source_of_limit: &'static str,
    },
    /// Frames whose order is none of a motion.
    #[error(
        "the frames do not follow each other: markers lie {spread:.4} {unit} from their means, and move by {step:.4} {unit} from one frame to the next\n  why: the mean square of half a step is {ratio:.2} of that of the spread; the limit is {DISORDER}, that of a beat of five frames, and shuffled frames have 1\n  do:  export the frames in the order of the film"
    )]
    Order {
        /// Root of the mean squared distance from the mean.
        spread: f64,
        /// Root of the mean squared step.
        step: f64,
        /// Their unit.
        unit: &'static str,
        /// Von Neumann's ratio, half of it.
        ratio: f64,
    },
    /// A place that is repeated while the others move.
    #[error(
        "marker `{marker}` stands at the very same place in {frames} frames from frame {frame} on\n  why: `{other}` moves by {motion:.4} {unit} meanwhile; a program that has lost a marker repeats its last place\n  do:  leave the place empty in frames in which the marker is not seen, or track it again"
    )]
    Frozen {
        /// Its name.
        marker: String,
        /// The first of the frames.
        frame: usize,
        /// How many they are.
        frames: usize,
        /// The name of the marker that moves most.
        other: String,
        /// How far it moves.
        motion: f64,
        /// The unit.
        unit: &'static str,
    },
    /// A marker that is lost for too long, or at an end.
    #[error(
        "marker `{marker}` has no place in {frames} frames from frame {frame} on\n  why: up to {limit} frames are filled, between frames in which it is seen\n  do:  export a position of every marker on the card in the first and last frame and all but short gaps, or let the film be tracked here"
    )]
    Gap {
        /// Its name.
        marker: String,
        /// The first frame without it.
        frame: usize,
        /// How many they are.
        frames: usize,
        /// The limit.
        limit: usize,
    },
}

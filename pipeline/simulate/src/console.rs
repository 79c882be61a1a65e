//! The progress output of a simulation.
//!
//! A level of a body that balloons or snaps takes many short load steps and may last for minutes. The solver asks in every iteration whether
//! to end; there it is said that the solve goes on, where nothing else was for a while.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use diagnostics::output;
use fem::Interrupt;

use crate::Summary;

/// After so long without a line, one says that the solve goes on.
const SILENCE: Duration = Duration::from_secs(15);

/// Where the lines of a case go.
pub(crate) struct Console {
    stem: String,
    quiet: bool,
    began: Instant,
    /// Time of the last line, ms from the beginning.
    last: AtomicU64,
}

impl Console {
    /// The console of the case `stem`; a quiet one prints the last line alone.
    pub fn new(stem: &str, quiet: bool) -> Self {
        Self { stem: stem.to_owned(), quiet, began: Instant::now(), last: AtomicU64::new(0) }
    }

    /// The name of the case.
    pub fn stem(&self) -> &str {
        &self.stem
    }

    /// Prints one line.
    pub fn print_line(&self, text: &str) {
        self.last.store(self.elapsed_ms(), Ordering::Relaxed);
        if !self.quiet {
            output::note(format_args!("{:<10} {text}", self.stem));
        }
    }

    /// Prints what was solved.
    pub(crate) fn print_summary(&self, summary: &Summary) {
        let Summary { dofs, solved, folder, .. } = summary;
        let iterations = summary.iterations.map_or(String::new(), |count| format!("{count} iterations, "));
        let (seconds, folder) = (self.began.elapsed().as_secs_f64(), folder.display());
        output::note(format_args!(
            "{:<10} {solved} solved, {dofs} dofs, {iterations}{seconds:.1} s → {folder}",
            self.stem
        ));
    }

    /// The same interrupt, which also reports a solve that goes on in silence.
    pub(crate) fn reporting(self: &Arc<Self>, interrupt: Option<Interrupt>) -> Interrupt {
        let console = self.clone();
        Arc::new(move || {
            console.report_if_silent(SILENCE);
            interrupt.as_ref().is_some_and(|asked| asked())
        })
    }

    /// Prints that the solve goes on, unless a line was printed within `silence`; whether it did.
    fn report_if_silent(&self, silence: Duration) -> bool {
        let (now, last) = (self.elapsed_ms(), self.last.load(Ordering::Relaxed));
        let due = u128::from(now.saturating_sub(last)) >= silence.as_millis();
        // of several threads that ask at once, one reports
        let first = due && self.last.compare_exchange(last, now, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if first {
            self.print_line(&format!("still solving, {} s after the start", now / 1000));
        }
        first
    }

    fn elapsed_ms(&self) -> u64 {
        u64::try_from(self.began.elapsed().as_millis()).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solve_reports_once_after_a_silence_and_not_while_lines_are_printed() {
        let console = Console::new("finger", true);
        console.print_line("level 1");
        assert!(!console.report_if_silent(Duration::from_secs(3600)));
        let silence = Duration::from_millis(30);
        std::thread::sleep(2 * silence);
        assert!(console.report_if_silent(silence) && !console.report_if_silent(silence));
    }

    #[test]
    fn the_interrupt_behind_it_is_still_asked() {
        let console = Arc::new(Console::new("finger", true));
        assert!(console.reporting(Some(Arc::new(|| true)))() && !console.reporting(None)());
    }
}

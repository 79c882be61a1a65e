//! One lane for the flow of small crops: kornia gives every row of a pyramid to whichever core is free, and for crops of 69 px
//! handing out costs more than the rows.
//!
//! Stands on: rayon. Never knows: a picture.

use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of one thread.
pub(super) struct Lane(Option<ThreadPool>);

impl Lane {
    /// A lane of its own; where the system gives no thread, work is spread as it would be without.
    pub(super) fn new() -> Self {
        Self(ThreadPoolBuilder::new().num_threads(1).build().ok())
    }

    /// What `work` gives, made on this lane alone.
    pub(super) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_would_spread_stays_on_one_thread() {
        assert_eq!(Lane::new().run(rayon::current_num_threads), 1);
    }
}

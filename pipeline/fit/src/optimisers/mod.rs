//! The family of optimisers: one file each, and the list that settings and tests find them by.
//!
//! Stands on: the contract in `optimiser.rs` and its members. Never knows: a problem.
//! A new optimiser: its file, its settings in [`Settings`], its line in [`ALL`]; the suite finds it there.

pub mod adam;
pub mod cma_es;
pub mod gauss_newton;
pub mod grid;

use crate::{FitError, Optimiser, Search};

/// The settings of every member; each reads its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// For `grid`.
    pub grid: grid::Settings,
    /// For `cma_es`.
    pub cma_es: cma_es::Settings,
    /// For `adam`.
    pub adam: adam::Settings,
    /// For `gauss_newton`.
    pub gauss_newton: gauss_newton::Settings,
}

/// Builds a member for a search.
pub type Build = fn(&Search, &Settings) -> Result<Box<dyn Optimiser>, FitError>;

/// One member of the family.
pub struct Member {
    /// Its name in settings, metrics and figures.
    pub name: &'static str,
    /// Builds it for a search.
    pub build: Build,
}

/// Every optimiser, from the one that knows least about the loss to the one that knows most.
pub const ALL: &[Member] = &[
    Member { name: grid::NAME, build: |search, set| Ok(Box::new(grid::Grid::new(search, &set.grid)?)) },
    Member { name: cma_es::NAME, build: |search, set| Ok(Box::new(cma_es::CmaEs::new(search, &set.cma_es)?)) },
    Member { name: adam::NAME, build: |search, set| Ok(Box::new(adam::Adam::new(search, &set.adam)?)) },
    Member {
        name: gauss_newton::NAME,
        build: |search, set| Ok(Box::new(gauss_newton::GaussNewton::new(search, &set.gauss_newton)?)),
    },
];

/// The member of this name.
pub fn by_name(name: &str) -> Option<&'static Member> {
    ALL.iter().find(|member| member.name == name)
}

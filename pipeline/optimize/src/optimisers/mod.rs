//! The family of optimisers: one file each, and the list [`ALL`] by which settings and tests find them.
//!
//! A new optimiser needs its file, its settings in [`Settings`] and its line in [`ALL`]; the test suite walks the list.

pub mod adam;
pub mod cma_es;
pub mod gauss_newton;
pub mod grid;

use crate::{OptimiseError, Optimiser, Problem};

/// The settings of every member; each reads its own. Others begin with the defaults, so that a new member changes none of them.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
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

/// Builds an optimiser for a problem.
pub type Build = fn(&Problem, &Settings) -> Result<Box<dyn Optimiser>, OptimiseError>;

/// One member of the family.
pub struct Member {
    /// Its name in settings and metrics.
    pub name: &'static str,
    /// Its name in figures and tables, as within a sentence.
    pub title: &'static str,
    /// Builds it for a problem.
    pub build: Build,
}

/// Every optimiser, from the one that needs least of an evaluation to the one that needs most.
pub const ALL: &[Member] = &[
    Member {
        name: grid::NAME,
        title: "grid search",
        build: |problem, set| Ok(Box::new(grid::Grid::new(problem, &set.grid)?)),
    },
    Member {
        name: cma_es::NAME,
        title: "CMA-ES",
        build: |problem, set| Ok(Box::new(cma_es::CmaEs::new(problem, &set.cma_es)?)),
    },
    Member {
        name: adam::NAME,
        title: "Adam",
        build: |problem, set| Ok(Box::new(adam::Adam::new(problem, &set.adam)?)),
    },
    Member {
        name: gauss_newton::NAME,
        title: "Gauss-Newton",
        build: |problem, set| Ok(Box::new(gauss_newton::GaussNewton::new(problem, &set.gauss_newton)?)),
    },
];

/// The member of this name.
pub fn by_name(name: &str) -> Option<&'static Member> {
    ALL.iter().find(|member| member.name == name)
}

/// How the member of this name is called in figures and tables; an unknown one by that name.
pub fn title_of(name: &str) -> &str {
    by_name(name).map_or(name, |member| member.title)
}

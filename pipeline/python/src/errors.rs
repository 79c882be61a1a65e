//! Errors as exceptions of the package, with what, why and what to do.

use diagnostics::Diagnostic;
use pyo3::prelude::*;

/// A class of exceptions in `softfish._errors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Input,
    Mesh,
    Case,
    Convergence,
    NotStable,
    Busy,
    Budget,
    Internal,
}

impl Kind {
    fn class_name(self) -> &'static str {
        match self {
            Self::Input => "InputError",
            Self::Mesh => "MeshError",
            Self::Case => "CaseError",
            Self::Convergence => "ConvergenceError",
            Self::NotStable => "NotStableError",
            Self::Busy => "BusyError",
            Self::Budget => "BudgetError",
            Self::Internal => "InternalError",
        }
    }
}

/// The exception of a class.
pub(crate) fn typed_exception(kind: Kind, parts: [&str; 3]) -> PyErr {
    let [what, why, act] = parts;
    let raised_error = Python::attach(|py| {
        let class = py.import("softfish._errors")?.getattr(kind.class_name())?;
        class.call1((what, why, act)).map(PyErr::from_value)
    });
    raised_error.unwrap_or_else(|error| error)
}

/// A refused argument.
pub(crate) fn input_error(what: impl AsRef<str>, why: impl AsRef<str>, act: impl AsRef<str>) -> PyErr {
    typed_exception(Kind::Input, [what.as_ref(), why.as_ref(), act.as_ref()])
}

/// The exception of an error of a solve or of a setup.
pub(crate) fn solve_exception(error: impl std::error::Error + Send + Sync + 'static) -> PyErr {
    of_diagnostic(&Diagnostic::from(error), Kind::Input)
}

/// The exception of a diagnostic; `other` is its class where its source does not decide it.
pub(crate) fn of_diagnostic(diagnostic: &Diagnostic, other: Kind) -> PyErr {
    let ended = diagnostic.downcast_ref::<simulate::Exceeded>().is_some();
    let kind = match diagnostic.downcast_ref::<fem::SolveError>() {
        _ if ended => Kind::Budget,
        Some(fem::SolveError::NoEquilibrium { .. } | fem::SolveError::TimeStep { .. }) => Kind::Convergence,
        Some(fem::SolveError::NotStable) => Kind::NotStable,
        Some(_) => Kind::Input,
        None if matches!(diagnostic.downcast_ref(), Some(fem::ReducedError::NoConvergence { .. })) => Kind::Convergence,
        None => other,
    };
    let prefix = diagnostic.location.as_ref().map(|prefix| format!("{prefix}: ")).unwrap_or_default();
    let message = format!("{prefix}{}", diagnostic.what);
    typed_exception(kind, [&message, &diagnostic.why, &diagnostic.action])
}

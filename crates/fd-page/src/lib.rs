//! A gap study as a page and tables, for the command line and for Python.
//!
//! [`page()`] and [`tables()`] present a [`GapStudy`]. Numbers, probabilities and verdicts come from its typed
//! report; only words, units and pictures are made here. [`json`] returns the contents of `report.json`.
//!
//! ```no_run
//! use fdiag::gap_study::{GapStudy, Request};
//!
//! let study = GapStudy::run(&Request::new("cart.toml", ["monday.csv"]), &())?;
//! std::fs::write("report.html", fd_page::page(&study)?.to_html())?;
//! std::fs::write("report.json", fd_page::json(&study.report)?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod page;
mod pictures;
mod tables;

use fd_report::{Picture, PictureError};
use fdiag::gap_study::{GapStudy, Report, Trace};

pub use self::{page::page, tables::tables};

/// The text of `report.json`.
///
/// # Errors
///
/// Returns an error when a part of the report cannot be written as JSON; there is none such.
pub fn json(report: &Report) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(report)
}

/// Measured and simulated, before and after, with captions: each output as a whole and where the two differ most.
#[must_use]
pub fn run_pictures(trace: &Trace) -> Vec<(Picture, String)> {
    pictures::runs(trace)
}

/// The most telling picture of a study as SVG of this size: the first output, measured and simulated before and after;
/// `None` where there is nothing to draw.
///
/// # Errors
///
/// Returns an error when it cannot be drawn.
pub fn first_picture(
    study: &GapStudy,
    [width, height]: [u32; 2],
) -> Result<Option<String>, PictureError> {
    let runs = study.trace.as_ref().map(pictures::runs);
    let first = runs.and_then(|runs| runs.into_iter().next());
    first.map(|(picture, _)| picture.to_svg(width, height)).transpose()
}

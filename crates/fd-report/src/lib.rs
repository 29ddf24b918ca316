//! Reports: pictures as SVG, tables as text, and pages as self-contained HTML.
//!
//! This crate depends on no other crate of the workspace: it takes words and numbers, and their meaning is up
//! to the caller.
//!
//! ```
//! use fd_report::{Page, Table};
//!
//! let mut found = Table::new("Faults", &["sensor", "size"]);
//! found.push(["T_7", "0.5 %"]);
//!
//! // The same table for a terminal, for a text file, and on a page that needs nothing beside it.
//! assert!(found.to_text(80).contains("0.5 %"));
//! assert!(found.to_markdown().ends_with("| T_7 | 0.5 % |\n"));
//! let mut page = Page::new("Run 7", "One sensor reads too high.");
//! page.heading("What was found");
//! page.table(found);
//! let html = page.to_html();
//! assert!(html.contains("One sensor reads too high.") && html.contains("T_7"));
//! ```

mod bars;
mod corner;
mod decimate;
mod inline;
mod lively;
mod matrix;
mod page;
mod picture;
mod table;

pub use self::{
    bars::{Bar, Bars, Shares},
    decimate::decimate,
    matrix::{Frame, Mark, Matrix},
    page::Page,
    picture::{Line, Picture, PictureError},
    table::{Table, markdown_text},
};

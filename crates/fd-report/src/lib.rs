//! Reports: pictures as SVG, tables as text, and pages as self-contained HTML.

mod bars;
mod corner;
mod decimate;
mod page;
mod picture;
mod table;

pub use self::{
    bars::{Bar, Bars, Shares},
    decimate::decimate,
    page::Page,
    picture::{Line, Picture, PictureError},
    table::Table,
};

//! Reports: pictures as SVG, tables as text, and pages as self-contained HTML.

mod decimate;
mod page;
mod picture;
mod table;

pub use self::{
    decimate::decimate,
    page::Page,
    picture::{Line, Picture, PictureError},
    table::Table,
};

//! Matrices of marks as SVG: which row has something to do with which column.

use std::ops::Range;

use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::picture::{COLOURS, PictureError};

/// Side of a cell, in pixels.
const CELL: i32 = 20;
/// Width of a letter of a label, in pixels, about.
const LETTER: i32 = 8;
/// Height of the title.
const TITLE: i32 = 34;

/// A matrix of marks with named rows and columns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Matrix {
    /// What it shows, in words.
    pub title: String,
    /// Names of the rows, from above.
    pub rows: Vec<String>,
    /// Names of the columns, from the left.
    pub columns: Vec<String>,
    /// What is in it.
    pub marks: Vec<Mark>,
    /// Frames around rows and columns that belong together.
    pub frames: Vec<Frame>,
}

/// A coloured cell of a [`Matrix`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mark {
    /// Its row.
    pub row: usize,
    /// Its column.
    pub column: usize,
    /// A letter, or nothing.
    pub text: String,
    /// Number of the colour; they repeat.
    pub colour: usize,
}

/// A frame around a part of a [`Matrix`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Its rows.
    pub rows: Range<usize>,
    /// Its columns.
    pub columns: Range<usize>,
    /// Number of the colour of what is inside.
    pub colour: usize,
}

impl Matrix {
    /// Draws the matrix as a complete SVG document, as large as its names need.
    ///
    /// ```
    /// use fd_report::{Mark, Matrix};
    ///
    /// let matrix = Matrix {
    ///     title: "Faults".to_owned(),
    ///     rows: vec!["leak".to_owned()],
    ///     columns: vec!["test 1".to_owned()],
    ///     marks: vec![Mark { text: "x".to_owned(), ..Mark::default() }],
    ///     frames: Vec::new(),
    /// };
    /// assert!(matrix.to_svg()?.contains("leak"));
    /// # Ok::<(), fd_report::PictureError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the drawing library fails.
    pub fn to_svg(&self) -> Result<String, PictureError> {
        let label = |names: &[String]| {
            let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
            LETTER * pixels(longest) + 12
        };
        let corner = (label(&self.rows), label(&self.columns) + TITLE);
        let title = LETTER * pixels(self.title.chars().count()) + 24;
        let width = (corner.0 + CELL * pixels(self.columns.len()) + 12).max(title);
        let height = corner.1 + CELL * pixels(self.rows.len()) + 12;
        let mut svg = String::new();
        {
            let size = (width.unsigned_abs(), height.unsigned_abs());
            let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            self.draw(&area, corner)
                .map_err(|reason| PictureError { title: self.title.clone(), reason })?;
        }
        Ok(svg)
    }

    fn draw(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        corner: (i32, i32),
    ) -> Result<(), String> {
        let at = |row: usize, column: usize| {
            (corner.0 + CELL * pixels(column), corner.1 + CELL * pixels(row))
        };
        let end = at(self.rows.len(), self.columns.len());
        let font = |size: u32| ("sans-serif", size).into_font().color(&BLACK);
        let anchored = |h, v| font(13).pos(Pos::new(h, v));
        let failed = |e: DrawingAreaErrorKind<_>| e.to_string();

        area.fill(&WHITE).map_err(failed)?;
        let title = Text::new(self.title.clone(), (8, 8), font(16));
        area.draw(&title).map_err(failed)?;
        for frame in &self.frames {
            let cells =
                [at(frame.rows.start, frame.columns.start), at(frame.rows.end, frame.columns.end)];
            let colour = colour(frame.colour);
            area.draw(&Rectangle::new(cells, colour.mix(0.15).filled())).map_err(failed)?;
        }
        let grey = BLACK.mix(0.12);
        for row in 0..=self.rows.len() {
            let line = vec![at(row, 0), (end.0, at(row, 0).1)];
            area.draw(&PathElement::new(line, grey)).map_err(failed)?;
        }
        for column in 0..=self.columns.len() {
            let line = vec![at(0, column), (at(0, column).0, end.1)];
            area.draw(&PathElement::new(line, grey)).map_err(failed)?;
        }
        for (row, name) in self.rows.iter().enumerate() {
            let (x, y) = at(row, 0);
            let style = anchored(HPos::Right, VPos::Center);
            area.draw(&Text::new(name.clone(), (x - 6, y + CELL / 2), style)).map_err(failed)?;
        }
        for (column, name) in self.columns.iter().enumerate() {
            let (x, y) = at(0, column);
            let upright = ("sans-serif", 13).into_font().transform(FontTransform::Rotate270);
            let style = upright.color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(name.clone(), (x + CELL / 2, y - 6), style)).map_err(failed)?;
        }
        for mark in &self.marks {
            let (x, y) = at(mark.row, mark.column);
            let cell = [(x + 2, y + 2), (x + CELL - 2, y + CELL - 2)];
            let fill = colour(mark.colour).mix(if mark.text.is_empty() { 0.9 } else { 0.45 });
            area.draw(&Rectangle::new(cell, fill.filled())).map_err(failed)?;
            let style = anchored(HPos::Center, VPos::Center);
            let middle = (x + CELL / 2, y + CELL / 2);
            area.draw(&Text::new(mark.text.clone(), middle, style)).map_err(failed)?;
        }
        for frame in &self.frames {
            let cells =
                [at(frame.rows.start, frame.columns.start), at(frame.rows.end, frame.columns.end)];
            let line = colour(frame.colour).stroke_width(2);
            area.draw(&Rectangle::new(cells, line)).map_err(failed)?;
        }
        area.present().map_err(failed)
    }
}

fn colour(number: usize) -> RGBColor {
    COLOURS[number % COLOURS.len()]
}

/// A count as pixels; more than a drawing can have are cut off.
fn pixels(count: usize) -> i32 {
    i32::try_from(count.min(10_000)).unwrap_or(10_000)
}

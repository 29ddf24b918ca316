//! Line pictures as SVG: one description, drawn the same into a file and into the report.

use plotters::{
    coord::{Shift, ranged1d::AsRangedCoord, ranged1d::ValueFormatter},
    prelude::*,
};
use thiserror::Error;

use super::{corner::emptiest, decimate::decimate};

/// Most points drawn per line; more would only make the file large.
pub(super) const MAX_POINTS: usize = 2_000;

/// Pixels drawn per pixel asked for: the drawing library rounds to whole pixels, which shows as
/// stairs on smooth lines otherwise.
const FINENESS: u32 = 4;

/// [`FINENESS`] for signed offsets.
const PIXEL: i32 = FINENESS.cast_signed();

/// Line colours that stay apart for the colour-blind (Okabe & Ito 2008).
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// A picture with lines over a common horizontal axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// What the picture shows, in words.
    pub title: String,
    /// Horizontal axis with unit.
    pub x_label: String,
    /// Vertical axis with unit.
    pub y_label: String,
    /// Whether the horizontal axis is logarithmic.
    pub log_x: bool,
    /// Whether the vertical axis is logarithmic.
    pub log_y: bool,
    /// The lines, in order of drawing.
    pub lines: Vec<Line>,
    /// Horizontal reference lines such as thresholds, with a label.
    pub levels: Vec<(f64, String)>,
    /// Vertical reference lines such as the start of a fault, with a label.
    pub marks: Vec<(f64, String)>,
}

/// A line of a [`Picture`]. Non-finite points break the line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name for the legend; empty for none.
    pub name: String,
    /// Points `(x, y)`.
    pub points: Vec<(f64, f64)>,
    /// Whether only the points are drawn.
    pub dots: bool,
}

impl Line {
    /// A connected line.
    ///
    /// ```
    /// # use fd_report::Line;
    /// assert_eq!(Line::new("r", [(0.0, 1.0)]).points.len(), 1);
    /// ```
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.into(), points: points.into_iter().collect(), dots: false }
    }
}

/// Where the axes of a drawing are, and what they show.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    /// Left, top, right and bottom, in units of the drawing.
    pub frame: [i32; 4],
    pub x: (f64, f64),
    pub y: (f64, f64),
}

/// A picture cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("picture `{title}` cannot be drawn: {reason}")]
pub struct PictureError {
    /// Title of the picture.
    pub title: String,
    /// What the drawing library said.
    pub reason: String,
}

impl Picture {
    /// Draws the picture as a complete SVG document of the given size in pixels.
    ///
    /// # Errors
    ///
    /// Returns an error when the drawing library fails.
    pub fn to_svg(&self, width: u32, height: u32) -> Result<String, PictureError> {
        Ok(self.drawn(width, height)?.0)
    }

    /// The drawing, and where its axes are.
    pub(super) fn drawn(&self, width: u32, height: u32) -> Result<(String, Axes), PictureError> {
        let mut svg = String::new();
        let axes = {
            let size = (width * FINENESS, height * FINENESS);
            let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            self.draw(&area).map_err(|reason| PictureError { title: self.title.clone(), reason })?
        };
        // A drawing scales with the page instead of having a size of its own.
        let size = format!("width=\"{}\" height=\"{}\" ", width * FINENESS, height * FINENESS);
        Ok((svg.replacen(&size, "", 1), axes))
    }

    /// Names and CSS colours of the lines that have a name, in order.
    #[must_use]
    pub(super) fn legend(&self) -> Vec<(String, String)> {
        let named = self.lines.iter().enumerate().filter(|(_, line)| !line.name.is_empty());
        named.map(|(i, line)| (line.name.clone(), css_colour(i))).collect()
    }

    /// The same picture, of which the legend stands elsewhere.
    #[must_use]
    pub(super) fn without_legend(&self) -> Self {
        let mut picture = self.clone();
        picture.lines.iter_mut().for_each(|line| line.name.clear());
        picture
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<Axes, String> {
        let (x, y) = (self.range(self.log_x, |p| p.0), self.range(self.log_y, |p| p.1));
        let (lx, ly) = ((x.0..x.1).log_scale(), (y.0..y.1).log_scale());
        match (self.log_x, self.log_y) {
            (false, false) => self.draw_on(area, x.0..x.1, y.0..y.1, x, y),
            (true, false) => self.draw_on(area, lx, y.0..y.1, x, y),
            (false, true) => self.draw_on(area, x.0..x.1, ly, x, y),
            (true, true) => self.draw_on(area, lx, ly, x, y),
        }
    }

    fn draw_on<X, Y>(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        x: X,
        y: Y,
        x_range: (f64, f64),
        y_range: (f64, f64),
    ) -> Result<Axes, String>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        area.fill(&WHITE).map_err(|e| e.to_string())?;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 17 * FINENESS))
            .margin(8 * FINENESS)
            .margin_right(16 * FINENESS)
            .x_label_area_size(38 * FINENESS)
            .y_label_area_size(66 * FINENESS)
            .build_cartesian_2d(x, y)
            .map_err(|e| e.to_string())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12).stroke_width(FINENESS))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(8)
            .y_labels(7)
            .x_label_formatter(&|v| tick(*v, x_range))
            .y_label_formatter(&|v| tick(*v, y_range))
            .axis_style(BLACK.mix(0.6).stroke_width(FINENESS))
            .set_all_tick_mark_size(5 * FINENESS)
            .label_style(("sans-serif", 13 * FINENESS))
            .draw()
            .map_err(|e| e.to_string())?;
        let dashed = |points: Vec<(f64, f64)>, colour: RGBColor| {
            DashedLineSeries::new(points, 6 * FINENESS, 4 * FINENESS, colour.stroke_width(FINENESS))
        };
        for (level, label) in self.levels.iter().filter(|(v, _)| within(*v, y_range)) {
            let grey = RGBColor(90, 90, 90);
            chart
                .draw_series(dashed(vec![(x_range.0, *level), (x_range.1, *level)], grey))
                .map_err(|e| e.to_string())?;
            let at = (x_range.0, *level);
            let style = ("sans-serif", 12 * FINENESS).into_font().color(&grey);
            let text =
                EmptyElement::at(at) + Text::new(label.clone(), (6 * PIXEL, -14 * PIXEL), style);
            chart.draw_series(std::iter::once(text)).map_err(|e| e.to_string())?;
        }
        for (mark, label) in self.marks.iter().filter(|(v, _)| within(*v, x_range)) {
            let red = RGBColor(160, 0, 0);
            chart
                .draw_series(dashed(vec![(*mark, y_range.0), (*mark, y_range.1)], red))
                .map_err(|e| e.to_string())?;
            let style = ("sans-serif", 12 * FINENESS).into_font().color(&red);
            let text = EmptyElement::at((*mark, y_range.1))
                + Text::new(label.clone(), (4 * PIXEL, 4 * PIXEL), style);
            chart.draw_series(std::iter::once(text)).map_err(|e| e.to_string())?;
        }
        for (line, colour) in self.lines.iter().zip(COLOURS.iter().cycle()) {
            let mut label = line.name.as_str();
            for run in self.runs(&line.points) {
                let points = decimate(run, MAX_POINTS);
                let style = colour.stroke_width(2 * FINENESS);
                let drawn = if line.dots {
                    chart.draw_series(
                        points.iter().map(|p| Circle::new(*p, 3 * FINENESS, style.filled())),
                    )
                } else {
                    chart.draw_series(LineSeries::new(points, style))
                };
                let drawn = drawn.map_err(|e| e.to_string())?;
                if !label.is_empty() {
                    let swatch = move |(x, y)| {
                        Rectangle::new(
                            [(x, y - 2 * PIXEL), (x + 16 * PIXEL, y + 2 * PIXEL)],
                            colour.filled(),
                        )
                    };
                    drawn.label(std::mem::take(&mut label)).legend(swatch);
                }
            }
        }
        if self.lines.iter().any(|line| !line.name.is_empty()) {
            let across = |v: f64| place(v, x_range, self.log_x);
            let up = |v: f64| place(v, y_range, self.log_y);
            let corner = emptiest(
                self.lines.iter().flat_map(|line| &line.points).map(|p| (across(p.0), up(p.1))),
                self.marks.iter().map(|mark| across(mark.0)),
                self.levels.iter().map(|level| up(level.0)),
            );
            chart
                .configure_series_labels()
                .position(corner)
                .legend_area_size(22 * FINENESS)
                .margin(6 * FINENESS)
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.2))
                .label_font(("sans-serif", 13 * FINENESS))
                .draw()
                .map_err(|e| e.to_string())?;
        }
        let (across, down) = chart.plotting_area().get_pixel_range();
        Ok(Axes { frame: [across.start, down.start, across.end, down.end], x: x_range, y: y_range })
    }

    /// Unbroken stretches of drawable points.
    pub(super) fn runs<'a>(
        &self,
        points: &'a [(f64, f64)],
    ) -> impl Iterator<Item = &'a [(f64, f64)]> + use<'a> {
        let (log_x, log_y) = (self.log_x, self.log_y);
        let drawable = |v: f64, log: bool| v.is_finite() && (!log || v > 0.0);
        points
            .split(move |p| !drawable(p.0, log_x) || !drawable(p.1, log_y))
            .filter(|run| !run.is_empty())
    }

    /// Range of one axis over all lines and, vertically, levels; never empty.
    fn range(&self, log: bool, coordinate: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let points = self.lines.iter().flat_map(|line| &line.points);
        let values = points
            .filter(|p| p.0.is_finite() && p.1.is_finite())
            .map(&coordinate)
            .filter(|v| !log || *v > 0.0);
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        // Levels belong to the vertical axis: a probe tells which coordinate is asked for.
        let vertical = coordinate(&(0.0, 1.0)) > 0.5;
        let levels = self.levels.iter().map(|level| level.0).filter(|v| v.is_finite());
        let (low, high) = if vertical {
            levels.filter(|v| !log || *v > 0.0).fold((low, high), |(l, h), v| (l.min(v), h.max(v)))
        } else {
            (low, high)
        };
        if low > high {
            return if log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        if log {
            return (low * 0.9, high * 1.1);
        }
        let pad = if vertical { 0.05 * (high - low) } else { 0.0 };
        let pad = if high - low > 0.0 { pad } else { 0.5 * high.abs().max(1e-12) };
        (low - pad, high + pad)
    }
}

/// The colour of a line by its number, in the style of a page.
pub(super) fn css_colour(line: usize) -> String {
    format!("var(--line-{})", line % COLOURS.len() + 1)
}

/// Where a value lies within a range, from 0 to 1.
fn place(value: f64, (low, high): (f64, f64), log: bool) -> f64 {
    if log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
}

fn within(value: f64, range: (f64, f64)) -> bool {
    range.0 <= value && value <= range.1
}

/// A short label for a tick of an axis with this range.
fn tick(value: f64, (low, high): (f64, f64)) -> String {
    // Ticks are multiples of a step, so that zero may come out as a rounding error.
    let value = if value.abs() < 1e-9 * (high - low).abs() { 0.0 } else { value };
    let magnitude = value.abs();
    if magnitude > 0.0 && !(1e-3..1e5).contains(&magnitude) {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

//! What the script of a page knows of a picture: its axes, and the points of its lines as numbers.

use serde::{Serialize, Serializer};

use super::{
    decimate::decimate,
    picture::{Axes, MAX_POINTS, Picture, PictureError, css_colour},
};

/// See `plot.js`, which reads it.
#[derive(Serialize)]
struct Lively<'a> {
    /// Left, top, right and bottom of the axes in the drawing.
    r#box: [i32; 4],
    x: Axis,
    y: Axis,
    /// Names of the axes.
    names: [&'a str; 2],
    lines: Vec<LivelyLine<'a>>,
    levels: &'a [(f64, String)],
    marks: &'a [(f64, String)],
}

/// From, to, and whether it is logarithmic.
#[derive(Serialize)]
struct Axis(f64, f64, bool);

#[derive(Serialize)]
struct LivelyLine<'a> {
    name: &'a str,
    colour: String,
    dots: bool,
    points: Vec<(Short, Option<Short>)>,
}

/// A number of six digits, the others of which nobody reads.
#[derive(Clone, Copy)]
struct Short(f64);

impl Serialize for Short {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(value) = *self;
        serializer.serialize_f64(format!("{value:.5e}").parse().unwrap_or(value))
    }
}

/// A drawing with a name for those who cannot see it, and more attributes.
pub(super) fn named(svg: &str, name: &str, more: &str) -> String {
    let label = maud::html! { (name) }.into_string().replace('"', "&quot;");
    svg.replacen("<svg ", &format!("<svg role=\"img\" {more}aria-label=\"{label}\" "), 1)
}

impl Picture {
    /// The drawing with its title for those who cannot see it, and what the script knows of it; names are those of
    /// the `whole` picture, of which this one may be without a legend.
    pub(super) fn to_lively_svg(
        &self,
        whole: &Self,
        width: u32,
        height: u32,
    ) -> Result<(String, String), PictureError> {
        let (svg, axes) = self.drawn(width, height)?;
        let json = serde_json::to_string(&whole.lively(axes));
        let data =
            json.map_err(|e| PictureError { title: self.title.clone(), reason: e.to_string() })?;
        Ok((named(&svg, &self.title, "tabindex=\"0\" "), data))
    }

    fn lively(&self, axes: Axes) -> Lively<'_> {
        let lines = self.lines.iter().enumerate().map(|(i, line)| LivelyLine {
            name: &line.name,
            colour: css_colour(i),
            dots: line.dots,
            points: self.points(&line.points),
        });
        Lively {
            r#box: axes.frame,
            x: Axis(axes.x.0, axes.x.1, self.log_x),
            y: Axis(axes.y.0, axes.y.1, self.log_y),
            names: [&self.x_label, &self.y_label],
            lines: lines.collect(),
            levels: &self.levels,
            marks: &self.marks,
        }
    }

    /// The points that are drawn, with a gap where a line is broken.
    fn points(&self, points: &[(f64, f64)]) -> Vec<(Short, Option<Short>)> {
        let mut shown = Vec::new();
        for run in self.runs(points) {
            if let (false, Some((x, _))) = (shown.is_empty(), run.first()) {
                shown.push((Short(*x), None));
            }
            let kept = decimate(run, MAX_POINTS).into_iter();
            shown.extend(kept.map(|(x, y)| (Short(x), Some(Short(y)))));
        }
        shown
    }
}

#[cfg(test)]
mod tests {
    use crate::{Line, Matrix, Page, Picture};

    #[test]
    fn a_page_has_the_numbers_of_its_pictures() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0 / 3.0)];
        let picture = Picture {
            title: "<heat> & \"flow\"".to_owned(),
            x_label: "time [s]".to_owned(),
            lines: vec![Line::new("measured", points)],
            ..Picture::default()
        };
        let mut page = Page::new("Run 7", "All is well.");
        page.picture(&picture, "").unwrap();
        let html = page.to_html();
        assert!(html.contains("aria-label=\"&lt;heat&gt; &amp; &quot;flow&quot;\""), "{html}");
        assert!(html.contains("[[0.0,1.0],[2.0,null],[2.0,0.333333]]"), "{html}");
    }

    #[test]
    fn a_matrix_has_a_name_as_well() {
        let names = || vec!["leak".to_owned()];
        let title = "who \"sees\" whom".to_owned();
        let matrix = Matrix { title, rows: names(), columns: names(), ..Matrix::default() };
        let mut page = Page::new("Run 7", "All is well.");
        page.matrix(&matrix, "").unwrap();
        assert!(page.to_html().contains("role=\"img\" aria-label=\"who &quot;sees&quot; whom\""));
    }
}

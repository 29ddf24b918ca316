//! Bars from 0 to 1 with their labels, and tables of shares, as HTML that fits any screen.

use maud::{Markup, html};

use super::inline::inline;

/// Horizontal bars.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// What they show.
    pub title: String,
    /// The bars, from above.
    pub bars: Vec<Bar>,
}

/// A bar from 0 to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bar {
    /// What it is of.
    pub label: String,
    /// Its length, cut off at 0 and 1.
    pub value: f64,
    /// An interval around its end.
    pub interval: Option<[f64; 2]>,
    /// The value in words.
    pub text: String,
    /// Whether it stands out.
    pub is_strong: bool,
}

impl Bar {
    /// A bar without an interval.
    ///
    /// ```
    /// use fd_report::Bar;
    ///
    /// assert_eq!(Bar::new("friction", 0.97, "0.97").interval, None);
    /// ```
    pub fn new(label: impl Into<String>, value: f64, text: impl Into<String>) -> Self {
        Self { label: label.into(), value, text: text.into(), ..Self::default() }
    }
}

/// A table of shares, such as a confusion matrix: the larger a share, the darker its cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shares {
    /// What it shows.
    pub title: String,
    /// What stands at the head of the column of row names.
    pub corner: String,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Names of the rows with their shares, one per column.
    pub rows: Vec<(String, Vec<f64>)>,
}

fn percent(share: f64) -> f64 {
    100.0 * share.clamp(0.0, 1.0)
}

impl Bars {
    pub(super) fn markup(&self) -> Markup {
        html! {
            @if !self.title.is_empty() { h3 { (self.title) } }
            div.bars {
                @for bar in &self.bars {
                    div.label { (inline(&bar.label)) }
                    div.track role="img" aria-label=(format!("{}: {}", bar.label, bar.text)) {
                        div class=(if bar.is_strong { "bar strong" } else { "bar" })
                            style=(format!("width:{:.1}%", percent(bar.value))) {}
                        @if let Some([low, high]) = bar.interval {
                            div.interval style=(format!(
                                "left:{:.1}%;width:{:.1}%",
                                percent(low),
                                percent(high) - percent(low)
                            )) {}
                        }
                    }
                    div.value { (bar.text) }
                }
            }
        }
    }
}

impl Shares {
    pub(super) fn markup(&self) -> Markup {
        html! {
            @if !self.title.is_empty() { h3 { (self.title) } }
            div.wide tabindex="0" {
                table.shares {
                    thead { tr {
                        th { (self.corner) }
                        @for column in &self.columns { th { (column) } }
                    } }
                    tbody {
                        @for (name, shares) in &self.rows {
                            tr {
                                td { (name) }
                                @for share in shares {
                                    @let alpha = 0.75 * share.clamp(0.0, 1.0);
                                    td style=(format!("background:rgba(0,114,178,{alpha:.2})")) {
                                        @if *share > 0.0 { (format!("{:.0}", percent(*share))) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

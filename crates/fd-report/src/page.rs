//! A report as one self-contained HTML page: no script, no font, no picture from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    bars::{Bars, Shares},
    matrix::Matrix,
    picture::{Picture, PictureError},
    table::Table,
};

/// Size of the pictures in the page, in pixels before scaling to the page.
const PICTURE_SIZE: (u32, u32) = (720, 400);
/// The same for pictures side by side, which a narrow screen shows one below the other.
const SMALL_SIZE: (u32, u32) = (460, 300);

/// A page under construction.
#[derive(Clone, Debug, Default)]
pub struct Page {
    title: String,
    headline: String,
    blocks: Vec<Block>,
}

#[derive(Clone, Debug)]
enum Block {
    Heading(String),
    Text(String),
    Picture { svg: String, caption: String },
    Gallery(Vec<Exhibit>),
    Matrix { svg: String, caption: String },
    Bars(Bars),
    Shares(Shares),
    Warning(String),
    Table(Table),
    Details { summary: String, text: String },
}

/// A picture of a gallery, with its legend and caption beside it, where a phone shows them large
/// enough.
#[derive(Clone, Debug)]
struct Exhibit {
    svg: String,
    legend: Vec<(String, String)>,
    caption: String,
}

impl Page {
    /// A page with its title and the one sentence that says what came out.
    ///
    /// ```
    /// # use fd_report::Page;
    /// assert!(Page::new("Run 7", "All is well.").to_html().contains("All is well."));
    /// ```
    #[must_use]
    pub fn new(title: impl Into<String>, headline: impl Into<String>) -> Self {
        Self { title: title.into(), headline: headline.into(), blocks: Vec::new() }
    }

    /// Begins a section.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a picture with a caption.
    ///
    /// # Errors
    ///
    /// Returns an error when the picture cannot be drawn.
    pub fn picture(
        &mut self,
        picture: &Picture,
        caption: impl Into<String>,
    ) -> Result<(), PictureError> {
        let svg = picture.to_svg(PICTURE_SIZE.0, PICTURE_SIZE.1)?;
        self.blocks.push(Block::Picture { svg, caption: caption.into() });
        Ok(())
    }

    /// Adds a matrix with a caption.
    ///
    /// # Errors
    ///
    /// Returns an error when the matrix cannot be drawn.
    pub fn matrix(
        &mut self,
        matrix: &Matrix,
        caption: impl Into<String>,
    ) -> Result<(), PictureError> {
        let svg = matrix.to_svg()?;
        self.blocks.push(Block::Matrix { svg, caption: caption.into() });
        Ok(())
    }

    /// Adds pictures with captions, side by side where the screen is wide enough.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn gallery(&mut self, pictures: &[(Picture, String)]) -> Result<(), PictureError> {
        let draw = |(picture, caption): &(Picture, String)| {
            Ok(Exhibit {
                svg: picture.without_legend().to_svg(SMALL_SIZE.0, SMALL_SIZE.1)?,
                legend: picture.legend(),
                caption: caption.clone(),
            })
        };
        let drawn: Result<Vec<_>, PictureError> = pictures.iter().map(draw).collect();
        self.blocks.push(Block::Gallery(drawn?));
        Ok(())
    }

    /// Adds bars.
    pub fn bars(&mut self, bars: Bars) {
        self.blocks.push(Block::Bars(bars));
    }

    /// Adds a table of shares.
    pub fn shares(&mut self, shares: Shares) {
        self.blocks.push(Block::Shares(shares));
    }

    /// Adds a sentence that nobody should miss.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Warning(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// Adds text that is folded away, such as a configuration.
    pub fn details(&mut self, summary: impl Into<String>, text: impl Into<String>) {
        self.blocks.push(Block::Details { summary: summary.into(), text: text.into() });
    }

    /// The page as an HTML document.
    #[must_use]
    pub fn to_html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    main {
                        h1 { (self.title) }
                        p.headline { (self.headline) }
                        @for block in &self.blocks { (block.markup()) }
                    }
                }
            }
        }
        .into_string()
    }
}

impl Block {
    fn markup(&self) -> Markup {
        match self {
            Self::Heading(text) => html! { h2 { (text) } },
            Self::Text(text) => html! { p { (text) } },
            Self::Picture { svg, caption } => html! {
                figure { (PreEscaped(svg)) figcaption { (caption) } }
            },
            Self::Matrix { svg, caption } => html! {
                figure { div.matrix { (PreEscaped(svg)) } figcaption { (caption) } }
            },
            Self::Gallery(pictures) => html! {
                div.gallery {
                    @for Exhibit { svg, legend, caption } in pictures {
                        figure {
                            (PreEscaped(svg))
                            div.legend {
                                @for (name, colour) in legend {
                                    span { i style=(format!("background:{colour}")) {} (name) }
                                }
                            }
                            figcaption { (caption) }
                        }
                    }
                }
            },
            Self::Bars(bars) => bars.markup(),
            Self::Shares(shares) => shares.markup(),
            Self::Warning(text) => html! { p.warning { (text) } },
            Self::Table(table) => html! {
                @if !table.title.is_empty() { h3 { (table.title) } }
                div.wide {
                    table {
                        thead { tr {
                            @for (i, cell) in table.header.iter().enumerate() {
                                th.text[table.is_text(i)] { (cell) }
                            }
                        } }
                        tbody {
                            @for row in &table.rows { tr {
                                @for (i, cell) in row.iter().enumerate() {
                                    td.text[table.is_text(i)] { (cell) }
                                }
                            } }
                        }
                    }
                }
            },
            Self::Details { summary, text } => html! {
                details { summary { (summary) } pre { (text) } }
            },
        }
    }
}

const STYLE: &str = "
:root { color-scheme: light; }
body { margin: 0; background: #f4f5f7; color: #1c1e21;
  font: 16px/1.5 system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif; }
main { max-width: 60rem; margin: 0 auto; padding: 1rem; background: #fff; }
h1, h2, h3, .headline { overflow-wrap: anywhere; }
h1 { font-size: 1.5rem; margin: .5rem 0; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; border-bottom: 1px solid #ddd; }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
.headline { font-size: 1.15rem; padding: .8rem 1rem; background: #eaf3fb; border-left: 4px solid #0072b2; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; }
figure .matrix { overflow-x: auto; }
figure .matrix svg { width: auto; max-width: none; }
figcaption { font-size: .9rem; color: #555; }
.gallery { display: grid; gap: .5rem 1.5rem;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); }
.gallery figure { margin: .5rem 0; min-width: 0; max-width: 36rem; }
.legend { display: flex; flex-wrap: wrap; gap: .1rem 1rem; font-size: .85rem; }
.legend i { display: inline-block; width: 1.1rem; height: .3rem; margin-right: .4rem;
  vertical-align: middle; border-radius: 2px; }
.warning { padding: .6rem 1rem; background: #fdf1e3; border-left: 4px solid #d55e00; }
.bars { display: grid; gap: .35rem .8rem; align-items: center; margin: .5rem 0;
  grid-template-columns: minmax(8rem, 18rem) 1fr minmax(4rem, max-content); font-size: .95rem; }
.bars .track { position: relative; height: 1.1rem; background: #eef0f3; border-radius: 3px; }
.bars .bar { height: 100%; background: #9cc3dd; border-radius: 3px; }
.bars .strong { background: #0072b2; }
.bars .interval { position: absolute; top: 40%; height: 20%; background: #1c1e21; min-width: 2px; }
.bars .value { font-variant-numeric: tabular-nums; white-space: nowrap; }
.bars .label { overflow-wrap: anywhere; }
@media (max-width: 36rem) {
  .bars { grid-template-columns: 1fr max-content; }
  .bars .label { grid-column: 1 / -1; margin-bottom: -.3rem; }
}
.shares td:not(:first-child), .shares th:not(:first-child) { text-align: center; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; border-bottom: 1px solid #e3e3e3; text-align: right; }
th:first-child, td:first-child, .text { text-align: left; }
th { background: #f7f7f8; }
pre { overflow-x: auto; background: #f7f7f8; padding: .8rem; font-size: .8rem; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
@media print { body { background: #fff; } }
";

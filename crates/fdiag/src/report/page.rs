//! A report as one self-contained HTML page: no script, no font, no picture from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    picture::{Picture, PictureError},
    table::Table,
};

/// Size of the pictures in the page, in pixels before scaling to the page.
const PICTURE_SIZE: (u32, u32) = (720, 400);

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
    Table(Table),
    Details { summary: String, text: String },
}

impl Page {
    /// A page with its title and the one sentence that says what came out.
    ///
    /// ```
    /// # use fdiag::report::Page;
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
            Self::Table(table) => html! {
                @if !table.title.is_empty() { h3 { (table.title) } }
                div.wide {
                    table {
                        thead { tr { @for cell in &table.header { th { (cell) } } } }
                        tbody {
                            @for row in &table.rows { tr { @for cell in row { td { (cell) } } } }
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
figcaption { font-size: .9rem; color: #555; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; border-bottom: 1px solid #e3e3e3; text-align: right; }
th:first-child, td:first-child { text-align: left; }
th { background: #f7f7f8; }
pre { overflow-x: auto; background: #f7f7f8; padding: .8rem; font-size: .8rem; }
details { margin: 1rem 0; }
summary { cursor: pointer; }
@media print { body { background: #fff; } }
";

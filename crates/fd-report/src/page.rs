//! A report as one self-contained HTML page: nothing in it is from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    bars::{Bars, Shares},
    inline::inline,
    lively::named,
    matrix::Matrix,
    picture::{Picture, PictureError},
    table::Table,
};

/// How it looks, light and dark.
const STYLE: &str = include_str!("page.css");
/// Values under the pointer, and zoom.
const SCRIPT: &str = include_str!("plot.js");

/// Size of the pictures in the page, in pixels before scaling to the page.
const PICTURE_SIZE: (u32, u32) = (560, 330);
/// The same for pictures side by side, which a narrow screen shows one below the other.
const SMALL_SIZE: (u32, u32) = (460, 300);

/// A page under construction.
#[derive(Clone, Debug, Default)]
pub struct Page {
    title: String,
    headline: String,
    blocks: Vec<Block>,
    files: Vec<String>,
    provenance: Vec<String>,
}

#[derive(Clone, Debug)]
enum Block {
    Heading(String),
    Text(String),
    Picture(Exhibit),
    Gallery(Vec<Exhibit>),
    Folded { summary: String, exhibits: Vec<Exhibit> },
    Matrix { svg: String, caption: String },
    Bars(Bars),
    Shares(Shares),
    Warning(String),
    Table(Table),
    Details { summary: String, text: String },
}

/// A drawing, and what the script knows of it.
#[derive(Clone, Debug)]
struct Plot {
    svg: String,
    data: String,
}

/// A picture with its legend and caption beside it, where a phone shows them large enough and no line is hidden.
#[derive(Clone, Debug)]
struct Exhibit {
    plot: Plot,
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
        Self { title: title.into(), headline: headline.into(), ..Self::default() }
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
        let exhibit = Exhibit::of(picture, caption.into(), PICTURE_SIZE)?;
        self.blocks.push(Block::Picture(exhibit));
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
        let svg = named(&matrix.to_svg()?, &matrix.title, "");
        self.blocks.push(Block::Matrix { svg, caption: caption.into() });
        Ok(())
    }

    /// Adds pictures with captions, side by side where the screen is wide enough.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn gallery(&mut self, pictures: &[(Picture, String)]) -> Result<(), PictureError> {
        self.blocks.push(Block::Gallery(Exhibit::all(pictures)?));
        Ok(())
    }

    /// Adds pictures with captions that are folded away until somebody wants them.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn folded(
        &mut self,
        summary: impl Into<String>,
        pictures: &[(Picture, String)],
    ) -> Result<(), PictureError> {
        let exhibits = Exhibit::all(pictures)?;
        self.blocks.push(Block::Folded { summary: summary.into(), exhibits });
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

    /// Names a file beside the page, which is linked at its end.
    pub fn file(&mut self, name: impl Into<String>) {
        self.files.push(name.into());
    }

    /// Says at the end where the page is from: a version, a command, an input with its hash.
    pub fn provenance(&mut self, line: impl Into<String>) {
        self.provenance.push(line.into());
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
                        p.headline { (inline(&self.headline)) }
                        @for block in &self.blocks { (block.markup()) }
                        (self.footer())
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
        .into_string()
        // Names of files and columns may hold what is no text, and what HTML does not allow.
        .replace(|c: char| c.is_control() && c != '\n' && c != '\t', "\u{fffd}")
    }

    fn footer(&self) -> Markup {
        html! {
            @if !self.files.is_empty() || !self.provenance.is_empty() {
                footer {
                    @if !self.files.is_empty() {
                        p {
                            "Beside this page: "
                            @for (i, name) in self.files.iter().enumerate() {
                                @if 0 < i { ", " }
                                a href=(name) { (name) }
                            }
                        }
                    }
                    @for line in &self.provenance { div { (inline(line)) } }
                }
            }
        }
    }
}

impl Plot {
    /// A picture as it is `drawn`, of which the script knows the names of the `whole` one.
    fn of(
        drawn: &Picture,
        whole: &Picture,
        (width, height): (u32, u32),
    ) -> Result<Self, PictureError> {
        let (svg, data) = drawn.to_lively_svg(whole, width, height)?;
        Ok(Self { svg, data })
    }

    fn markup(&self) -> Markup {
        html! { div.plot data-plot=(self.data) { (PreEscaped(&self.svg)) } }
    }
}

impl Exhibit {
    fn of(picture: &Picture, caption: String, size: (u32, u32)) -> Result<Self, PictureError> {
        let plot = Plot::of(&picture.without_legend(), picture, size)?;
        Ok(Self { plot, legend: picture.legend(), caption })
    }

    /// Pictures that stand side by side.
    fn all(pictures: &[(Picture, String)]) -> Result<Vec<Self>, PictureError> {
        let of =
            |(picture, caption): &(Picture, String)| Self::of(picture, caption.clone(), SMALL_SIZE);
        pictures.iter().map(of).collect()
    }

    fn markup(&self) -> Markup {
        html! {
            figure {
                (self.plot.markup())
                @if !self.legend.is_empty() {
                    div.legend {
                        @for (name, colour) in &self.legend {
                            span { i style=(format!("background:{colour}")) {} (name) }
                        }
                    }
                }
                figcaption { (inline(&self.caption)) }
            }
        }
    }
}

fn gallery(exhibits: &[Exhibit]) -> Markup {
    html! {
        div.gallery {
            @for exhibit in exhibits { (exhibit.markup()) }
        }
    }
}

impl Block {
    fn markup(&self) -> Markup {
        match self {
            Self::Heading(text) => html! { h2 { (text) } },
            Self::Text(text) => html! { p { (inline(text)) } },
            Self::Picture(exhibit) => exhibit.markup(),
            Self::Matrix { svg, caption } => html! {
                figure { div.matrix { (PreEscaped(svg)) } figcaption { (inline(caption)) } }
            },
            Self::Gallery(exhibits) => gallery(exhibits),
            Self::Folded { summary, exhibits } => html! {
                details { summary { (summary) } (gallery(exhibits)) }
            },
            Self::Bars(bars) => bars.markup(),
            Self::Shares(shares) => shares.markup(),
            Self::Warning(text) => html! { p.warning role="note" { (inline(text)) } },
            Self::Table(table) => html! {
                @if !table.title.is_empty() { h3 { (table.title) } }
                div.wide tabindex="0" {
                    table {
                        thead { tr {
                            @for (i, cell) in table.header.iter().enumerate() {
                                th.text[table.is_text(i)] scope="col" { (cell) }
                            }
                        } }
                        tbody {
                            @for row in &table.rows { tr {
                                @for (i, cell) in row.iter().enumerate() {
                                    td.text[table.is_text(i)] { (inline(cell)) }
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

//! Tables: one description, printed the same on the terminal and in the report.

use comfy_table::{CellAlignment, ContentArrangement, presets};
use serde::{Deserialize, Serialize};

/// A table of text, numbers already formatted with their units in the header.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Table {
    /// What the table shows.
    pub title: String,
    /// Column headers.
    pub header: Vec<String>,
    /// Rows, each as long as the header.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    ///
    /// ```
    /// # use fd_report::Table;
    /// let mut table = Table::new("Faults", &["sensor", "size [%]"]);
    /// table.push(["T7", "0.5"]);
    /// assert!(table.to_text(80).contains("T7"));
    /// ```
    #[must_use]
    pub fn new(title: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|text| (*text).to_owned()).collect();
        Self { title: title.into(), header, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push<S: Into<String>>(&mut self, row: impl IntoIterator<Item = S>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }

    /// Whether a column has words in it, and not only numbers.
    pub(super) fn is_text(&self, column: usize) -> bool {
        let is_number = |cell: &String| {
            cell.is_empty()
                || cell == "-"
                || cell.starts_with(|c: char| "+-<>(".contains(c) || c.is_ascii_digit())
        };
        !self.rows.iter().filter_map(|row| row.get(column)).all(is_number)
    }

    /// The table as text of at most `width` columns; all but the first column are set right.
    #[must_use]
    pub fn to_text(&self, width: u16) -> String {
        let mut table = comfy_table::Table::new();
        table
            .load_style(presets::UTF8_HORIZONTAL_ONLY)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(width)
            .set_header(&self.header);
        for row in &self.rows {
            table.add_row(row);
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        format!("{}\n{table}", self.title)
    }

    /// The header and the rows as Markdown, without the title; bars and HTML in cells are escaped.
    ///
    /// ```
    /// # use fd_report::Table;
    /// let mut table = Table::new("Faults", &["sensor", "size [%]"]);
    /// table.push(["a|b", "0.5"]);
    /// assert_eq!(table.to_markdown(), "| sensor | size [%] |\n|---|---|\n| a\\|b | 0.5 |\n");
    /// ```
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let line = |cells: &[String]| {
            let escaped: Vec<String> = cells.iter().map(|cell| markdown_text(cell)).collect();
            format!("| {} |\n", escaped.join(" | "))
        };
        let rule = format!("|{}\n", "---|".repeat(self.header.len()));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        line(&self.header) + &rule + &rows
    }
}

/// Text in Markdown that means nothing but itself: no HTML, no end of a cell or line.
///
/// ```
/// use fd_report::markdown_text;
///
/// assert_eq!(markdown_text("<b>a|b</b>\n# c < d"), "&lt;b>a\\|b&lt;/b> # c < d");
/// ```
#[must_use]
pub fn markdown_text(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut characters = text.chars().peekable();
    while let Some(character) = characters.next() {
        // Elsewhere `<` is a sign of mathematics, in Markdown too.
        let opens = |next: &char| next.is_ascii_alphabetic() || matches!(next, '/' | '!' | '?');
        match character {
            '<' if characters.peek().is_some_and(opens) => escaped.push_str("&lt;"),
            '|' => escaped.push_str("\\|"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

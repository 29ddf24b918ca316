//! Where results go: whole files only, and standard output for what was asked for.

use std::{
    cell::RefCell,
    fs,
    path::{Path, PathBuf},
};

use clap::Args;
use fd_report::{Page, Table};
use fdiag::model::file::write_atomically;
use serde::Serialize;

use crate::{
    bounds,
    failure::Failure,
    layout,
    provenance::provenance,
    say::{is_watched, remark, say},
};

/// Width of tables when the terminal does not say.
const DEFAULT_WIDTH: u16 = 110;

/// Where results go.
#[derive(Debug, Args)]
pub struct OutputArgs {
    /// Directory for the report; made if it is not there
    #[arg(long, value_name = "DIR", default_value = "fdiag-report")]
    pub out: PathBuf,
    /// Print the result as JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
}

/// A directory that results are written to. Directories that were made for results that never came
/// are removed again.
pub struct Output<'a> {
    directory: &'a Path,
    json: bool,
    /// Whether JSON is written without line breaks.
    compact: bool,
    /// Directories that were not there before, innermost first.
    made: Vec<&'a Path>,
    /// Names of files that were written, in order.
    written: RefCell<Vec<String>>,
}

impl Drop for Output<'_> {
    fn drop(&mut self) {
        for directory in &self.made {
            // Fails, as it should, when there is something in it.
            let _ = fs::remove_dir(directory);
        }
    }
}

impl<'a> Output<'a> {
    /// Makes the directory if needed, before any work is done for it.
    ///
    /// # Errors
    ///
    /// A directory that cannot be made.
    pub fn prepare(args: &'a OutputArgs) -> Result<Self, Failure> {
        let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let made: Vec<&Path> = args.out.ancestors().take_while(missing).collect();
        bounds::making(&made, || fs::create_dir_all(&args.out))
            .map_err(|e| Failure::output(&args.out, e))?;
        let (directory, json, written) = (&*args.out, args.json, RefCell::default());
        Ok(Self { directory, json, compact: false, made, written })
    }

    /// Writes JSON without line breaks, for data that are large and that nobody reads.
    #[must_use]
    pub fn compact(self) -> Self {
        let mut output = self;
        output.compact = true;
        output
    }

    /// Writes a file as a whole: it appears complete or not at all.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, name: &str, content: &str) -> Result<(), Failure> {
        let path = self.directory.join(name);
        let write = || write_atomically(&path, |out| out.write_all(content.as_bytes()));
        bounds::writing(write).map_err(|e| Failure::output(&path, e))?;
        self.written.borrow_mut().push(name.to_owned());
        Ok(())
    }

    /// Writes the page and its data, then prints tables or JSON. The page says at its end which files are beside it,
    /// and what it was made of: the `inputs`.
    ///
    /// # Errors
    ///
    /// A file that cannot be written, or standard output that takes nothing.
    pub fn finish(
        &self,
        headline: &str,
        tables: &[Table],
        page: Page,
        data: &impl Serialize,
        inputs: &[&Path],
    ) -> Result<(), Failure> {
        self.finish_as(headline, tables, page, self.as_json("report.json", data)?, inputs)
    }

    /// Data as the JSON that goes into a file of this name.
    ///
    /// # Errors
    ///
    /// Data that are no JSON.
    pub fn as_json(&self, name: &str, data: &impl Serialize) -> Result<String, Failure> {
        let refuse = |e| Failure::output(self.directory.join(name), e);
        layout::json(data, self.compact).map_err(refuse)
    }

    fn finish_as(
        &self,
        headline: &str,
        tables: &[Table],
        mut page: Page,
        json: String,
        inputs: &[&Path],
    ) -> Result<(), Failure> {
        self.write("report.json", &json)?;
        for name in self.written.borrow().iter() {
            page.file(name);
        }
        for line in provenance(inputs) {
            page.provenance(line);
        }
        self.write("report.html", &page.to_html())?;
        if self.json {
            say(&(json + "\n"))?;
        } else {
            say(&texts(headline, tables))?;
        }
        if is_watched() {
            let report = self.directory.join("report.html");
            remark(&format!("Report: {}", report.display()));
        }
        Ok(())
    }
}

fn texts(headline: &str, tables: &[Table]) -> String {
    let tables = tables.iter().map(|table| format!("\n{}\n", table.to_text(DEFAULT_WIDTH)));
    std::iter::once(format!("{headline}\n")).chain(tables).collect()
}
